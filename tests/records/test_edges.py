"""Contact and trigger of a record: any channel, bounces, disturbances, and what is refused."""

import numpy as np
import pytest

from breaker.model.curves import travel
from breaker.model.parameters import MOTIONS
from breaker.records.contacts import events_of, switching_of, trigger_of
from breaker.records.curves import read_curves
from breaker.records.grid import Grid
from breaker.records.motion import LocatedMotion, Segment
from breaker.records.operations import Operation
from breaker.records.settings import complete

TIME = np.arange(0.0, 80.0, 0.1)
MOVES, TOUCH = 20.0, 31.23
CLOSED = TIME >= TOUCH
CHANNELS = {
    "voltage": lambda closed: np.where(closed, 0.02, 24.0),
    "resistance": lambda closed: np.where(closed, 4e-5, 9.9e37),
    "current": lambda closed: np.where(closed, 100.0, 0.0),
    "binary": lambda closed: closed.astype(float),
    "inverted": lambda closed: 1.0 - closed,
}
SEGMENT = Segment(0, len(TIME), 0.0, 14.0, 0.0, np.nan)


@pytest.mark.parametrize("channel", CHANNELS)
@pytest.mark.parametrize("opens", [False, True])
def test_the_edge_of_any_channel(channel, opens):
    """Within half a sample, whatever its unit and sense, with noise of a percent of its step."""
    signal = CHANNELS[channel](opens != CLOSED)
    noise = 0.01 * np.ptp(signal) * np.random.default_rng(1).standard_normal(TIME.size)
    assert switching_of(TIME, signal, MOVES, "closing")[0] == pytest.approx(TOUCH, abs=0.051)
    assert switching_of(TIME, signal + noise, MOVES, "closing")[0] == pytest.approx(
        TOUCH, abs=0.051
    )


def test_the_first_touch_of_a_bounce_counts_and_a_disturbance_does_not():
    """Planted fault of a reader: the last touch, or the first sample of the other level."""
    bounces = CLOSED & ~((TIME > TOUCH + 0.5) & (TIME < TOUCH + 2.5))
    signal = CHANNELS["voltage"](bounces)
    signal[241] = 0.0  # one sample, before
    assert switching_of(TIME, signal, MOVES, "closing")[0] == pytest.approx(TOUCH, abs=0.051)
    signal[300:] = np.where(np.arange(500) % 7 == 0, np.nan, signal[300:])
    assert switching_of(TIME, signal, MOVES, "closing")[0] == pytest.approx(TOUCH, abs=0.11)
    bounces = [
        switching_of(TIME, each, MOVES, "closing")[1]
        for each in (signal, CHANNELS["voltage"](CLOSED))
    ]
    assert bounces == pytest.approx([TOUCH + 2.5, TOUCH], abs=0.11)
    slow = slice(None, None, 10)  # at 1 kHz one sample is long enough
    signal = CHANNELS["voltage"](CLOSED)
    assert switching_of(TIME[slow], signal[slow], MOVES, "closing")[0] == pytest.approx(
        TOUCH, abs=0.51
    )


@pytest.mark.parametrize("arcing", [900.0, 2500.0, 4900.0])
@pytest.mark.parametrize("motion", MOTIONS)
def test_an_arcing_contact_is_not_open(motion, arcing):
    """In microohm, full scale 8,000: a pole counts by its arcing contact, the main one is told."""
    main, arcs = TOUCH + 3.0, TOUCH
    closed = np.where(main <= TIME, 250.0, np.where(arcs <= TIME, arcing, 8000.0))
    closed = closed[::-1] if motion == "opening" else closed
    arcs, main = (TIME[-1] - arcs, TIME[-1] - main) if motion == "opening" else (arcs, main)
    noise = 1.0 + 0.05 * np.random.default_rng(1).standard_normal(TIME.size)
    at, _, own = switching_of(TIME, np.minimum(closed * noise, 8000.0), MOVES, motion)
    assert at == pytest.approx(arcs, abs=0.11)
    assert own == pytest.approx(main, abs=0.11)


@pytest.mark.parametrize("motion", MOTIONS)
def test_noise_of_an_open_contact_is_no_arcing_contact(motion):
    """Its logarithm has a noise of 8 % of the change, of which 6 sd make no departure: by chance
    in one record of 10^5.
    """
    closed, wide = CLOSED[::-1] if motion == "opening" else CLOSED, 0.08 * np.log(1e4)
    edge = TIME[-1] - TOUCH if motion == "opening" else TOUCH
    for seed in range(20):
        noise = np.where(closed, 0.01, wide) * np.random.default_rng(seed).standard_normal(
            TIME.size
        )
        at, _, own = switching_of(TIME, np.where(closed, 1e-4, 1.0) * np.exp(noise), MOVES, motion)
        assert at == pytest.approx(edge, abs=0.11)
        assert np.isnan(own)


