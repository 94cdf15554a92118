"""Times of contacts and triggers: what signals determine, and what is withheld."""

from dataclasses import replace

import numpy as np
import pytest

from breaker.model.curves import travel
from breaker.model.parameters import MOTIONS
from breaker.records.contacts import events_of, trigger_of
from breaker.records.curves import Grid, read_curves
from breaker.records.operations import Operation
from breaker.records.settings import complete
from tests.records.contact_signals import Case, random_case

SIGNALS = {
    "voltage": lambda closed: np.where(closed, 0.02, 24.0),
    "resistance": lambda closed: np.where(closed, 4e-5, 9.9e37),
    "binary": lambda closed: closed.astype(float),
    "inverted": lambda closed: 1.0 - closed,
}
TIME, MOVES = np.arange(0.0, 80.0, 0.1), 20.0


def case_of(motion="opening", **more):
    return Case(np.random.default_rng(5), motion, **more)


def closed_in(case, late=0.0):
    """Samples at which the arcing contact is closed."""
    return case.own < case.arcing - late


@pytest.mark.parametrize("signal", SIGNALS)
@pytest.mark.parametrize("motion", MOTIONS)
def test_any_signal_counts_within_a_sample(signal, motion):
    """With noise of a percent of its step, missing samples, and disturbances of one sample."""
    case = case_of(motion)
    values = SIGNALS[signal](closed_in(case))
    least = 1e-9 if signal == "resistance" else np.ptp(values)
    noise = 0.01 * least * case.rng.standard_normal(values.size)
    noise[:: values.size // 7] += 0.9 * np.ptp(values)
    noise[5::31] = np.nan
    result = case.read(values + noise, name=signal)
    assert result.time == pytest.approx(case.mirrored(case.arcing), abs=0.16)
    assert result.bounce_time == 0.0
    assert np.isnan(result.main)


def test_interruptions_are_bounces_and_ripple_of_a_closed_contact_is_not():
    case, gaps = case_of("closing", cut=4.0), ((1.0, 2.5), (4.0, 4.6))
    amperes = case.current(rises=0.3, gaps=gaps)
    volts = SIGNALS["voltage"](amperes > 10.0)
    for result in (case.read(case.resistance(gaps), amperes), case.read(volts, name="Contact")):
        assert result.time == pytest.approx(case.mirrored(case.arcing), abs=0.3)
        assert result.bounce_time == pytest.approx(4.6, abs=0.3)
    since = case.time - case.mirrored(case.arcing)
    ripples = np.exp(np.log(0.28) + np.sin(2.0 * np.pi * since / 4.0))
    values = np.where(since < 0.0, 4.0, np.where(since < 40.0, ripples, 0.12))
    result = case.read(values, case.current())
    assert result.bounce_time == 0.0
    assert result.time == pytest.approx(case.mirrored(case.arcing), abs=0.3)
    assert not result.main_sd < 2.0  # when the ripple ends, or not at all
    assert np.isnan(case.read(values).bounce_time)
    assert case.read(values, np.where(since > 65.0, 0.0, case.current())).bounce_time == 0.0


@pytest.mark.parametrize("motion", MOTIONS)
def test_beyond_the_range_while_the_current_flows_is_the_arcing_contact(motion):
    """Planted fault: the same resistance without its current, of which the time is withheld."""
    case = case_of(motion)
    values = np.where(case.own < case.main, 0.12, 4.0)
    result = case.read(values, case.current())
    assert result.time == result.arcing
    assert abs(result.time - case.mirrored(case.arcing)) < 4.0 * result.sd
    blank = case.read(np.where(case.own > case.arcing, np.nan, values), case.current())
    alone = case.read(values)
    assert np.isnan(alone.time)
    assert alone.why
    for item in (result, blank, alone):
        assert item.main == pytest.approx(case.mirrored(case.main), abs=0.11)


@pytest.mark.parametrize("motion", MOTIONS)
@pytest.mark.parametrize("kind", ["voltage", "resistance"])
def test_of_a_pre_insertion_resistor_the_main_contact_counts(motion, kind):
    case = case_of(motion)
    levels = (0.0, 18.2, 24.0) if kind == "voltage" else (5e-5, 400.0, 9.9e37)
    values = np.where(case.own < case.main, levels[0], levels[1])
    result = case.read(np.where(closed_in(case), values, levels[2]), name=kind)
    assert result.time == pytest.approx(case.mirrored(case.main), abs=0.11)
    assert not result.bounce_time > 0.0
    doubtful = np.where(closed_in(case), np.where(case.own < case.main, 0.0, 6.0), 24.0)
    assert case.read(doubtful, name="voltage").why


@pytest.mark.parametrize("current", [True, False])
def test_of_simulated_resistances_at_most_one_time_in_a_hundred_is_false(current):
    """Of 400 records, beyond 4 sd, as uniform errors never are, and normal ones in 6e-5: more than
    4 of 400 at that rate has a probability below 1e-9. A shift by 4 ms must be found false.
    """
    rng, off, withheld = np.random.default_rng(11), [], 0
    for _ in range(400):
        case = random_case(rng)
        bounces = case.motion == "closing" and rng.random() < 0.3
        gaps = ((0.8, rng.uniform(2.0, 3.0)),) if bounces else ()
        values = case.resistance(gaps)
        amperes = case.current(rises=rng.uniform(0.2, 2.0), gaps=gaps)
        values[rng.random(values.size) < 0.02] = np.nan
        result = case.read(values, amperes if current else None)
        withheld += np.isnan(result.time)
        main, arcing = case.mirrored(case.main), case.mirrored(case.arcing)
        off += [(result.time - arcing, result.sd), (result.main - main, result.main_sd)]
        off.append((result.arcing - arcing, result.arcing_sd))
        if current:
            assert (result.bounce_time > 0.0) == bool(gaps) or case.step > 0.3
    off = np.array(off)[np.isfinite(off).all(axis=1)]
    assert np.mean(np.abs(off[:, 0]) > 4.0 * off[:, 1]) <= 0.01
    assert np.mean(np.abs(off[:, 0] + 4.0) > 4.0 * off[:, 1]) > 0.5
    assert withheld <= (0 if current else 80)


@pytest.mark.parametrize("motion", MOTIONS)
def test_a_contact_that_contradicts_the_travel_is_withheld(motion):
    case = case_of(motion)
    before = case.mirrored(case.begins + (0.0 if motion == "opening" else case.lasts))
    for at in (before - 10.0, before + case.lasts + 10.0):
        switched = (case.time >= at) == (motion == "closing")
        result = case.read(switched * 1.0, name="Contact")
        assert np.isnan([result.time, result.main, result.bounce_time]).all()
        assert result.why
        amperes = 100.0 * switched + 0.1 * case.rng.standard_normal(switched.size)
        assert np.isnan(case.read(np.where(switched, 0.05, 10.0), amperes).time)


def test_a_signal_that_does_not_switch_is_a_remark():
    case, settings = case_of(), complete({"contact_column": 3, "trigger_column": 0})
    noise, seldom = case.rng.standard_normal(case.time.size), np.where(case.time > 150, 1.0, np.nan)
    for values in (0.0 * noise + 3.0, np.nan * noise, noise, seldom):
        result, said = events_of(settings, case.located(), {"contact": values})
        assert np.isnan(result.time)
        assert len(said) == 1
        assert result.trigger == 0.0  # the record starts with it


def coil(start, rise=4.0, length=30.0):
    """A coil's current, A: it rises, dips as its armature moves, and is broken."""
    after = TIME - start
    current = 3.0 * (1.0 - np.exp(-np.maximum(after, 0.0) / rise))
    current -= 0.7 * np.exp(-(((after - 12.0) / 2.0) ** 2))
    return np.where((after > 0.0) & (after < length), np.maximum(current, 0.0), 0.0)


def test_triggers():
    assert trigger_of(TIME, (TIME >= 8.0) * 5.0, MOVES)[0] == pytest.approx(8.0, abs=0.11)
    burst = coil(9.0)
    burst[20:22] = 30.0  # interference of 0.2 ms
    assert trigger_of(TIME, burst, MOVES)[0] == pytest.approx(9.0, abs=0.3)
    noise = 0.005 * np.random.default_rng(1).standard_normal(TIME.size)
    for none in (0.0 * TIME, noise, (TIME >= 25.0) * 1.0, np.full(TIME.size, np.nan)):
        assert np.isnan(trigger_of(TIME, none, MOVES)).all()
    assert trigger_of(TIME, coil(TIME[0]), MOVES)[0] == pytest.approx(TIME[0], abs=0.3)
    assert np.isnan(trigger_of(TIME, coil(TIME[0] - 10.0), MOVES)).all()  # since when is unknown


def test_a_trigger_is_as_uncertain_as_its_noise_makes_it():
    """Of 200 coils in noise of 0 to 5 % of 3 A: all within 5 sd. False alarm below 1e-3."""
    rng, off = np.random.default_rng(1), []
    for noise in np.linspace(0.0, 0.15, 200):
        start, rise = rng.uniform(3.0, 14.0), rng.uniform(1.0, 8.0)
        at, sd = trigger_of(TIME, coil(start, rise) + noise * rng.standard_normal(800), MOVES)
        if np.isfinite(at):
            off.append(abs(at - start) / np.hypot(sd, 0.02 * rise))
    assert max(off) < 5.0
    assert len(off) > 150


def test_a_trigger_far_before_the_motion_is_of_another_one():
    case, trigger = case_of(), np.arange(1600) > 20
    located = replace(case.located(), time=3.0 * case.time, moves=3.0 * case.begins)
    result, said = events_of(complete({"trigger_column": 4}), located, {"trigger": trigger * 3.0})
    assert np.isnan(result.trigger)
    assert len(said) == 1


def test_from_a_file_to_the_dataset(tmp_path, prior, sensor):
    """Times on the grid: the file's own, less that of the grid's zero; columns in any order."""
    exact = travel(prior.medians[None], TIME, "opening", onset=MOVES)
    switches = MOVES + exact.switching[0]
    contact = np.where(switches <= TIME, "9999.0", "0.05")
    rows = zip(contact, exact.travel[0], 1e3 * coil(7.0), TIME, strict=True)
    lines = [f"{c},{x:.4f},{i:.2f},{t:.2f}" for c, x, i, t in rows]
    head = ["main,travel,coil,time", "mOhm,mm,mA,ms"]
    (tmp_path / "a.csv").write_text("\n".join([*head, *lines]))
    settings = {"time_unit": "ms", "contact_column": "main", "trigger_column": "coil"}
    operation = Operation(1, tmp_path / "a.csv")
    result = read_curves([operation], settings, Grid(sensor.times), "opening")
    expected = {
        "contact_time": (switches - result.first_motion.values[0], 0.051),
        "contact_sd": (np.hypot(0.1, 0.1 / 12**0.5), 1e-9),
        "reaction_time": (MOVES - 7.0, 0.6),
    }
    for name, (value, off) in expected.items():
        assert result[name].item() == pytest.approx(value, abs=off)
    names = ["coil_current", "coil_off_time", "static_resistance", "arcing_wipe"]
    truth = [coil(7.0).max(), 30.0, 50.0, np.nan]
    measured = result.measured.sel(quantity=names).values[0]
    assert measured == pytest.approx(truth, rel=0.02, nan_ok=True)
