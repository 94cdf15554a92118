"""Table, alarms, first page, health and remaining lives agree, over whole lives.

Of many random lives: trends that rise, fall back after a repair, and are missing for a while,
limits exceeded from the start, records of one motion only, and few operations.
"""

import numpy as np
import pandas as pd
import pytest

from breaker.decisions.alarms import alarm_table
from breaker.decisions.states import health
from breaker.mechanism.parameters import MOTIONS
from breaker.model.randomness import generator
from tests.decisions.made_up import ALARM, INF, LIMITS, NAN, page_of, trend_of

NAMES = [limit.name for limit in LIMITS]
ALARM = ALARM | {"after": 3, "hold": 20}


def walk(rng, o):
    """Log odds to be beyond a limit over a life: from anywhere, mostly rising, perhaps repaired."""
    steps = rng.normal(rng.normal(0.02, 0.06), 0.3, o)
    odds = rng.choice([-8.0, -3.0, 0.0, 6.0]) + np.cumsum(steps)
    if rng.random() < 0.3:
        odds[rng.integers(o) :] -= 12.0
    return np.clip(odds, -12.0, 12.0)


def gaps(rng, values):
    """The same values with one stretch or none that is missing."""
    o = len(values)
    begin, length = rng.integers(o), rng.choice([0, o // 4, o])
    values = values.astype(float)
    values[begin : begin + length] = NAN
    return values


def life(number):
    """Single operations ``(o, 3)``, and trends by source."""
    rng = generator(1, "test", "whole life", number)
    o = int(rng.choice([1, 2, 5, 30, 100]))
    own, given = np.full((o, 3), NAN), {"beyond": {}, "toward": {}, "remaining": {}}
    for j, name in enumerate(NAMES):
        odds = walk(rng, o)
        own[:, j] = gaps(rng, 1 / (1 + np.exp(-odds - rng.normal(0, 1.0, o))))
        given["beyond"][name] = gaps(rng, 1 / (1 + np.exp(-odds)))
        given["toward"][name] = np.clip(0.95 + np.cumsum(rng.normal(0.0, 0.02, o)), 0, 1)
        median = np.maximum(-300.0 * odds, 0.0)[:, None] * rng.uniform(0.7, 1.3, (o, 1))
        quantiles = median * [0.5, 1.0, 2.0]
        given["remaining"][name] = np.where(quantiles > 900, INF, quantiles)
    numbers = np.cumsum(rng.integers(1, 4, o))
    if rng.random() < 0.5:
        return own, {"both": trend_of(MOTIONS, numbers, **given)}
    trends = {}
    for motion in MOTIONS:
        mine = [limit.name for limit in LIMITS if limit.motion == motion]
        part = {each: {n: v for n, v in of.items() if n in mine} for each, of in given.items()}
        trends[motion] = trend_of([motion], numbers, **part)
    if rng.random() < 0.5:  # no record of opening at all
        own[:, 2] = NAN
        for name in ("beyond", "toward", "remaining", "value"):
            trends["opening"][name][:] = NAN
    return own, trends


def told(own, trends):
    """All that is stored of a life, by name."""
    page = page_of(own, trends, alarm=ALARM)
    return {
        "health": health(page.judged, ALARM),
        "remaining": page.left.assign(told=page.judged.told),
        "decisions": page.rows.copy(),
        "alarms": alarm_table(page.judged, {each.name: each.motion for each in LIMITS}),
        "verdict": page.verdict,
    }


def contradictions(stored):
    """Where two of them do not say the same, in words."""
    found = set()

    def check(holds, words):
        if not np.all(holds):
            found.add(words)

    health, left, rows = stored["health"], stored["remaining"].told, stored["decisions"]
    page, alarms = stored["verdict"], stored["alarms"]
    numbers, state = health.operation.values, health.state.values
    since = np.full(health.exceeded.shape, NAN)
    for row in alarms.itertuples():
        ends = numbers[-1] if pd.isna(row.to_operation) else row.to_operation
        inside = (numbers >= row.from_operation) & (numbers <= ends)
        since[inside, NAMES.index(row.limit)] = row.from_operation
    over = np.isfinite(since)
    check(over == health.exceeded.values, "spells of the alarms are those exceeded")
    check((state == "now") == over, "now is exceeded")
    low, middle, high = left.transpose("quantile", "operation", "limit").values
    check((high[over] == 0) & (low[over] == 0), "nothing is left of what is exceeded")
    check(np.isnan(middle) == np.isin(state, ["healthy", "unknown"]), "no trend, nothing told")
    check(np.isfinite(low) == np.isin(state, ["plan", "now"]), "plan is within the horizon")
    check((low <= middle) | np.isnan(middle), "quantiles rise")
    check(health.drive_state.values == rows.state.values, "state of the drive")
    check((rows.state == "now").values == over.any(axis=1), "a drive is as its worst limit")
    check((rows.action == "service").values == over.any(axis=1), "service what is exceeded")
    for i, row in enumerate(rows.itertuples()):
        words = {f"{NAMES[j]} since {since[i, j]:.0f}" for j in np.flatnonzero(over[i])}
        check(set(filter(None, row.exceeded.split("; "))) == words, "exceeded, in the table")
        if row.action == "service":
            check(over[i, NAMES.index(row.limit)], "the limit of a service is exceeded")
            check(row.service_by <= numbers[i], "service is due")
        if row.limit:
            j = NAMES.index(row.limit)
            own = [low[i, j], middle[i, j], high[i, j]]
            each = [row.operations_left_5, row.operations_left, row.operations_left_95]
            check(np.array_equal(np.round(own), each, equal_nan=True), "operations left")
        for j in np.flatnonzero(state[i] == "unknown"):
            check(f"{NAMES[j]} (" in row.trust, "what cannot be told is named")
    last = since[-1]
    for name in ("since", "state"):
        check(
            [str(each) for each in page[name].values]
            == [str(each) for each in (last if name == "since" else state[-1])],
            f"{name}, on the first page",
        )
    check(np.array_equal(health.since, last, equal_nan=True), "since, of health")
    check(np.array_equal(page.remaining, left[-1], equal_nan=True), "what is left, at the end")
    for j in np.flatnonzero(over[-1]):
        check(f"{NAMES[j]}" in page.headline and f"{last[j]:,.0f}" in page.headline, "headline")
    return found


def test_whole_lives_agree():
    seen = set()
    for number in range(25):
        stored = told(*life(number))
        assert contradictions(stored) == set(), number
        seen |= set(stored["health"].state.values.ravel()) | set(stored["decisions"].action)
        ends = stored["alarms"].to_operation.isna()
        seen |= {"lasts"} if ends.any() else set()
        seen |= {"cleared"} if (~ends).any() else set()
    expected = {"unknown", "healthy", "drifting", "plan", "now", "lasts", "cleared"}
    assert seen >= expected | {"none", "check", "service"}


def first_since(stored):
    """The date of one limit for all of them."""
    stored["verdict"]["since"][:] = stored["health"].since.min()


def trend_alone(stored):
    """What single operations told is left out of one place."""
    beyond = stored["health"].trend_probability.values
    stored["health"]["exceeded"][:] = beyond >= 0.95


def raw_lives(stored):
    """Remaining lives as the trend says them, also where the limit is exceeded."""
    stored["remaining"]["told"] = stored["remaining"].remaining


def late_rows(stored):
    """The table lags by an operation."""
    rows = stored["decisions"]
    rows[["state", "action"]] = rows[["state", "action"]].shift(fill_value="")


def longer_alarms(stored):
    """Spells that never end."""
    stored["alarms"]["to_operation"] = None


def other_limit(stored):
    """What is left to another limit than the one that is named."""
    rows = stored["decisions"]
    rows["limit"] = [NAMES[NAMES.index(n) - 1] if n else "" for n in rows.limit]


def no_doubts(stored):
    """Limits that cannot be told are passed over."""
    stored["decisions"]["trust"] = ""


@pytest.mark.parametrize(
    "fault",
    [first_since, trend_alone, raw_lives, late_rows, longer_alarms, other_limit, no_doubts],
)
def test_planted_contradictions_are_found(fault):
    for number in range(30):
        stored = told(*life(number))
        fault(stored)
        if contradictions(stored):
            return
    pytest.fail("not found in any of thirty lives")
