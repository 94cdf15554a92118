"""The synthetic endurance test: its mechanism, its wear, its files, and how honest it is."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml

from breaker.mechanism.curves import travel
from breaker.mechanism.parameters import MOTIONS
from breaker.model.joint import Model
from breaker.records.files import list_curves
from breaker.records.landmarks import main_motion
from breaker.records.reader import read_curves
from breaker.synthetic.effective import effective_values, fit
from breaker.synthetic.rigs import Lever, Rig, Stop

CONFIG = yaml.safe_load(
    (Path(__file__).resolve().parents[2] / "config" / "config.yaml").read_text(encoding="utf-8")
)
TIMES = np.linspace(-2.0, 58.0, 151)


@pytest.fixture(scope="module")
def rig() -> Rig:
    return Rig.from_settings(CONFIG["rig"], 1)


def two_mass(rig: Rig, **changes):
    """The rig's mechanism without what the model leaves out: a straight lever, no stops."""
    absent = Stop(position=0.0, stiffness=0.0, damping=0.0, depth=1.0)
    parts = {
        "lever": Lever(radius=1e7, angle=0.0),
        "dry_friction": 0.0,
        "closing_mass": 0.0,
        "closing_friction": 0.0,
        "closing_stop": replace(absent, position=1e6),
        "opening_stop": replace(absent, position=-1e6),
    }
    return replace(rig.new, **{**parts, **changes})


def parameters(mechanism) -> np.ndarray:
    mass = mechanism.drive_mass
    return np.array(
        [
            mass / mechanism.contact_mass,
            mechanism.opening_spring / mass,
            mechanism.contact_spring / mass,
            mechanism.drive_friction / mass,
            mechanism.contact_friction / mass,
            mechanism.closing_force / mass,
            mechanism.gap,
        ]
    )


@pytest.mark.parametrize("motion", MOTIONS)
def test_without_what_the_model_leaves_out_it_is_the_model(rig, motion):
    mechanism = two_mass(rig)
    exact = travel(parameters(mechanism)[None], TIMES, motion).travel[0]
    np.testing.assert_allclose(mechanism.travel(motion, TIMES), exact, atol=1e-5)


@pytest.mark.parametrize("motion", MOTIONS)
@pytest.mark.parametrize(
    "part",
    [
        {"dry_friction": 0.05},
        {"lever": Lever(radius=60.0, angle=0.09)},
        {"closing_mass": 4.0},
        {"closing_stop": Stop(position=12.5, stiffness=10.0, damping=3.0, depth=0.1)},
        {"opening_stop": Stop(position=0.5, stiffness=10.0, damping=3.0, depth=0.1)},
    ],
    ids=["dry friction", "lever", "closing train", "closing stop", "opening stop"],
)
def test_each_part_changes_the_curve(rig, motion, part):
    if (motion, *part) in {("closing", "opening_stop"), ("opening", "closing_mass")}:
        pytest.skip("has no part in this motion")
    plain = two_mass(rig).travel(motion, TIMES)
    assert np.abs(two_mass(rig, **part).travel(motion, TIMES) - plain).max() > 0.01


@pytest.mark.parametrize("motion", MOTIONS)
def test_the_stand_in_is_honest(rig, motion, prior, sensor):
    """All life: within the noise in the main motion, three noise sd off at the end."""
    result = effective_values(rig, Model(prior, sensor, motion), [1, 1000, 1760, 2000])
    assert result.main_largest.max() < 1.0
    assert result.end_largest.min() > 3.0
    z = prior.standardise(result.effective.values[:, :7])
    assert np.abs(z[0]).max() > 1.0  # new, it is not the prior's median drive
    assert np.abs(z).max() < 2.5  # but one that the prior allows
    assert np.abs(parameters(rig.new) / prior.medians - 1).max() > 0.05


def test_a_curve_of_the_model_is_fitted_exactly_but_for_the_prior(prior, sensor):
    z = np.array([0.3, -0.2, 0.4, 0.1, -0.3, 0.2, 0.1, 0.5])
    onset = sensor.onset_sd * z[7]
    curve = travel(prior.destandardise(z[None, :7]), sensor.times, "closing", onset=onset)
    found, left = fit(Model(prior, sensor, "closing"), curve.travel[0], np.zeros(8))
    # The mode is pulled towards the prior's by less than the posterior is wide.
    assert np.abs(left).max() < 0.3 * sensor.noise_sd
    np.testing.assert_allclose(found[3], z[3], atol=0.1)  # gamma_a, the best known
    assert found[7] == pytest.approx(z[7], abs=0.1)


