"""Two visits compared: measured, inferred by the networks of a family, as a document, in words."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from breaker.common.document import text_of
from breaker.common.plain_values import plainly
from breaker.diagnosis.changes import (
    VERDICT_WORDS,
    QuantityChange,
    compare,
    measured_changes,
    visit_error,
    with_explanations,
)
from breaker.diagnosis.explanations import Explanation, otherwise_measured
from breaker.diagnosis.identity import Difference
from breaker.diagnosis.inspection_change import (
    Agreement,
    ComparisonSettings,
    visits_document,
    words_of_visits,
)
from breaker.diagnosis.visit_comparison import judged_today
from breaker.family.inputs import Basis
from breaker.family.membership import PARTS, Match
from breaker.family.networks import ChangeDraws, StateDraws
from breaker.family.shape import SHAPE_TIMES
from breaker.model.limits import from_list
from breaker.model.parameters import MOTIONS, NAMES
from breaker.model.quantities import speeds_of
from breaker.records.contacts import ContactTimes
from tests.raws import raw_of, smooth

SPEEDS = speeds_of({"closing_speed_mean": ["10 % of stroke", "90 % of stroke"]})


def records(motions=MOTIONS, count=2, **about):
    rng = np.random.default_rng(5)
    return {m: [smooth(rng, m, **about) for _ in range(count)] for m in motions}


def family(name="any", fits=1.0, later=0.0, **factors):
    """Networks that draw changes by factors, 1 % wide and of a single motion those given for it,
    and that fit by a p-value, openings by half of it; three of four draws of what has not changed
    are exactly the same, and all of mu. By a single motion, contacts come later by twice as much.
    """

    def draw(references, changed, draws, rng):
        assert references.keys() == changed.keys()
        alone = next(iter(references)) if len(references) == 1 else ""
        ratios = np.ones((draws, len(NAMES)))
        for k, parameter in enumerate(NAMES):
            factor = factors.get(f"{parameter}_{alone}", factors.get(parameter, 1.0))
            changes = (rng.random(draws) < 0.25 * (parameter != "mu")) | (factor != 1.0)
            ratios[:, k] = np.where(
                changes, factor * np.exp(0.01 * rng.standard_normal(draws)), 1.0
            )
        by = later * (1 + bool(alone))
        return ChangeDraws(ratios, {m: np.full(draws, by) for m in references})

    def match(motion, seen):
        p_value = fits * {"closing": 1.0, "opening": 0.5}[motion] * (seen.stroke[0] < 100.0)
        return Match(p_value, dict.fromkeys(PARTS, 1.0) | {"end": 3.0}, seen.way[0])

    def state(references, draws, rng):
        release, switching = ({m: np.full(draws, at) for m in references} for at in (-2.0, 8.0))
        return StateDraws(np.ones((draws, 7)), release, switching)

    basis = Basis(np.zeros(SHAPE_TIMES.size), np.eye(SHAPE_TIMES.size)[30:50], np.ones(20))
    usual = np.log([[8.0, 1.0], [5.0, 1.0]])
    levels = SimpleNamespace(settings={"family": name}, usual=usual, match=match, draw=state)
    return levels, SimpleNamespace(change_bases=dict.fromkeys(MOTIONS, basis), draw=draw)


def document(*families, before=None, today=None, beyond=0.05, rejected=(), **more):
    before = before or records()
    today = today or records(before)
    found = compare(before, today, families or [family()], np.random.default_rng(1))
    explanations = more.get("explanations", [])
    if explanations:
        found = with_explanations(found, explanations)
    return visits_document(
        found,
        measured_changes(before, today, SPEEDS, beyond),
        [*more.get("differences", []), *otherwise_measured(explanations)],
        ComparisonSettings(beyond, 1, 0.001),
        limits=plainly(judged_today(found, today, more.get("limits", ()), SPEEDS, 1)),
        records={m: {"before": len(before[m]), "today": len(today[m])} for m in before},
        rejected=rejected,
    )


def inferred(found):
    return {row.name: row for row in found.changes if row.kind != "measured"}


def row(name, kind, worse, verdict=VERDICT_WORDS[0]):
    about = dict.fromkeys(("unit", "meaning", "motion"), "") | dict.fromkeys(
        ("change", "if_changed"), [0.0] * 3
    )
    about |= dict.fromkeys(("unchanged", "beyond", "more", "less"), 0.5)
    return QuantityChange(name=name, kind=kind, worse=worse, verdict=verdict, **about)


@pytest.mark.parametrize(
    ("state", "differences", "measured", "names"),
    [
        ("told", [], VERDICT_WORDS[0], ["travel_time", "f", "drag"]),
        ("told", [], VERDICT_WORDS[1], []),  # no parameter but beside what is measured
        ("apart", [], VERDICT_WORDS[0], ["travel_time"]),
        ("unlike", ["stroke"], VERDICT_WORDS[0], []),
    ],
)
def test_what_is_worse_is_named_as_far_as_the_headline_tells_it(
    state, differences, measured, names
):
    rows = [row("travel_time", "measured", 1.0, measured), row("f", "parameter", 0.99)]
    rows += [row("opening_over_travel", "measured", 0.0), row("k_a", "parameter", 0.01)]  # better
    rows = [
        each for each in rows if each.name != "opening_over_travel" or measured == VERDICT_WORDS[0]
    ]
    rows.append(row("L", "parameter", 0.6, VERDICT_WORDS[1]))
    mechanisms = [row("drag", "mechanism", None), row("build_up", "mechanism", None, "no")]
    about = {"parameters": state, "differences": differences}
    found = replace(document(), changes=rows, mechanisms=mechanisms, **about)
    assert found.worse == names


def test_what_changed_follows_what_is_measured():
    slower = {"today": records(slow=1.15)}
    found = document(family(f=0.9, later=2.0, k_b=1.045), **slower)
    rows = inferred(found)
    assert {name for name, row in rows.items() if row.verdict == VERDICT_WORDS[0]} == {
        "f",
        "k_b",
        "touch_after_release",
        "separation_after_release",
    }
    assert rows["touch_after_release"].change == pytest.approx([20.0] * 3, abs=0.5)
    assert rows["k_b"].beyond < 0.5  # it changed, and whether that matters is for a limit
    assert rows["f"].change == pytest.approx([-11.5, -10.0, -8.5], abs=0.3)
    assert rows["f"].less == rows["f"].beyond == rows["f"].worse == 1.0
    assert rows["f"].unchanged == 0.0
    assert rows["L"].unchanged == pytest.approx(0.75, abs=0.03)
    assert rows["mu"].unchanged == 1.0
    assert (rows["mu"].worse, rows["k_b"].worse) == (None, 0.0)
    assert document(family(f=0.9)).worse == []  # nothing measured has changed


def test_the_first_family_that_fits_both_visits_answers():
    opened = []

    def families():
        for each in (family("first", 1e-4), family("second", 0.1), family("third")):
            opened.append(each[0].settings["family"])
            yield each

    found = document(*families(), before=records(["opening"]))
    assert found.family == "second"
    lazy = compare(records(), records(), families(), np.random.default_rng(1))
    assert (lazy.family, opened[3:]) == ("second", ["first", "second", "third"])

    def usual():
        yield family("first", 0.9)
        raise AssertionError("no other family has to be opened")

    assert compare(records(), records(), usual(), np.random.default_rng(1)).family == "first"


def test_parameters_of_a_drive_of_no_family_are_withheld():
    longer = records(stroke=120.0)
    found = document(family("one"), family("two", 1e-5), today=longer)
    assert (found.parameters, inferred(found)) == ("withheld", {})
    (odd,) = found.trust
    found = document(family("one"), family("two", 1e-5), before=longer, today=longer)
    assert (found.parameters, inferred(found)) == ("withheld", {})
    assert "the closing today (p < 0.0001, most at its end), the opening today" in odd
    assert "the closing before" not in odd


def test_what_files_state_differently_is_a_difference():
    found = document(family(f=0.9), differences=[Difference("phase", "", "", "A", "B")])
    assert (found.parameters, inferred(found), found.reported) == ("unlike", {}, [])
    assert found.warnings


@pytest.mark.parametrize(
    ("p_ratio", "state", "unchanged", "reported"),
    [(0.0, "told", 0.0, True), (0.3, "told", 0.3, False), (0.97, "unlike", None, False)],
)
def test_another_ratio_has_its_share_of_the_draws(p_ratio, state, unchanged, reported):
    """A change of the drive is reported only where its interval excludes zero with them."""
    explanations = [
        Explanation("drive", "f", 1.0 - p_ratio, [-9.0, -8.0, -7.0]),
        Explanation("ratio", "", p_ratio, [-6.5, -6.0, -5.5]),
        Explanation("none", "", 0.0, [0.0] * 3),
    ]
    found = document(family(f=0.9, later=2.0), explanations=explanations)
    assert found.parameters == state
    assert [each.name == "f" for each in found.reported].count(True) == reported
    if unchanged is not None:
        row = inferred(found)["f"]
        assert row.unchanged == pytest.approx(unchanged, abs=1e-3)
        assert row.if_changed == pytest.approx([-11.5, -10.0, -8.5], abs=0.3)
        assert found.explanations[0].change == pytest.approx(row.if_changed, abs=0.1)
    else:
        assert [each.today for each in found.differences] == [pytest.approx(0.94)]


def test_limits_are_judged_by_the_second_visit():
    entries = [
        {"quantity": "stroke", "motion": "closing", "reference": 80, "tolerance": "5 %"},
        {"quantity": "travel_time", "motion": "opening", "reference": 5, "tolerance": 1},
        {"name": "late", "motion": "closing", "of": "record", "upper": {"touch_time": 5}},
        {"name": "gap", "motion": "closing", "upper": {"L": 5}},
        {"quantity": "f", "of": "change", "reference": 0, "tolerance": "5 %"},
    ]
    limits = from_list(entries, MOTIONS, SPEEDS)
    found = document(family(f=0.9), today=records(stroke=80.8), limits=limits)
    rows = {row.name: row for row in found.limits}
    verdicts = {name: row.verdict for name, row in rows.items()}
    none = dict.fromkeys(("late", "gap"), "inconclusive")
    assert verdicts == {"stroke": "pass", "travel_time": "fail", **none, "f": "fail"}
    (part,) = rows["stroke"].parts
    assert (part.value, part.bounds) == (pytest.approx(80.8, abs=0.1), [76.0, 84.0])
    assert rows["late"].reason.text
    assert "80 ± 4" in text_of(words_of_visits(found))


def test_a_change_beyond_any_wear_is_not_told():
    found = document(family(gamma_b=1e36))
    assert (found.parameters, inferred(found)) == ("beyond", {})
    assert document(family(gamma_b=1.6)).parameters == "told"


def test_motions_that_contradict_each_other_are_told_apart():
    found = document(family(f=0.9, f_closing=0.85, f_opening=1.0, later=2.0))
    assert found.parameters == "apart"
    assert found.agreement == Agreement(pytest.approx(0.0), "f")
    assert "(f, p < 0.0001)" in found.trust[1]
    both = [row for row in found.changes if row.name == "f"]
    assert [row.motion for row in both] == list(MOTIONS)
    assert [row.verdict for row in both] == ["changed", "did not change"]
    assert inferred(found)["touch_after_release"].change == pytest.approx([40.0] * 3)
    # One that differs by less than both are wide is told of both together.
    assert document(family(f=0.9, f_closing=0.9, f_opening=0.91)).parameters == "told"


def test_measured_changes_are_those_of_means():
    rng = np.random.default_rng(6)
    before = {"closing": [smooth(rng, noise=2e-4)]}
    today = {"closing": [smooth(rng, stroke=stroke, noise=2e-4) for stroke in (74.0, 75.0)]}
    rows = {row.name: row for row in measured_changes(before, today, SPEEDS)}
    # Nobody timed the contact; that nothing goes beyond its rest is a value too.
    assert set(rows) == {"stroke", "travel_time", "over_travel", "closing_speed_mean"}
    stroke = rows["stroke"]
    assert stroke.difference == pytest.approx(-5.5, abs=0.02)
    # Operations are known to scatter by 0.4 % as from four records, and two of today do by 0.5 mm.
    scatter = np.sqrt((4 * 0.32**2 + 0.5) / 5)
    assert stroke.sd == pytest.approx(scatter * np.sqrt(1.5), rel=0.02)
    assert stroke.change == pytest.approx([-7.9, -6.875, -5.85], abs=0.1)
    assert stroke.beyond == stroke.less == pytest.approx(0.9985, abs=0.001)
    assert (stroke.verdict, stroke.worse) == ("changed", None)
    assert rows["travel_time"].verdict == "did not change"
    assert rows["closing_speed_mean"].worse > 0.9


def test_a_way_past_the_rest_changes_in_shares_of_itself_and_a_late_touch_is_worse():
    """And by less than 1 % of the stroke, it does not."""
    rng, time = np.random.default_rng(7), np.arange(0.0, 80.0, 0.1)

    def visit(over, touch):
        rise = np.clip((time - 20.0) / 15.0, 0.0, 1.0)
        way = rise**2 * (3.0 - 2.0 * rise) + over * np.exp(-np.square((time - 40.0) / 3.0))
        raw = raw_of(80.0 * way + 0.02 * rng.standard_normal(time.size), 0.1, 19.0)
        return {"closing": [replace(raw, contact=ContactTimes(touch, 0.1))]}

    rows = measured_changes(visit(0.2, 29.0), visit(0.1, 31.0), SPEEDS)
    touch, over = (next(e for e in rows if e.name == f) for f in ("touch_time", "over_travel"))
    assert over.change[1] == pytest.approx(-50.0, abs=0.5)
    assert (over.verdict, over.worse) == ("changed", pytest.approx(0.0, abs=0.01))
    assert touch.worse == pytest.approx(1.0 - touch.unchanged, abs=1e-3)
    assert touch.sure
    rows = measured_changes(visit(0.002, 29.0), visit(0.004, 29.0), SPEEDS)
    (over,) = (row for row in rows if row.name == "over_travel")
    assert over.verdict == "did not change"


def test_means_are_known_no_better_than_their_readings():
    """However little 40 of them scatter: what is stated of each counts."""
    visit = np.tile([1.0, 0.3], (40, 1))
    assert visit_error([visit, visit], 0.01) == pytest.approx(0.3 * np.sqrt(2 / 40))
