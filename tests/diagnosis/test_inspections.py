"""Two inspections compared: measured, inferred by the networks of a family, as a document."""

from types import SimpleNamespace

import numpy as np
import pytest

from breaker.common.document import text_of
from breaker.diagnosis.changes import Pair, compare, measured_change, measured_changes
from breaker.diagnosis.explanations import Explanation
from breaker.diagnosis.inspection_change import inspection_change, words_of_change
from breaker.family.inputs import Basis
from breaker.family.membership import PARTS, Match
from breaker.family.shape import SHAPE_TIMES
from breaker.model.parameters import MOTIONS, NAMES
from breaker.model.quantities import quantities, speeds_of
from tests.raws import smooth

SPEEDS = speeds_of({"closing_speed_mean": ["10 % of stroke", "90 % of stroke"]})
WEAKER = [Explanation("drive", "f", 0.99), Explanation("none", "", 0.01)]


def records(motions=MOTIONS, count=2, **about):
    rng = np.random.default_rng(5)
    return {m: [smooth(rng, m, **about) for _ in range(count)] for m in motions}


def family(name="any", fits=1.0, **factors):
    """Networks that draw changes by factors, 1 % wide and of a single motion those given for it,
    and that fit by a p-value, openings by half of it; three of four draws of unchanged parameters
    are exactly the same, and all of mu. Draws of k_b are 20 % wide.
    """

    def draw(references, changed, draws, rng):
        assert references.keys() == changed.keys()
        alone = next(iter(references)) if len(references) == 1 else ""
        ratios = np.ones((draws, len(NAMES)))
        for k, parameter in enumerate(NAMES):
            factor = factors.get(f"{parameter}_{alone}", factors.get(parameter, 1.0))
            moved = (rng.random(draws) < 0.25 * (parameter != "mu")) | (factor != 1.0)
            width = 0.2 if parameter == "k_b" else 0.01
            drawn = factor * np.exp(width * rng.standard_normal(draws))
            ratios[:, k] = np.where(moved, drawn, 1.0)
        return np.log(ratios)[None], {"drag": np.full((1, draws), 0.03)}

    def match(motion, seen):
        p_value = fits * {"closing": 1.0, "opening": 0.5}[motion] * (seen.stroke[0] < 100.0)
        return Match(p_value, dict.fromkeys(PARTS, 1.0) | {"end": 3.0}, seen.way[0])

    basis = Basis(np.zeros(SHAPE_TIMES.size), np.eye(SHAPE_TIMES.size)[30:50], np.ones(20))
    state = SimpleNamespace(settings={"family": name}, match=match)
    return state, SimpleNamespace(change_bases=dict.fromkeys(MOTIONS, basis), draw=draw)


def document(*families, today=None, explanations=WEAKER, differences=()):
    before = records()
    pair = Pair.of(before, today or before)
    changes = compare(pair, families or [family()], np.random.default_rng(1))
    about = {"settings": {"seed": 1, "misfit_p_value": 0.001}, "rejected": ()}
    return inspection_change(pair, changes, explanations, SPEEDS, differences, (), **about)


def codes(sentences):
    return [sentence.code for sentence in sentences]


def test_changed_parameters_follow_measured_changes():
    result = document(family(f=0.9, k_a=1.045), today=records(slow=1.15))
    rows = {row.name: row for row in result.inferred}
    assert {name for name, row in rows.items() if row.changed} == {"f", "k_a", "drag"}
    assert [name for name in result.worse if name in rows] == ["f", "drag"]
    assert rows["f"].change == pytest.approx([-11.5, -10.0, -8.5], abs=0.3)
    assert (rows["f"].p_worse, rows["f"].p_unchanged) == (1.0, 0.0)
    assert rows["L"].p_unchanged == pytest.approx(0.75, abs=0.03)
    assert rows["mu"].p_unchanged == 1.0
    assert (rows["mu"].p_worse, rows["k_a"].p_worse) == (None, 0.0)
    # The records determine no change of what never changes, or is not narrow enough.
    assert {name for name, row in rows.items() if not row.identifiable} == {"mu", "k_b"}
    expected = ["measured-changed", "explained", "parameters-changed", "not-identifiable"]
    assert codes(result.summary) == expected
    assert "0.0 to 0.0" not in text_of(words_of_change(result))


