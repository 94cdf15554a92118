"""The simulated endurance test: its drive, its wear, its truth and its records."""

import numpy as np
import pytest

from breaker.configuration.data_files import simulated_test
from breaker.family.endurance import EnduranceTest
from breaker.family.endurance_truth import failure_times, truth_of
from breaker.model.curves import travel
from breaker.model.limits import Limit, from_list
from breaker.model.parameters import MOTIONS, NAMES
from studies.measuring import own_quantities

TIMES = np.linspace(-2.0, 58.0, 151)


@pytest.fixture(scope="module")
def life(defaults) -> EnduranceTest:
    return EnduranceTest.from_settings(simulated_test(defaults), 1)


@pytest.fixture(scope="module")
def truth(life):
    return truth_of(life, MOTIONS, TIMES)


def test_wear_is_linear_up_to_the_knee_and_faster_after_it(life):
    wear, operations = life.settings["wear"], np.arange(1, 2001, 50)
    for name, change in wear["change"].items():
        new = life.new.value(name)
        values = [life.worn(int(k), scatter=False).value(name) for k in (*operations, 2000)]
        steps = np.diff(values[:-1]) / new
        assert np.ptp(steps[operations[1:] <= wear["knee"] * 2000]) < 1e-12
        assert steps[-1] == pytest.approx(wear["faster"] * steps[0])
        assert values[-1] / new - 1.0 == pytest.approx(change)


def test_truth_is_the_worn_drive(life, truth, defaults):
    assert truth["parameter"].values.tolist() == list(NAMES)
    np.testing.assert_array_equal(truth["operation"], np.arange(1, 2001))
    np.testing.assert_array_equal(truth.value[1233], life.worn(1234, scatter=False).theta)
    drive = life.worn(1760, scatter=False)  # where the wear changes; others are interpolated
    exact = travel(np.array([drive.theta]), TIMES, "opening").travel[0]
    off = np.abs(drive.travel("opening", TIMES) - exact).max()
    assert truth.difference.sel(operation=1760, motion="opening") == pytest.approx(off, abs=1e-12)
    failures = failure_times(truth, from_list(defaults["limits"], list(MOTIONS)))
    assert len(failures) >= 5
    assert all(1800 < at < 2000 for at in failures.values())  # once the wear is faster


def test_truth_of_what_records_show(life, truth):
    """Between stages, too, beside the drive's own motion; a rest that is crept to is seen early."""
    assert truth.measured.dims == ("operation", "motion", "quantity")
    names = {"closing": ["closing_speed"], "opening": ["opening_over_travel", "opening_speed"]}
    for operation in (1, 333, 1777, 2000):
        drive = life.worn(operation, scatter=False)
        for motion in MOTIONS:
            own = own_quantities(drive, motion)
            for name in ("stroke", "travel_time", *names[motion]):
                seen = truth.measured.sel(operation=operation, motion=motion, quantity=name)
                assert seen == pytest.approx(own[name], rel=0.005, abs=0.04), (operation, name)
    assert np.isnan(truth.measured.sel(quantity="reaction_time")).all()
    for motion in MOTIONS:  # the contact's time is known
        wipe = truth.measured.sel(quantity=f"{motion}_wipe")
        assert (wipe.sel(motion=motion) > 0.5).all()
    never = Limit("latch", "closing", (("reaction_time", 1.0, True),), of="record")
    assert np.isnan(failure_times(truth, [never])["latch"])
