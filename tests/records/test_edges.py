"""Contact and trigger of a record: any channel, bounces, disturbances, and what is refused."""

import numpy as np
import pytest

from breaker.files.manifest import Operation
from breaker.files.settings import complete
from breaker.mechanism.curves import travel
from breaker.mechanism.parameters import MOTIONS
from breaker.records.edges import events_of, switching_of, trigger_of
from breaker.records.errors import UnusableError
from breaker.records.grid import Grid
from breaker.records.located import LocatedMotion
from breaker.records.reader import read_curves
from breaker.records.segments import Segment

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
    assert switching_of(TIME, signal, MOVES)[0] == pytest.approx(TOUCH, abs=0.051)
    assert switching_of(TIME, signal + noise, MOVES)[0] == pytest.approx(TOUCH, abs=0.051)


def test_the_first_touch_of_a_bounce_counts_and_a_disturbance_does_not():
    """Planted fault of a reader: the last touch, or the first sample of the other level."""
    bounces = CLOSED & ~((TIME > TOUCH + 0.5) & (TIME < TOUCH + 2.5))
    signal = CHANNELS["voltage"](bounces)
    signal[241] = 0.0  # one sample, before
    assert switching_of(TIME, signal, MOVES)[0] == pytest.approx(TOUCH, abs=0.051)
    signal[300:] = np.where(np.arange(500) % 7 == 0, np.nan, signal[300:])
    assert switching_of(TIME, signal, MOVES)[0] == pytest.approx(TOUCH, abs=0.11)
    bounces = [switching_of(TIME, each, MOVES)[1] for each in (signal, CHANNELS["voltage"](CLOSED))]
    assert bounces == pytest.approx([TOUCH + 2.5, TOUCH], abs=0.11)
    slow = slice(None, None, 10)  # at 1 kHz one sample is long enough
    signal = CHANNELS["voltage"](CLOSED)
    assert switching_of(TIME[slow], signal[slow], MOVES)[0] == pytest.approx(TOUCH, abs=0.51)


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
    assert np.isnan(switching_of(TIME, signal, MOVES)).all()


def test_triggers():
    """A step, and a coil's current that rises with a time constant of 12 ms."""
    step = (TIME >= 8.0) * 5.0
    assert trigger_of(TIME, step, MOVES) == pytest.approx(8.0, abs=0.11)
    current = 3.0 * (1.0 - np.exp(-np.maximum(TIME - 8.0, 0.0) / 12.0))
    noise = 0.005 * np.random.default_rng(1).standard_normal(TIME.size)
    assert trigger_of(TIME, current + noise, MOVES) == pytest.approx(8.0, abs=0.25)
    assert np.isnan(trigger_of(TIME, 0.0 * TIME, MOVES))
    assert np.isnan(trigger_of(TIME, noise, MOVES))
    assert np.isnan(trigger_of(TIME, (TIME >= 25.0) * 1.0, MOVES))
    assert np.isnan(trigger_of(TIME, np.full(TIME.size, np.nan), MOVES))


def events(known=None, channels=None, motion="closing", **settings):
    operation = Operation(1, "a.csv", **(known or {}))
    travel = np.zeros(TIME.size), np.full(TIME.size, ""), 0.0
    located = LocatedMotion(motion, TIME, *travel, SEGMENT, MOVES)
    return events_of(operation, complete(settings), located, channels or {})


def test_what_is_stated_goes_before_what_a_channel_shows():
    signal = CHANNELS["binary"](CLOSED)
    found, said = events(
        {"switching": 30.0, "trigger": 5.0}, {"contact": signal, "trigger": signal}
    )
    assert found[:3] == (30.0, 0.1, 5.0)
    assert np.isnan(found.settles)
    assert said == []
    assert events({"switching": 30.0}, timing_sd=0.4)[0].sd == 0.4
    found, said = events({}, {"contact": signal}, contact_column="C", timing_sd=0.05)
    assert found.time == pytest.approx(TOUCH, abs=0.051)
    assert found.sd == pytest.approx(np.hypot(0.05, 0.1 / np.sqrt(12)))
    assert np.isnan(found.trigger)
    assert events(trigger_column=0)[0].trigger == 0.0
    assert np.isnan(events()[0]).all()


