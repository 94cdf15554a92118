"""Faults of judged rigs: sized as they say, and noticed or not."""

import numpy as np
import pytest

from breaker.mechanism.parameters import NAMES
from breaker.model.joint import Model
from breaker.synthetic.drive import Drive, Elements, Stop
from breaker.synthetic.judged import family_of
from breaker.synthetic.judged_power import FAULTS, bounce_time, factors_of, judge_power
from breaker.synthetic.learning import ensemble, learn

TIMES = np.linspace(0.0, 60.0, 3001)


@pytest.fixture(scope="module")
def drive():
    elements = Elements(restitution=0.05, opening_stop=Stop(3.0, 0.3, 1.0, 0.5, 0.1))
    return Drive((2.0, 0.045, 0.040, 0.30, 0.12, 0.75, 10.0), elements)


def with_factors(drive, fault):
    by = factors_of(drive, fault)
    return drive.changed(**{name: factor * drive.value(name) for name, factor in by.items()})


def test_faults_are_sized_by_what_they_do(drive):
    rebound = [
        -each.travel("opening", TIMES).min()
        for each in (drive, with_factors(drive, "1 mm more rebound"))
    ]
    assert np.diff(rebound)[0] == pytest.approx(1.0, abs=1e-3)
    bouncing = with_factors(drive, "2 ms of bounce")
    assert bounce_time(drive) < 1.0
    assert bounce_time(bouncing) == pytest.approx(2.0, abs=0.1)  # it ends in steps
    assert bouncing.elements.restitution > drive.elements.restitution
    halved = with_factors(drive, "opening damper halved")
    assert halved.elements.opening_stop.damping == pytest.approx(0.15)
    assert with_factors(drive, "5 % less force").theta[NAMES.index("f")] == pytest.approx(0.7125)
    assert with_factors(drive, "nothing") == drive


def test_bounce_follows_the_speed_of_the_touch(drive):
    """A first flight of ``2 e v / a``: nearly so, as the spring's force grows meanwhile."""
    times = [bounce_time(drive.changed(restitution=e)) for e in (0.0, 0.05, 0.1, 0.2)]
    assert times[0] == 0.0
    assert np.all(np.diff(times) > 0)


def test_faults_that_cannot_be_made_are_left_out(drive):
    assert factors_of(drive.changed(restitution=0.6), "2 ms of bounce") is None
    undamped = drive.changed(**{"opening_stop.damping": 0.0, "opening_stop.stiffness": 0.0})
    assert factors_of(undamped, "1 mm more rebound") is None


def test_reports_of_one_rig(prior, sensor, defaults):
    judged = defaults["judged"] | {"fault_records": 40, "rounded": 0.0, "coloured": 0.0}
    family = family_of("held_back", prior, defaults["rigs"], judged)
    models = {motion: Model(prior, sensor, motion) for motion in ("closing", "opening")}
    rng = np.random.default_rng(3)
    learned = learn(
        ensemble(family, sensor, list(models), 60, rng), sensor, components=4, widening=1.3
    )
    few = defaults["wear_model"] | {"baseline": 20, "settle": 20, "lines": 10}
    rows = judge_power(family, models, learned, [0], judged, few)
    assert [fault for fault in rows.fault if fault != "before"] == list(FAULTS)
    reported = rows[rows.kind.isin(["alarm", "step"]) & (rows.fault != "before")]
    assert reported.after.isin([1, 2, 3]).all()
    assert (rows.operation[rows.fault == "nothing"] == 410).all()
    assert (rows.clear[rows.fault == "nothing"] == 0.0).all()
    assert (rows.clear[rows.fault == "5 % less force"] > 1.0).all()
