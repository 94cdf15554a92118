"""Sentences of the first page never contradict the table below them: made-up lives."""

import re

import numpy as np
import pytest

from breaker.drive.life.first_page import headline, limit_words, look_first, since_new
from breaker.drive.life.limit_states import STATES
from tests.life.test_tables import tables
from tests.lives import a_life

LIVES = 30


def made_up(number):
    """A life in which limits are reached, or not, known well or badly, as of a number."""
    rng = np.random.default_rng(number)
    fails = rng.choice([40.0, 300.0, 450.0, 520.0, 600.0, 1500.0, np.inf], size=2)
    half, told = rng.choice([0.01, 0.1, 0.95], size=2), int(rng.choice([100, 100, 100, 1000]))
    life = a_life(tuple(fails), told=told, half=tuple(half), family=rng.choice(["", "any"]))
    if rng.random() < 0.3:  # work on the drive, after which what was exceeded is not any more
        life["work"][:] = True
    return life


def number_in(words):
    return float(words.replace(",", ""))


def contradictions(life, advice):
    """Pairs of sentences and cells that cannot both be true."""
    decisions, limits, changes = tables(life)
    row, found = decisions.iloc[-1], []
    first, rows = headline(decisions, limits), limit_words(limits).set_index("limit")
    states = dict(zip(limits.limit, limits.state, strict=True))
    said = "now" if first.startswith("Service now") else first.split()[0].strip(":").lower()
    most = max(states.values(), key=STATES.index)
    if said != most:
        found.append(f"{first} beside {states}")
    if "nothing leads to a limit" in first and "plan" in states.values():
        found.append(f"nothing leads to a limit, and {states}")
    if plan := re.match(
        r"Plan service by operation ([\d,]+)[^:]*: (\w+), .*left \((\S+) to", first
    ):
        by, limit, least = number_in(plan[1]), plan[2], plan[3]
        if by <= row.operation or by > row.operation + number_in(least) + 1.0:
            found.append(f"{first}: a plan outside of the life that is left")
        if f"({least} to" not in rows.loc[limit, "operations left (90 %)"]:
            found.append(f"{first} beside {rows.loc[limit, 'operations left (90 %)']}")
    cannot = re.findall(r"(\w+) \(P [^)]*\)", first.partition("Cannot tell ")[2])
    for name in cannot:
        if (
            states[name] != "unknown"
            or rows.loc[name, "operations left (90 %)"] != "cannot be told"
        ):
            found.append(f"{first} beside {rows.loc[name].to_dict()}")
    for name in re.findall(r"(\w+) \(certain at", first):
        if not rows.loc[name, "operations left (90 %)"].startswith("exceeded"):
            found.append(f"{first} beside {rows.loc[name].to_dict()}")
    if bool(look_first(decisions, limits, advice)) != (said in ("plan", "now")):
        found.append(f"{first} with other advice")
    risen = re.findall(r"([a-z ]+) [+-][\d.]+ % \([+-]", since_new(changes, life))
    if risen and (not life.attrs["family"] or changes.iloc[-1].noticed < life.attrs["told"]):
        found.append(f"parameters are told, and withheld: {risen}")
    return found


@pytest.fixture(scope="module")
def lives():
    return [made_up(number) for number in range(LIVES)]


def test_no_sentence_of_the_first_page_contradicts_its_table(lives, defaults):
    advice = dict.fromkeys(("travel_time", "gamma_a"), "look")
    each = {n: contradictions(life, advice) for n, life in enumerate(lives)}
    assert {n: found for n, found in each.items() if found} == {}


def test_made_up_lives_have_every_answer(lives):
    first = {headline(*tables(life)[:2]).split()[0] for life in lives}
    assert first == {"Service", "Plan", "Healthy:", "Unknown:"}