def test_wear_is_monotone_and_changes_its_slope_once(rig):
    operations = np.arange(1, 2001, 50)
    wear = CONFIG["rig"]["wear"]
    for name, change in wear["change"].items():
        values = [getattr(rig.worn(int(k), scatter=False), name) for k in operations]
        steps = np.diff(values) / getattr(rig.new, name)
        assert np.all(np.sign(steps) == np.sign(change))
        before = operations[1:] <= wear["knee"] * 2000
        assert np.ptp(steps[before]) < 1e-12
        assert steps[-1] / steps[0] == pytest.approx(wear["faster"])
        end = getattr(rig.worn(2000, scatter=False), name) / getattr(rig.new, name) - 1
        assert end == pytest.approx(change)


def test_the_closed_position_has_the_least_potential_energy(rig):
    """Springs, contact spring over the lever, closing force and stop: no slope, by differences."""
    new = rig.new

    def energy(arc):
        stop = new.closing_stop.stiffness * max(0.0, arc - new.closing_stop.position) ** 2
        contact = new.contact_spring * (new.lever.travel(arc) - new.gap) ** 2
        return 0.5 * (new.opening_spring * arc**2 + contact + stop) - new.closing_force * arc

    at = new.closed_arc()
    assert new.lever.travel(at) > new.gap
    assert abs(energy(at + 1e-3) - energy(at - 1e-3)) / 2e-3 < 1e-6  # kN


@pytest.mark.parametrize("motion", MOTIONS)
def test_the_motion_starts_after_the_lead(rig, motion):
    """Without noise, zero and scatter of the trigger."""
    sensor = rig.settings["sensor"] | {"noise_sd": 0.0, "zero_sd": 0.0, "trigger_sd": 0.0}
    times, record = replace(rig, settings={**rig.settings, "sensor": sensor}).record(motion, 7)
    moved = np.abs(record - record[0]) > 1e-6
    assert times[moved][0] == pytest.approx(sensor["lead"], abs=2 / sensor["rate"])
    assert moved[times > sensor["lead"] + 1].all()


def test_a_record_depends_on_seed_motion_and_operation_alone(rig):
    times, record = rig.record("closing", 7)
    np.testing.assert_array_equal(record, rig.record("closing", 7)[1])
    assert not np.array_equal(record, rig.record("closing", 8)[1])
    assert not np.array_equal(record, rig.record("opening", 7)[1])
    assert not np.array_equal(record, replace(rig, seed=2).record("closing", 7)[1])
    np.testing.assert_allclose(np.diff(times), 1 / CONFIG["rig"]["sensor"]["rate"])


@pytest.mark.parametrize("motion", MOTIONS)
def test_its_files_are_read_by_the_reader(rig, motion, tmp_path):
    short = replace(rig, settings={**rig.settings, "operations": 3})
    short.run(motion, tmp_path)
    files = list_curves(tmp_path)
    assert [number for number, _ in files] == [1, 2, 3]
    curves = read_curves(files, CONFIG["endurance"]["format"], TIMES, motion)
    assert curves.accepted.all(), curves.reason.values
    lead = CONFIG["rig"]["sensor"]["lead"]
    assert np.abs(curves.first_motion.values - lead).max() < 3.0


def test_a_stop_pushes_back_only():
    stop = Stop(position=0.0, stiffness=2.0, damping=5.0, depth=0.5)
    assert stop.force(-0.1, 1.0) == 0.0
    assert stop.force(1.0, 0.0) == 2.0
    assert stop.force(0.25, 1.0) == pytest.approx(0.5 + 2.5)
    assert stop.force(1.0, -10.0) == 0.0  # it does not pull
    assert replace(stop, power=3.0).force(1.0, 2.0) == pytest.approx(2.0 + 5.0 * 8.0)


@pytest.mark.parametrize(("motion", "share"), [("closing", 0.75), ("opening", 0.85)])
def test_the_main_motion_ends_at_its_share_of_the_way(motion, share):
    times = np.linspace(-2.0, 18.0, 201)
    way = np.clip(times / 10.0, 0.0, 1.0)
    curve = 12.0 * way if motion == "closing" else 12.0 * (1.0 - way)
    main = times[main_motion(curve, times, motion)]
    assert main[0] == pytest.approx(0.0)
    assert main[-1] == pytest.approx(10.0 * share, abs=0.11)