@pytest.mark.filterwarnings("error")
def test_a_gap_beside_an_arcing_contact_hides_it_without_a_warning():
    resistance = np.where(TIME >= TOUCH + 9.0, 1e-4, np.where(CLOSED, 1e-2, 1.0))
    resistance[(TIME > TOUCH - 1.0) & (TIME < TOUCH + 3.0)] = np.nan
    at, _, own = switching_of(TIME, resistance, MOVES, "closing")
    assert TOUCH - 1.0 < at < TOUCH + 3.1
    assert np.isnan(own)


@pytest.mark.parametrize(
    "signal",
    [
        np.full(TIME.size, 3.0),
        np.full(TIME.size, np.nan),
        np.random.default_rng(1).standard_normal(TIME.size),
        np.where(CLOSED, 1.0, np.nan),
        (TIME > 79.0) * 1.0,
    ],
)
def test_no_edge_is_none(signal):
    assert np.isnan(switching_of(TIME, signal, MOVES, "closing")).all()


def test_triggers():
    """A step, and a coil's current that rises with a time constant of 12 ms."""
    step = (TIME >= 8.0) * 5.0
    assert trigger_of(TIME, step, MOVES)[0] == pytest.approx(8.0, abs=0.11)
    current = 3.0 * (1.0 - np.exp(-np.maximum(TIME - 8.0, 0.0) / 12.0))
    noise = 0.005 * np.random.default_rng(1).standard_normal(TIME.size)
    assert trigger_of(TIME, current + noise, MOVES)[0] == pytest.approx(8.0, abs=0.25)
    assert np.isnan(trigger_of(TIME, 0.0 * TIME, MOVES)).all()
    assert np.isnan(trigger_of(TIME, noise, MOVES)).all()
    assert np.isnan(trigger_of(TIME, (TIME >= 25.0) * 1.0, MOVES)).all()
    assert np.isnan(trigger_of(TIME, np.full(TIME.size, np.nan), MOVES)).all()


def coil(start, rise=4.0, length=30.0):
    """A coil's current, A: it rises, dips as its armature moves, and is broken."""
    after = TIME - start
    current = 3.0 * (1.0 - np.exp(-np.maximum(after, 0.0) / rise))
    current -= 0.7 * np.exp(-(((after - 12.0) / 2.0) ** 2))
    return np.where((after > 0.0) & (after < length), np.maximum(current, 0.0), 0.0)


@pytest.mark.parametrize("noise", [0.0, 0.01, 0.05, 0.1])
def test_a_trigger_is_as_uncertain_as_its_noise_makes_it(noise):
    """Of 200 coils in noise, share of 3 A: all within 5 sd, or not told. False alarm below 1e-3."""
    rng, off, told = np.random.default_rng(1), [], 0
    for _ in range(200):
        start, rise = rng.uniform(3.0, 14.0), rng.uniform(1.0, 8.0)
        current = coil(start, rise) + 3.0 * noise * rng.standard_normal(TIME.size)
        at, sd = trigger_of(TIME, current, MOVES)
        if np.isfinite(at):
            told += 1
            off.append(abs(at - start) / np.hypot(sd, 0.05 * rise))
    assert max(off) < 5.0
    assert told > 150 or noise == 0.1  # of which a third is told
    assert np.mean(np.square(off)) < 3.0


def test_a_coil_that_is_energised_with_the_first_sample():
    """Many recorders start with the trigger: the rise is there, or has been before."""
    at, sd = trigger_of(TIME, coil(TIME[0]), MOVES)
    assert at == pytest.approx(TIME[0], abs=0.3)
    assert sd < 0.3
    assert trigger_of(TIME, coil(TIME[0] - 10.0), MOVES) == (TIME[0], 1.0)
    burst = coil(9.0)
    burst[20:22] = 30.0  # interference of 0.2 ms
    assert trigger_of(TIME, burst, MOVES)[0] == pytest.approx(9.0, abs=0.3)


def events(channels=None, motion="closing", **settings):
    travel = np.zeros(TIME.size), np.full(TIME.size, ""), 0.0
    located = LocatedMotion(motion, TIME, *travel, SEGMENT, MOVES, 0.0)
    return events_of(complete(settings), located, channels or {})


