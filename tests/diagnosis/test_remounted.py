"""What a transducer that was mounted again shows between two visits is none of the drive's."""

from types import SimpleNamespace

import numpy as np
import pytest

from breaker.diagnosis.reading import read_operations
from breaker.diagnosis.remounting import slack_between
from breaker.diagnosis.session import Diagnosis
from breaker.family.exports import write_curve
from breaker.model.curves import travel
from breaker.model.parameters import MOTIONS
from breaker.records.operations import Operation

TIME = 0.1 * np.arange(760)  # ms


def visit(folder, theta, rng, *, slack=0.0, zero=0.0):
    """Records of a visit, three of each motion, with a slack of the transducer and its zero, mm."""
    folder.mkdir()
    operations = {motion: [] for motion in MOTIONS}
    for motion, some in operations.items():
        for number in (1, 2, 3):
            way = travel(theta[None], TIME, motion, onset=10.0).travel[0]
            gone = way if motion == "closing" else way[0] - way
            hidden = np.exp(-((gone / (2.0 * slack)) ** 2)) if slack else 0.0
            shown = gone * (1.0 - hidden)
            shown = (shown if motion == "closing" else way[0] - shown) + zero
            file = folder / f"{motion}_{number}.csv"
            noisy = shown + 0.05 * rng.standard_normal(TIME.size)
            write_curve(file, TIME, noisy, motion=motion, operation=number)
            some.append(Operation(number, file, phase="L1"))
    return read_operations(operations, {"zero": "rest"})


@pytest.fixture
def between(tmp_path, prior, defaults):
    def found(change=(), **today):
        rng, theta = np.random.default_rng(1), prior.medians.copy()
        before = visit(tmp_path / "before", theta, rng)
        for place, factor in change:
            theta[place] *= factor
        return Diagnosis(defaults).compare(
            {"before": before, "today": visit(tmp_path / "today", theta, rng, **today)}
        )

    return found


def test_slack_of_the_transducer_is_no_change_of_the_drive(between):
    found = between(slack=0.4)
    assert [each.motion for each in found.differences] == [*MOTIONS]
    assert len(found.warnings) == 1
    assert {row.kind for row in found.changes} == {"measured"}


@pytest.mark.parametrize("change", [(), [(3, 1.25)], [(5, 0.97), (4, 1.5)], [(1, 0.9)]])
def test_wear_is_no_slack(between, change):
    """Planted: friction, force, contact and opening spring, at noise that shows each."""
    assert not any("slack" in each.what for each in between(change).differences)


def test_a_start_that_takes_longer_is_no_slack(tmp_path, prior, defaults):
    """It is what a force does that builds up later, which is of the drive."""
    rng, theta = np.random.default_rng(1), prior.medians.copy()
    visits = {
        name: visit(tmp_path / name, theta, rng, slack=slack)
        for name, slack in (("before", 0.4), ("today", 0.0))
    }
    found = Diagnosis(defaults).compare(visits)
    assert not any("slack" in each.what for each in found.differences)


def test_another_zero_is_said_and_changes_nothing_else(between):
    found = between(zero=5.0)
    (said,) = (each for each in found.trust if "the transducer is mounted elsewhere" in each)
    assert "is at 5.1 mm" in said
    assert (found.differences, found.warnings) == ([], [])


@pytest.mark.parametrize(("whole", "told"), [(0.0, True), (1.5, False)])
def test_a_later_start_that_the_contact_makes_up_for_is_slack(whole, told):
    """Of one motion, by trigger and contact: a slower latch would make the whole longer, too."""
    raw = SimpleNamespace(moves=10.0, first_motion_sd=0.1)
    record = SimpleNamespace(motion="closing", tenth=12.0, raw=raw)
    later = {"reaction_time": 1.5, "touch_time": whole - 1.5, "closing_time": whole}
    rows = [
        SimpleNamespace(name=name, motion="closing", before=20.0, difference=by, sd=0.1)
        for name, by in later.items()
    ]
    assert bool(slack_between({"before": [record], "today": [record]}, rows)) == told
