"""Files of unknown origin: the settings that are proposed read them, or say what is lacking."""

import numpy as np
import pytest
import yaml

from breaker.configuration.definitions import simulated_test
from breaker.configuration.loading import load
from breaker.documents.terminal import text_of
from breaker.drive.simulation.dialects import ANGLES, DIALECTS
from breaker.drive.simulation.endurance_rig import Rig
from breaker.records.channels import InspectionError
from breaker.records.curves import read_curves
from breaker.records.description import guess_grid
from breaker.records.files import RejectedCurveError
from breaker.records.formats.registry import look_into
from breaker.records.grid import Grid
from breaker.records.operations import Operation
from breaker.records.proposal import inspect_file
from breaker.records.proposal_text import overlay_of, words_of
from breaker.records.settings import FORMAT
from breaker.records.sheet import LayoutError

SENSOR = {"start": -2.0, "stop": 58.0, "samples": 151, "noise_sd": 0.1}
TIMES = np.linspace(-2.0, 58.0, 151)
MOTIONS = ("closing", "opening")


@pytest.fixture(scope="module")
def rig(defaults):
    return Rig.from_settings(simulated_test(defaults), seed=1)


@pytest.fixture(scope="module")
def closing(rig):
    """Times, ms, and travel, mm, of a closing."""
    return rig.record("closing", 1)


@pytest.fixture
def put(tmp_path):
    """Write lines to a file; returns it."""

    def write(*lines, name="record.txt", encoding="utf-8", eol="\n"):
        file = tmp_path / name
        file.write_bytes(eol.join([*lines, ""]).encode(encoding))
        return file

    return write


def rows(*columns, sep=",", decimal="."):
    """Rows of cells, each column of texts or of numbers with its own digits."""
    return [sep.join(row).replace(".", decimal) for row in zip(*columns, strict=True)]


def cells(values, digits=3):
    return [f"{value:.{digits}f}" for value in values]


def read(file, settings, motion="closing"):
    curves = read_curves([Operation(1, file)], settings, Grid(TIMES), motion)
    assert curves.accepted.all(), curves.reason.values
    return curves


def assert_read(proposal, closing):
    """The proposal, as it is printed, reads the file: the closing comes out."""
    settings = yaml.safe_load(overlay_of(proposal))["endurance"]["format"]
    curves = read(proposal.layout.file, settings)
    time, travel = closing
    exact = np.interp(curves.first_motion.item() + TIMES, time, travel)
    np.testing.assert_allclose(curves.travel.values[0], exact - exact[0], atol=0.25)


# ---- dialects -----------------------------------------------------------------------------------


@pytest.mark.parametrize("motion", MOTIONS)
@pytest.mark.parametrize("name", DIALECTS)
def test_what_is_proposed_for_a_dialect_reads_it_as_its_own_settings_do(
    tmp_path, rig, name, motion
):
    dialect = DIALECTS[name]
    file = tmp_path / dialect.file_name(motion, 3)
    dialect.write(file, *rig.record(motion, 3), motion=motion, operation=3)
    proposal = inspect_file(file, SENSOR)
    assert all(each.record for each in proposal.motions)
    assert [each.motion for each in proposal.motions] == [motion]
    assert proposal.sensor == {} or name == "degrees"
    assert text_of(words_of(proposal)).startswith(str(file))
    settings = yaml.safe_load(overlay_of(proposal))["endurance"]["format"]
    # What no file tells has to be filled in.
    lacking = {"angles": {"table": str(ANGLES)}}.get(name, {})
    assert list(proposal.lacking) == (["ratio"] if lacking else [])
    if name == "degrees":
        # It states no unit, so that mm are the guess, with the line that sets another.
        assert any(each.remarks for each in proposal.guesses if "travel_unit" in each.settings)
        lacking = {"travel_unit": "deg", "ratio": 0.25, "stroke": [12.0, 17.0]}
    if name == "angles":
        settings["zero"] = 0.0  # of the table, not of the reading
    expected = read(file, dialect.settings, motion)
    found = read(file, settings | lacking, motion)
    np.testing.assert_allclose(found.travel, expected.travel, atol=0.12)
    assert found.first_motion.item() == pytest.approx(expected.first_motion.item(), abs=0.11)