def test_a_contact_has_the_error_of_the_settings_and_of_a_sample():
    signal = CHANNELS["binary"](CLOSED)
    found, _ = events({"contact": signal}, contact_column="C", timing_sd=0.05)
    assert found.time == pytest.approx(TOUCH, abs=0.051)
    assert found.sd == pytest.approx(np.hypot(0.05, 0.1 / np.sqrt(12)))
    assert np.isnan(found.trigger)
    assert events(trigger_column=0)[0].trigger == 0.0
    assert np.isnan(events()[0].time)


def test_a_trigger_that_no_breaker_takes_so_long_after_is_none():
    located = LocatedMotion(
        "closing", 2.0 * TIME, np.zeros(TIME.size), np.full(TIME.size, ""), 0.0, SEGMENT, 130.0, 0.0
    )
    settings = complete({"trigger_column": 4})
    found, said = events_of(settings, located, {"trigger": coil(8.0)})
    assert np.isnan(found.trigger)
    assert said == [
        "column 4 rises 114 ms before the first motion, which no breaker takes: it is no trigger "
        "of this closing"
    ]


def test_what_a_channel_does_not_show_is_a_remark():
    still = {name: np.ones(TIME.size) for name in ("contact", "trigger")}
    found, said = events(still, contact_column="C", trigger_column=4)
    assert np.isnan([found.time, found.trigger]).all()
    assert said == [
        "'C' does not switch during the closing: see endurance.format.contact_column",
        "column 4 does not rise before the closing: see endurance.format.trigger_column",
    ]
    early = (TIME > 12.0) * 1.0  # before the first motion: another contact
    found, said = events({"contact": early}, contact_column="C")
    assert np.isnan(found.time)
    assert len(said) == 1


@pytest.mark.parametrize("motion", MOTIONS)
def test_from_a_file_to_the_dataset(tmp_path, prior, sensor, motion):
    """Times on the grid: the file's own, less that of the grid's zero; columns in any order."""
    exact = travel(prior.medians[None], TIME, motion, onset=MOVES)
    switches = MOVES + exact.switching[0]
    contact = np.where((switches <= TIME) == (motion == "closing"), "0.1", "12.0")
    trigger = (TIME >= 7.0) * 2.5
    for name, more in (("a.csv", 0.0), ("b.csv", 0.001)):  # a copy would count once
        rows = zip(TIME, exact.travel[0] + more, contact, trigger, strict=True)
        lines = ["main,travel,coil,time", "V,mm,A,ms"]
        lines += [f"{c},{x:.4f},{i},{t:.2f}" for t, x, c, i in rows]
        (tmp_path / name).write_text("\n".join(lines))
    settings = {"time_unit": "ms", "contact_column": "main", "trigger_column": "coil"}
    operations = [
        Operation(1, tmp_path / "a.csv"),
        Operation(2, tmp_path / "b.csv"),
        Operation(3, tmp_path / "none.csv"),
    ]
    found = read_curves(operations, settings, Grid(sensor.times), motion)
    assert found.accepted.values.tolist() == [True, True, False]
    expected = switches - found.first_motion.values[:2]
    np.testing.assert_allclose(found.contact_time.values[:2], expected, atol=0.051)
    np.testing.assert_allclose(found.contact_sd.values[:2], np.hypot(0.1, 0.1 / 12**0.5))
    np.testing.assert_allclose(found.latch_time.values[:2], MOVES - 7.0, atol=0.6)
    for name in ("contact_time", "contact_sd", "latch_time"):
        assert np.isnan(found[name].values[2:]).all()
        assert found[name].attrs["unit"] == "ms"
    missing = {**settings, "contact_column": "mian"}
    lacking = read_curves(operations[:1], missing, Grid(sensor.times), motion)
    assert "no line has 'mian'" in str(lacking.reason.values[0])


def test_what_the_motion_before_leaves_behind_does_not_count():
    signal = (TIME >= TOUCH) * 1.0
    signal[:3] = 1.0  # a last bounce of the motion before
    assert switching_of(TIME, signal, MOVES, "closing")[0] == pytest.approx(TOUCH, abs=0.051)
    current = 5.0 * np.clip((TIME - 8.0) / 3.0, 0.0, 1.0)
    current[: int(0.2 / (TIME[1] - TIME[0])) + 1] = 4.0
    assert trigger_of(TIME, current, MOVES)[0] == pytest.approx(8.0, abs=0.25)