@pytest.mark.parametrize(
    ("networks", "longer", "state"),
    [
        ([family("one"), family("two", 1e-5)], True, "outside_family"),
        ([family(gamma_b=1e36)], False, "beyond_wear"),
        ([family(f=0.9, f_closing=0.85, f_opening=1.0)], False, "operations_disagree"),
        ([family("one", 1e-4), family("two", 0.1, gamma_b=1.6)], False, "estimated"),
        ([family(f=0.9, f_closing=0.9, f_opening=0.91)], False, "estimated"),
    ],
)
def test_parameters_are_estimated_or_a_reason_is_given(networks, longer, state):
    """By the first family that fits both inspections."""
    result = document(*networks, today=records(stroke=120.0 if longer else 80.0))
    assert result.state == state
    assert bool(result.inferred) == (state == "estimated")
    code = [] if result.inferred else [f"{state.replace('_', '-')}-check"]
    assert codes(result.limitations) == code
    if state == "operations_disagree":
        assert result.agreement == {"p_value": pytest.approx(0.0), "parameter": "f"}
    if longer:
        assert "closing today" in result.limitations[0].values["outside"]
        assert "before" not in result.limitations[0].values["outside"]


@pytest.mark.parametrize(
    ("p_ratio", "state"), [(0.0, "estimated"), (0.3, "estimated"), (0.97, "different_setup")]
)
def test_another_ratio_has_its_share_of_the_draws(p_ratio, state):
    """A change of the drive is reported only where its interval excludes zero with them."""
    ratio = Explanation("ratio", "", p_ratio, [-6.5, -6.0, -5.5])
    result = document(family(f=0.9), explanations=[Explanation("drive", "f", 1 - p_ratio), ratio])
    assert result.state == state
    assert ("f" in result.worse) == (p_ratio == 0.0)
    if state == "different_setup":
        (difference,) = result.differences
        assert difference.values == {"today": pytest.approx(0.94)}
        return
    row = next(row for row in result.inferred if row.name == "f")
    assert row.p_unchanged == pytest.approx(p_ratio, abs=1e-3)
    assert row.if_changed == pytest.approx([-11.5, -10.0, -8.5], abs=0.3)


# ---- measured quantities -------------------------------------------------------------------------


@pytest.mark.parametrize(("sd", "changed"), [(0.42, False), (0.2, True)])
def test_an_interval_without_zero_is_no_change_where_no_change_is_likely(sd, changed):
    """As docs/understand/uncertainty.md states; the prior of no change is 0.9."""
    readings = [np.array([[value, sd]]) for value in (8.48, 10.12)]
    row = measured_change(quantities()["touch_time"], "closing", readings)
    assert min(row.change) > 0.0
    assert row.changed == changed
    assert (row.p_unchanged > 0.4) == (not changed)


def test_measured_changes_are_those_of_means():
    rng = np.random.default_rng(6)
    before = {"closing": [smooth(rng, noise=2e-4)]}
    today = {"closing": [smooth(rng, stroke=stroke, noise=2e-4) for stroke in (74.0, 75.0)]}
    rows = {row.name: row for row in measured_changes(Pair.of(before, today), SPEEDS)}
    # Nobody timed the contact. An over-travel of 0 is a value too.
    assert set(rows) == {"stroke", "travel_time", "over_travel", "closing_speed_mean"}
    stroke = rows["stroke"]
    assert stroke.difference == pytest.approx(-5.5, abs=0.02)
    # Operations are known to scatter by 0.4 % as from four records, and two of today do by 0.5 mm.
    scatter = np.sqrt((4 * 0.32**2 + 0.5) / 5)
    assert stroke.sd == pytest.approx(scatter * np.sqrt(1.5), rel=0.02)
    assert stroke.change == pytest.approx([-7.9, -6.875, -5.85], abs=0.1)
    assert (stroke.changed, stroke.p_worse) == (True, None)
    assert not rows["travel_time"].changed
    assert rows["closing_speed_mean"].p_worse > 0.9


@pytest.mark.parametrize(("before", "unit"), [(0.01, "mm"), (0.3, "%")])
def test_a_change_of_a_value_below_its_error_is_not_in_percent(before, unit):
    """From 0.01 or 0.3 mm to 0."""
    readings = [np.array([[value, 0.05]]) for value in (before, 0.0)]
    row = measured_change(quantities()["over_travel"], "closing", readings, 14.0)
    number, shown = row.shown[0].split()
    assert shown == unit
    assert float(number) == pytest.approx(-0.01 if unit == "mm" else -100.0)