def test_what_a_channel_does_not_show_is_a_remark():
    still = {name: np.ones(TIME.size) for name in ("contact", "trigger")}
    found, said = events({}, still, contact_column="C", trigger_column=4)
    assert np.isnan(found).all()
    assert said == [
        "'C' does not switch during the closing: see endurance.format.contact_column",
        "column 4 does not rise before the closing: see endurance.format.trigger_column",
    ]
    early = (TIME > 12.0) * 1.0  # before the first motion: another contact
    found, said = events({}, {"contact": early}, contact_column="C")
    assert np.isnan(found.time)
    assert len(said) == 1


@pytest.mark.parametrize("wrong", [{"switching": 9.8}, {"switching": 95.0}, {"trigger": 22.0}])
def test_stated_times_in_another_time_are_refused(wrong):
    with pytest.raises(UnusableError, match=r"in operations.csv, but the first motion is at 20.0"):
        events(wrong)


@pytest.mark.parametrize("motion", MOTIONS)
def test_from_a_file_to_the_dataset(tmp_path, prior, sensor, motion):
    """Times on the grid: the file's own, less that of the grid's zero; columns in any order."""
    exact = travel(prior.medians[None], TIME, motion, onset=MOVES)
    switches = MOVES + exact.switching[0]
    contact = np.where((switches <= TIME) == (motion == "closing"), "0.1", "12.0")
    trigger = (TIME >= 7.0) * 2.5
    rows = zip(TIME, exact.travel[0], contact, trigger, strict=True)
    lines = ["main,travel,coil,time", "V,mm,A,ms"]
    lines += [f"{c},{x:.4f},{i},{t:.2f}" for t, x, c, i in rows]
    (tmp_path / "a.csv").write_text("\n".join(lines))
    settings = {"time_unit": "ms", "contact_column": "main", "trigger_column": "coil"}
    own = {"timing_sd": 0.3}
    operations = [
        Operation(1, tmp_path / "a.csv"),
        Operation(2, tmp_path / "a.csv", switching=switches + 1.0, trigger=2.0, settings=own),
        Operation(3, tmp_path / "a.csv", switching=3.0),
        Operation(4, tmp_path / "none.csv"),
    ]
    found = read_curves(operations, settings, Grid(sensor.times), motion)
    assert found.accepted.values.tolist() == [True, True, False, False]
    expected = switches - found.first_motion.values[:2] + [0.0, 1.0]
    np.testing.assert_allclose(found.contact_time.values[:2], expected, atol=0.051)
    np.testing.assert_allclose(found.contact_sd.values[:2], [np.hypot(0.1, 0.1 / 12**0.5), 0.3])
    np.testing.assert_allclose(found.latch_time.values[:2], [MOVES - 7.0, MOVES - 2.0], atol=0.6)
    for name in ("contact_time", "contact_sd", "latch_time"):
        assert np.isnan(found[name].values[2:]).all()
        assert found[name].attrs["unit"] == "ms"
    column = "touch_time" if motion == "closing" else "part_time"
    assert f"{column} is 3 ms in operations.csv" in str(found.reason.values[2])
    without = read_curves(operations[:1], {"time_unit": "ms"}, Grid(sensor.times), motion)
    assert np.isnan(without.contact_time.values).all()
    np.testing.assert_array_equal(without.travel.values, found.travel.values[:1])
    missing = {**settings, "contact_column": "mian"}
    lacking = read_curves(operations[:1], missing, Grid(sensor.times), motion)
    assert "no line has 'mian'" in str(lacking.reason.values[0])


def test_what_the_motion_before_leaves_behind_does_not_count():
    signal = (TIME >= TOUCH) * 1.0
    signal[:3] = 1.0  # a last bounce of the motion before
    assert switching_of(TIME, signal, MOVES)[0] == pytest.approx(TOUCH, abs=0.051)
    current = 5.0 * np.clip((TIME - 8.0) / 3.0, 0.0, 1.0)
    current[: int(0.2 / (TIME[1] - TIME[0])) + 1] = 4.0
    assert trigger_of(TIME, current, MOVES) == pytest.approx(8.0, abs=0.25)
