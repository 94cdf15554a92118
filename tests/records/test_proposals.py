"""Files of unknown origin: the settings that are proposed read them, or name what is lacking."""

import numpy as np
import pytest
import yaml

from breaker.common.document import text_of
from breaker.common.text import visible_text
from breaker.configuration.definitions import simulated_test
from breaker.family.endurance import EnduranceTest
from breaker.records.curves import Grid, read_curves
from breaker.records.files import RejectedCurveError
from breaker.records.operations import Operation
from breaker.records.proposal import inspect_file, overlay_of, words_of
from breaker.records.reader import Reader
from breaker.records.settings import FORMAT
from studies import layouts

SENSOR = {"start": -2.0, "stop": 58.0, "samples": 151, "noise_sd": 0.1}
TIMES = np.linspace(-2.0, 58.0, 151)
MOTIONS = ("closing", "opening")


@pytest.fixture(scope="module")
def life(defaults):
    return EnduranceTest.from_settings(simulated_test(defaults), seed=1)


@pytest.fixture(scope="module")
def closing(life):
    """Times, ms, and travel, mm, of a closing."""
    return life.record("closing", 1)


@pytest.fixture
def inspect(tmp_path):
    """Write lines to a file and inspect it; none of its proposals is refused by the reader."""

    def inspected(*lines, name="record.txt", channel=""):
        file = tmp_path / name
        file.write_text("\n".join([*lines, ""]), encoding="utf-8")
        proposal = inspect_file(file, SENSOR, channel)
        settings = proposed(proposal)
        column = settings.get("travel_column", FORMAT["travel_column"])
        own = [each for each in proposal.motions if each.column == column and each.record]
        for each in () if proposal.lacking else own:
            assert Reader(settings).read(each.operation, each.motion)
        return proposal

    return inspected


def rows(*columns, sep=",", decimal="."):
    """Rows of cells, each column of texts or of numbers with its own digits."""
    return [sep.join(row).replace(".", decimal) for row in zip(*columns, strict=True)]


def cells(values, digits=3):
    return [f"{value:.{digits}f}" for value in values]


def read(file, settings, motion="closing"):
    curves = read_curves([Operation(1, file)], settings, Grid(TIMES), motion)
    assert curves.accepted.all(), curves.reason.values
    return curves


def proposed(proposal):
    """The settings of a proposal as they are printed."""
    return yaml.safe_load(overlay_of(proposal))["endurance"]["format"]


def assert_read(proposal, closing):
    """The proposal, as it is printed, reads the file: the closing comes out."""
    curves, (time, travel) = read(proposal.layout.file, proposed(proposal)), closing
    exact = np.interp(curves.first_motion.item() + TIMES, time, travel)
    np.testing.assert_allclose(curves.travel.values[0], exact - exact[0], atol=0.25)


@pytest.mark.parametrize("motion", MOTIONS)
@pytest.mark.parametrize("name", layouts.LAYOUTS)
def test_what_is_proposed_for_a_layout_reads_it_as_its_own_settings_do(
    tmp_path, life, name, motion
):
    layout = layouts.LAYOUTS[name]
    file = tmp_path / f"{motion}_00003{layout.ending}"
    layout.write(file, *life.record(motion, 3), motion=motion, operation=3)
    proposal = inspect_file(file, SENSOR)
    assert [(each.motion, bool(each.record)) for each in proposal.motions] == [(motion, True)]
    lacking = {"angles": {"table": str(layouts.ANGLES)}}.get(name, {})  # what no file states
    assert list(proposal.lacking) == (["ratio"] if lacking else [])
    settings = proposed(proposal)
    if name == "degrees":  # no unit is stated, so mm are taken, and a remark has the others
        assert proposal.found.doubts["travel_unit"]
        lacking = {"travel_unit": "deg", "ratio": 0.25, "stroke": [12.0, 17.0]}
    if name == "angles":
        settings["zero"] = 0.0  # of the table, not of the reading
    expected, found = read(file, layout.settings, motion), read(file, settings | lacking, motion)
    np.testing.assert_allclose(found.travel, expected.travel, atol=0.12)
    assert found.first_motion.item() == pytest.approx(expected.first_motion.item(), abs=0.11)


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
}


@pytest.mark.parametrize("name", LAYOUTS)
def test_a_layout_is_proposed_and_read(inspect, closing, name):
    lines, settings = LAYOUTS[name]
    proposal = inspect(*lines(*closing))
    assert {key: proposal.settings[key] for key in settings} == settings
    assert_read(proposal, closing)


@pytest.mark.parametrize(
    ("size", "digits", "head", "unit"),
    [
        (18.0, 2, "travel", "mm"),
        (18.0, 0, "travel", "counts"),
        (60.0, 2, "travel", "counts"),
        (-0.5, 4, "transducer (volt)", "V"),
    ],
)
def test_what_is_no_length_leaves_the_ratio_to_fill_in(inspect, closing, size, digits, head, unit):
    time, travel = closing
    lines = rows(cells(time / 1e3, 5), cells(size * travel, digits))
    proposal = inspect(f"time [s],{head}", *lines, name="closing.csv")
    assert {"travel_unit": "mm", **proposal.settings}["travel_unit"] == unit
    assert [*proposal.lacking] == ([] if unit == "mm" else ["ratio"])
    assert ("stroke" in proposal.settings) == (unit == "mm")
    assert proposal.motions[0].record