# ---- layouts ------------------------------------------------------------------------------------


# Lines of a file of times, ms, and travel, mm; and settings that are proposed for it.
LAYOUTS = {
    "no names at all": (
        lambda t, x: rows(cells(t, 1), cells(x), sep="\t"),
        {"time_column": 1, "travel_column": 2},
    ),
    "dates in a first column": (
        lambda t, x: [
            "Datum;Zeit [s];Hub [mm]",
            *rows(["20/11/2024 15:13"] * t.size, cells(t / 1e3, 5), cells(x), sep=";", decimal=","),
        ],
        {"delimiter": ";", "time_column": "Zeit"},
    ),
    "a count of samples": (
        lambda t, x: [
            *("Sample interval;0.1 ms", "Index;Travel", ";mm"),
            *rows([str(i) for i in range(x.size)], cells(x), sep=";"),
        ],
        {"time_column": None, "rate": 10.0},
    ),
    "microseconds by their steps": (
        lambda t, x: ["t,stroke_cm", *rows(cells(1e3 * t, 0), cells(x / 10, 4))],
        {"time_unit": "us", "travel_unit": "cm"},
    ),
    "decimal commas, that would make two columns of whole numbers": (
        lambda t, x: ["Rate: 10 kHz", "Weg (mm)", *rows(cells(x), decimal=",")],
        {"decimal": ","},
    ),
    "a length by its size": (
        lambda t, x: ["time [s],travel", *rows(cells(t / 1e3, 5), cells(x / 1e3, 6))],
        {"travel_unit": "m"},
    ),
}


@pytest.mark.parametrize("name", LAYOUTS)
def test_a_layout_is_told(put, closing, name):
    lines, settings = LAYOUTS[name]
    proposal = inspect_file(put(*lines(*closing)), SENSOR)
    assert {key: proposal.settings[key] for key in settings} == settings
    assert_read(proposal, closing)


def test_without_a_rate_it_asks(put, closing):
    _, travel = closing
    count = [str(i) for i in range(travel.size)]
    proposal = inspect_file(put("Index;Travel", *rows(count, cells(travel), sep=";")), SENSOR)
    assert list(proposal.lacking) == ["rate"]
    assert yaml.safe_load(overlay_of(proposal))["endurance"]["format"]["rate"] is None