def test_the_name_of_a_motion_or_a_rest_at_zero_shows_the_sign(inspect, closing):
    """A reading that rises: a closing, or an opening that falls."""
    time, travel = closing
    lines = ["time,travel", "s,mm", *rows(cells(time / 1e3, 5), cells(travel + 100))]
    assert "sign" not in inspect(*lines, name="closing_1.csv").settings
    assert inspect(*lines, name="opening_1.csv").settings["sign"] == -1
    assert [*inspect(*lines, name="record_1.csv").lacking] == ["sign"]
    proposal = inspect("time,travel", "s,mm", *rows(cells(time / 1e3, 5), cells(-travel)))
    assert proposal.settings["sign"] == -1
    assert_read(proposal, closing)


def test_a_channel_can_be_chosen(inspect, closing):
    time, travel = closing
    columns = rows(*(cells(c, 5) for c in (time / 1e3, travel, 1.01 * travel)))
    lines = "time,Travel A,Travel B", "s,mm,mm", *columns
    assert [t.place for t in inspect(*lines).travels] == [1, 2]
    assert inspect(*lines, channel="Travel B").settings["travel_column"] == "Travel B"
    assert [t.place for t in inspect(*lines, channel="3").travels] == [2]
    flat = "time,travel", *rows(cells(time / 1e3, 5), cells(0.1 * np.sin(1e3 * time)))
    for refused, channel in ((lines, "Travel C"), (flat, ""), (("once upon", "a time"), "")):
        with pytest.raises(RejectedCurveError):
            inspect(*refused, channel=channel)


def test_every_motion_of_every_channel_is_read_in_its_part(inspect):
    """A breaker closes and opens twice; B falls where A rises, is larger, and rests at 20 mm."""
    time = np.arange(0.0, 400.0, 0.1)
    ways = [1.0 / (1.0 + np.exp(at - time)) for at in (50.0, 150.0, 250.0, 350.0)]
    way = ways[0] - ways[1] + ways[2] - ways[3]
    noise = 0.1 * np.random.default_rng(1).standard_normal(time.size)
    columns = time + 250.0, 16.0 * way + noise, 40.0 - 20.0 * way + noise
    proposal = inspect("t,A,B", "ms,mm,mm", *rows(*(cells(each) for each in columns)))
    found = [(each.column, each.motion) for each in proposal.motions]
    assert found == [(c, m) for c, first in (("A", 1), ("B", -1)) for m in (MOTIONS[::first] * 2)]
    for each, at in zip(proposal.motions, [300.0, 400.0, 500.0, 600.0] * 2, strict=True):
        seen = each.record.moves, each.begins, each.arrives
        assert seen == pytest.approx((at - 5.0, at - 3.9, at + 3.0), abs=2.0)
        between = each.operation.begin, each.operation.end
        assert between == pytest.approx((at - 50.0, at + 50.0), abs=1.0)
    assert proposal.settings["stroke"] == pytest.approx([0.9 * 16.0, 1.1 * 20.0], rel=0.03)
    assert proposal.settings["zero"] == "rest"


@pytest.mark.parametrize("name", ["semicolon", "inverted", "wide"])
def test_damaged_files_end_in_a_proposal_or_a_reason(tmp_path, life, name):
    """Bytes cut out, put in and repeated; nothing else is raised."""
    rng, layout = np.random.default_rng(1), layouts.LAYOUTS[name]
    file = tmp_path / f"closing_00003{layout.ending}"
    layout.write(file, *life.record("closing", 3), motion="closing", operation=3)
    content, ends = file.read_bytes(), []
    for _ in range(40):
        begin, size = rng.integers(len(content)), rng.choice([1, 100, 5000])
        put_in = [rng.bytes(size), content[begin : begin + size], b"", b"1e308", b"\0" * 9]
        part = put_in[rng.integers(len(put_in))]
        file.write_bytes(content[:begin] + part + content[begin + size * (part == b"") :])
        try:
            ends.append(bool(text_of(words_of(inspect_file(file, SENSOR)))))
        except RejectedCurveError:
            ends.append(False)
    assert any(ends)


@pytest.mark.parametrize(
    ("name", "shown"), [("Ход travel", True), ("tra\u200bvel", False), ("tra\u202evel", False)]
)
def test_a_name_is_shown_unless_a_sign_of_it_is_not_seen(inspect, closing, name, shown):
    """What is copied from a terminal is read as it was meant."""
    columns = (cells(closing[0] / 1e3, 5), cells(closing[1], 5))
    proposal = inspect(f"time,{name}", *rows(*columns), name="closing.csv")
    overlay = overlay_of(proposal)
    assert visible_text(overlay) == overlay
    assert (name in overlay) == shown
    assert proposed(proposal)["travel_column"] == name