@pytest.mark.parametrize(
    ("name", "times"),
    [("time_ms", lambda t: [f"{int(each)}" for each in t]), ("x", lambda t: cells(t // 0.2 / 5))],
    ids=["printed with too few digits", "each twice, as by minimum and maximum"],
)
def test_times_in_uneven_steps_are_kept_and_named(put, closing, name, times):
    """No rate stands in for them: the record is refused as long as they are uneven."""
    time, travel = closing
    proposal = inspect_file(put(f"{name},travel_mm", *rows(times(time), cells(travel))), SENSOR)
    column = {**FORMAT, **proposal.settings}["time_column"]
    assert column == name.removesuffix("_ms")
    assert any(repr(column) in remark for remark in proposal.remarks)
    assert [each.record for each in proposal.motions] == [None]
    assert not proposal.is_read


def test_volts_leave_the_ratio_to_fill_in(put, closing):
    time, travel = closing
    lines = rows(cells(time / 1e3, 5), cells(9.0 - travel / 2, 4))
    proposal = inspect_file(put("time,transducer", "s,V", *lines), SENSOR)
    assert list(proposal.lacking) == ["ratio"]
    assert proposal.settings["zero"] == "rest"
    assert "stroke" not in proposal.settings
    assert all(each.record for each in proposal.motions)


def test_the_name_of_a_motion_tells_the_sign(put, closing):
    """A reading that rises by 14 mm, far from zero: a closing, or an opening that falls."""
    time, travel = closing
    lines = ["time,travel", "s,mm", *rows(cells(time / 1e3, 5), cells(travel + 100))]
    assert "sign" not in inspect_file(put(*lines, name="closing_1.csv"), SENSOR).settings
    proposal = inspect_file(put(*lines, name="opening_1.csv"), SENSOR)
    assert proposal.settings["sign"] == -1
    assert proposal.settings["zero"] == "rest"
    assert [*inspect_file(put(*lines, name="record_1.csv"), SENSOR).lacking] == ["sign"]


def test_a_rest_at_zero_tells_the_sign_where_no_name_does(put, closing):
    time, travel = closing
    lines = ["time,travel", "s,mm", *rows(cells(time / 1e3, 5), cells(-travel))]
    proposal = inspect_file(put(*lines), SENSOR)
    assert proposal.settings["sign"] == -1
    assert "zero" not in proposal.settings
    assert len(proposal.remarks) == 1
    assert_read(proposal, closing)
    assert "sign" not in inspect_file(put(*lines, name="opening_1.csv"), SENSOR).settings


@pytest.mark.parametrize(
    ("size", "digits", "unit", "lacking"),
    [(18, 2, "mm", []), (18, 0, "counts", ["ratio"]), (60, 2, "counts", ["ratio"])],
)
def test_only_integers_and_what_is_no_length_are_counts(put, closing, size, digits, unit, lacking):
    time, travel = closing
    lines = rows(cells(time / 1e3, 5), cells(size * travel, digits))
    proposal = inspect_file(put("time [s],travel", *lines), SENSOR)
    assert {"travel_unit": "mm", **proposal.settings}["travel_unit"] == unit
    assert [*proposal.lacking] == lacking
    assert any(each.remarks for each in proposal.guesses if "travel_unit" in each.settings)


def test_currents_and_contacts_are_no_travel(put, closing):
    """None has a unit or a telling name: a coil that is switched, a sine, a contact, the travel."""
    time, travel = closing
    on, off = np.clip(time - 2, 0, 28), np.clip(time - 30, 0, None)
    coil = 9.0 * (1 - np.exp(-on / 6)) * np.exp(-off / 6)
    columns = (time / 1e3, coil, 10 * np.sin(time), 24.0 * (time > 18), travel)
    proposal = inspect_file(put("t,a,b,c,d", *rows(*(cells(c, 5) for c in columns))), SENSOR)
    assert proposal.settings["travel_column"] == "d"
    assert len(proposal.travels) == 1
    assert_read(proposal, closing)


def test_a_channel_can_be_chosen(put, closing):
    time, travel = closing
    columns = (time / 1e3, travel, 1.01 * travel)
    file = put("time,Travel A,Travel B", "s,mm,mm", *rows(*(cells(c, 5) for c in columns)))
    assert [t.place for t in inspect_file(file, SENSOR).travels] == [1, 2]
    assert inspect_file(file, SENSOR, "Travel B").settings["travel_column"] == "Travel B"
    assert [t.place for t in inspect_file(file, SENSOR, "3").travels] == [2]
    with pytest.raises(InspectionError, match="there are 'Travel A', 'Travel B'"):
        inspect_file(file, SENSOR, "Travel C")


@pytest.fixture
def switched(put):
    """A breaker that closes and opens twice, from 294 ms on, in channels A and B: a file of them.

    B falls where A rises, is larger, and its open rest is at 20 mm. Noise doubles after the first
    motion. A sample of A is wrong.
    """
    time = np.arange(0.0, 400.0, 0.1)
    ways = [1.0 / (1.0 + np.exp(at - time)) for at in (50.0, 150.0, 250.0, 350.0)]
    way = ways[0] - ways[1] + ways[2] - ways[3]
    noise = np.where(time < 48.0, 0.1, 0.2) * np.random.default_rng(1).standard_normal(time.size)
    a, b = 16.0 * way + noise, 40.0 - 20.0 * way + noise
    a[100] += 9.0
    return put("t,A,B", "ms,mm,mm", *rows(*(cells(each) for each in (time + 250.0, a, b))))


def test_every_motion_of_every_channel_is_read_in_its_part(switched):
    proposal = inspect_file(switched, SENSOR)
    found = [(each.column, each.motion) for each in proposal.motions]
    assert found == [(c, m) for c, first in (("A", 1), ("B", -1)) for m in (MOTIONS[::first] * 2)]
    for each, at in zip(proposal.motions, [300.0, 400.0, 500.0, 600.0] * 2, strict=True):
        assert each.record.moves == pytest.approx(at - 5.0, abs=2.0)
        assert each.begins == pytest.approx(at - 3.9, abs=1.0)  # a fiftieth of the way
        assert each.arrives == pytest.approx(at + 3.0, abs=1.0)  # but a twentieth
        between = each.operation.begin, each.operation.end
        assert between == pytest.approx((at - 50.0, at + 50.0), abs=1.0)
    # The widest limits that both allow, a zero that both have, the noise before the first motions.
    assert proposal.settings["stroke"] == pytest.approx([0.9 * 16.0, 1.1 * 20.0], rel=0.03)
    assert proposal.settings["zero"] == "rest"
    assert proposal.sensor == {}
    assert any("the strokes of the motions differ: 1" in each for each in proposal.remarks)
    assert any("move in different directions" in each for each in proposal.remarks)


def test_channels_in_different_units_are_said(put, closing):
    time, travel = closing
    lines = rows(cells(time / 1e3, 5), cells(travel), cells(travel / 10, 4))
    proposal = inspect_file(put("time,a,b", "s,mm,cm", *lines), SENSOR)
    assert any("have different units" in remark for remark in proposal.remarks)
    assert [each.record is None for each in proposal.motions] == [False, True]


@pytest.mark.parametrize("encoding", ["gb18030", "utf-16", "utf-16-le", "cp1252", "utf-8-sig"])
def test_encodings(put, closing, encoding):
    time, travel = closing
    name = {"gb18030": "行程", "cp1252": "Höhe"}.get(encoding, "Höhe °")
    lines = ["Prüfstand" if "1" in encoding else "测试", f"time;{name}", "s;mm"]
    lines = [line.replace("Prüfstand", "é") for line in lines]
    file = put(*lines, *rows(cells(time / 1e3, 5), cells(travel), sep=";"), encoding=encoding)
    proposal = inspect_file(file, SENSOR)
    assert proposal.layout.names[1] == name
    assert_read(proposal, closing)


@pytest.mark.parametrize(
    "said", ["Temp (°C)", "Resistance (µOhm)", "Prüfdatum", "m/s²", "Résistance"]
)
def test_signs_of_western_code_pages_are_not_read_as_chinese(put, closing, said):
    time, travel = closing
    lines = [said, "time;travel", "s;mm", *rows(cells(time / 1e3, 5), cells(travel), sep=";")]
    layout = inspect_file(put(*lines, encoding="latin-1"), SENSOR).layout
    assert layout.preamble[0] == [said]


def test_every_line_is_looked_at_where_samples_are_damaged(put, closing):
    time, travel = closing
    lines = rows(cells(time / 1e3, 5), cells(travel))
    lines[3], lines[200], lines[300] = "x,y", "0.02,1_000", ","
    proposal = inspect_file(put("head", "time,travel", "s,mm", *lines), SENSOR)
    assert proposal.layout.names == ["time", "travel"]
    assert proposal.motions[0].record is None
    assert "line 7: 'time' is 'x', which is not a number" in proposal.motions[0].said[0]
    assert "REJECTED" in text_of(words_of(proposal))


def test_nothing_that_moves_and_no_numbers_are_errors(put, closing):
    time, _ = closing
    flat = rows(cells(time / 1e3, 5), cells(0.1 * np.sin(1e3 * time)))
    with pytest.raises(InspectionError, match="none of 2 columns moves"):
        inspect_file(put("time,travel", *flat), SENSOR)
    with pytest.raises(LayoutError, match="no columns of numbers"):
        inspect_file(put("once upon a time", "there was a text"), SENSOR)
    with pytest.raises(LayoutError, match="no columns of numbers"):
        look_into(put())


# ---- sensor -------------------------------------------------------------------------------------


def test_a_slow_drive_gets_a_longer_grid_and_its_own_noise(put, closing):
    time, travel = closing
    slow = np.arange(0.0, 6.0 * time[-1], 0.1)
    noise = 0.3 * np.random.default_rng(1).standard_normal(slow.size)
    travel = np.interp(slow / 6.0, time, np.convolve(travel, np.full(9, 1 / 9), "same"))
    lines = rows(cells(slow / 1e3, 5), cells(travel + noise, 2))
    proposal = inspect_file(put("time,travel", "s,mm", *lines), SENSOR)
    assert proposal.sensor["samples"] == 151
    assert 60 < proposal.sensor["stop"] < 120  # a closing of 12 ms, six times as long
    assert proposal.sensor["start"] / proposal.sensor["stop"] == pytest.approx(-2 / 58)
    assert proposal.sensor["noise_sd"] == pytest.approx(0.3, rel=0.2)
    # What is proposed is what the record is compared with.
    assert not any("sensor.noise_sd" in said for each in proposal.motions for said in each.said)


def test_a_longer_grid_takes_whole_samples():
    """1.25 and 1.5 times the grid would hold the motion."""
    assert guess_grid(66.0, 200.0, 2.5, SENSOR).settings["stop"] == 2.0 * SENSOR["stop"]


@pytest.mark.parametrize("rate", [1.0, 2.5, 10.0, 20.0])
def test_a_longer_grid_stays_within_the_record(rate):
    for longest, room in [(70.0, 195.0), (157.0, 141.6), (300.0, 170.0)]:
        found = guess_grid(longest, room, rate, SENSOR).settings
        assert SENSOR["stop"] < found["stop"] <= room
        assert found["stop"] > min(longest, 0.6 * room)
        step = (found["stop"] - found["start"]) / (found["samples"] - 1) * rate
        assert step == pytest.approx(round(step)) or step < 2.0
    assert guess_grid(61.0, 61.5, 10.0, SENSOR).settings == {}  # no whole samples more


def test_of_a_drive_of_another_size_the_sensor_is_left_to_its_prior(put, closing):
    time, travel = closing
    lines = rows(cells(time / 1e3, 5), cells(10.0 * travel, 2))
    proposal = inspect_file(put("time,travel", "s,mm", *lines), SENSOR)
    assert proposal.sensor == {}
    assert not any("sensor" in remark for remark in proposal.remarks)


def test_one_channel_that_is_clipped_ends_no_other(put, closing):
    """The good channel is proposed, and the other named with its reason."""
    time, travel = closing
    columns = (cells(time, 1), cells(np.minimum(travel, 8.0)), cells(travel))
    file = put("t,Travel A,Travel B", "ms,mm,mm", *rows(*columns), name="closing.csv")
    proposal = inspect_file(file, SENSOR)
    clipped, good = proposal.motions
    assert clipped.said
    assert good.record
    assert proposal.settings["travel_column"] == "Travel B"


# ---- damage -------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["semicolon", "inverted", "wide"])
def test_damaged_files_end_in_a_proposal_or_a_reason(tmp_path, rig, name):
    """Bytes cut out, put in and repeated; nothing else is raised."""
    rng = np.random.default_rng(1)
    dialect = DIALECTS[name]
    file = tmp_path / dialect.file_name("closing", 3)
    dialect.write(file, *rig.record("closing", 3), motion="closing", operation=3)
    content, ends = file.read_bytes(), []
    for _ in range(40):
        begin, size = rng.integers(len(content)), rng.choice([1, 100, 5000])
        put_in = [rng.bytes(size), content[begin : begin + size], b"", b"1e308", b"\0" * 9]
        part = put_in[rng.integers(len(put_in))]
        file.write_bytes(content[:begin] + part + content[begin + size * (part == b"") :])
        try:
            ends.append(bool(text_of(words_of(inspect_file(file, SENSOR)))))
        except (InspectionError, LayoutError, RejectedCurveError):
            ends.append(False)
    assert any(ends)


def test_what_is_proposed_of_a_curve_without_noise_is_a_configuration(tmp_path, defaults):
    time = 0.1 * np.arange(1000)
    share = np.clip((time - 20.0) / 25.0, 0.0, 1.0)
    np.savetxt(
        tmp_path / "a.csv",
        np.column_stack([time, 13.0 * share * share * (3.0 - 2.0 * share)]),
        delimiter=",",
        header="time,travel\nms,mm",
        comments="",
    )
    (tmp_path / "my.yaml").write_text(
        overlay_of(inspect_file(tmp_path / "a.csv", defaults["sensor"])), encoding="utf-8"
    )
    config = load([tmp_path / "my.yaml"], curves=False)
    assert config["sensor"]["noise_sd"] == 1e-4
