"""Exports of several makers and languages: rate, stroke, motion, phases and printed results."""

import numpy as np
import pytest
import yaml

from breaker.common.document import text_of
from breaker.records.curves import Grid
from breaker.records.description import travel_channels
from breaker.records.files import RejectedCurveError
from breaker.records.proposal import inspect_file, overlay_of, words_of
from breaker.records.reader import Reader
from tests.exports import way, write

SENSOR = {"start": -2.0, "stop": 58.0, "samples": 151, "noise_sd": 0.1}
GRID = Grid(np.linspace(-2.0, 58.0, 151))
# Lines of the head, sign between columns, decimal sign, encoding, rate, and phases.
MAKERS = {
    "german": (
        "Anlage: Nord\nAbtastrate: 10 kHz\nSchaltfolge: E\n\nWeg L1;Weg L2;Hauptkontakt L1\nmm;mm;",
        *(";", ",", "utf-16", 10.0, "L1 L2"),
    ),
    "json": (
        '{\n"serialNumber": "HV-1",\n"sampleRate_Hz": 20000,\n"channels": ["R", "Y", "B"]\n}\n'
        "travel_1\ttravel_2\tcontact_1\nmm\tmm\t-",
        *("\t", ".", "utf-8", 20.0, "R Y"),
    ),
    "french": (
        "N° de série;778\nFréquence d'échantillonnage;10 kHz\nManœuvre;F\n\n"
        "Course R (mm);Course S (mm);Contact",
        *(";", ",", "cp1252", 10.0, "R S"),
    ),
    "chinese": (
        "出厂编号：A-99\n采样频率：10kHz\n操作：合闸\n行程A相(mm),行程B相(mm),触头",
        *(",", ".", "gb18030", 10.0, "A B"),
    ),
    "inches": (
        'Sample Rate (Samples/s),"10,000"\nStroke A (in),Stroke B (in),C',
        *(",", ".", "utf-8", 10.0, "A B"),
    ),
    "comments": (
        "# sampling_rate_hz=10000\n# stroke_unit=mm\ns_A,s_B,c",
        *(",", ".", "utf-8", 10.0, "A B"),
    ),
}


def put(file, head, sign, decimal, rate, *, encoding="utf-8", size=1.0):
    """Write a closing of two travels and a contact."""
    time = np.arange(0.0, 300.0, 1.0 / rate)
    noise = np.random.default_rng(0).normal(0.0, 0.1, (2, time.size))
    travels = (178.0 * way(time, 60.0, 60.0) + noise) / size
    columns = [*travels, travels[0] > 80.0 / size]
    rows = [
        sign.join(f"{v:.4f}".replace(".", decimal) for v in r) for r in zip(*columns, strict=True)
    ]
    file.write_text("\n".join([head, *rows, ""]), encoding=encoding)
    return file


@pytest.mark.parametrize("maker", MAKERS)
def test_what_is_proposed_for_a_maker_reads_its_export(tmp_path, maker):
    head, sign, decimal, encoding, rate, phases = MAKERS[maker]
    size = 25.4 if maker == "inches" else 1.0
    file = put(tmp_path / "a.csv", head, sign, decimal, rate, encoding=encoding, size=size)
    proposal = inspect_file(file, SENSOR)
    assert not proposal.lacking
    settings = yaml.safe_load(overlay_of(proposal))["endurance"]["format"]
    assert (settings["time_column"], settings["rate"]) == (None, rate)
    names = [name for name, _ in travel_channels(file).values()]
    assert " ".join(names) == phases
    for motion in proposal.motions:
        own = {**settings, "travel_column": motion.column}
        record = Reader(own).read(motion.operation, motion.motion)
        assert motion.motion == "closing"
        assert record.segment.stroke == pytest.approx(178.0, abs=0.5)


def test_a_ratio_may_have_its_unit_and_stays_to_be_filled_in(tmp_path):
    head = "fs = 10k\nÜbersetzung: 1,64 mm/°\nDrehwinkel L1 [°];Drehwinkel L2 [°];K"
    proposal = inspect_file(put(tmp_path / "a.csv", head, ";", ",", 10.0), SENSOR)
    assert proposal.settings["travel_unit"] == "deg"
    assert "1.64" in proposal.lacking["ratio"]


@pytest.mark.parametrize("title", [[], ["", "[Channel B]", "Time (ms),Travel (mm)"]])
def test_channels_one_below_the_other_are_refused(tmp_path, title):
    time = np.arange(0.0, 300.0, 0.2)
    block = [f"{t:.1f},{178 * y:.2f}" for t, y in zip(time, way(time, 60.0, 60.0), strict=True)]
    lines = ["Time (ms),Travel (mm)", *block, *title, *block]
    (tmp_path / "a.csv").write_text("\n".join(lines), encoding="utf-8")
    with pytest.raises(RejectedCurveError):
        inspect_file(tmp_path / "a.csv", SENSOR)


def drive(kind, closed=0.0):
    """Reading at times, ms, of motions such as "CO"; a closing goes far beyond its rest."""
    time = np.arange(0.0, 260.0 * len(kind) + 60.0, 0.2)
    reading = np.full(time.size, float(kind[0] == "O"))
    for k, letter in enumerate(kind):
        over = 0.2 if letter == "C" else 0.02
        reading += (1 if letter == "C" else -1) * way(time, 60.0 + 260.0 * k, 40.0, over=over)
    noise = np.random.default_rng(0).normal(0.0, 0.05, time.size)
    return time, closed + (1.0 if closed == 0.0 else -1.0) * 180.0 * reading + noise


def table(file, head, *columns, sign=","):
    rows = [sign.join(f"{value:.4f}" for value in row) for row in zip(*columns, strict=True)]
    file.write_text("\n".join([head, *rows, ""]), encoding="utf-8")
    return file


@pytest.mark.parametrize(
    ("kind", "closed", "lacking"),
    [("CO", 0.0, []), ("OCO", 0.0, []), ("C", 0.0, []), ("CO", 180.0, ["sign"])],
)
def test_a_sign_that_no_text_says_is_proposed_where_the_curve_is_clear(
    tmp_path, kind, closed, lacking
):
    time, reading = drive(kind, closed)
    file = table(tmp_path / "a.csv", "t (ms),TRV1(mm)", time, reading)
    proposal = inspect_file(file, SENSOR)
    assert [*proposal.lacking] == lacking
    if not lacking:
        assert "".join(each.motion[0].upper() for each in proposal.motions) == kind
    assert all(each.record for each in proposal.motions)


def inspected(tmp_path, **given):
    write(tmp_path / "export.csv", **given)
    return inspect_file(tmp_path / "export.csv", SENSOR)


@pytest.mark.parametrize("plot", [200.0, 800.0])
def test_a_length_that_contradicts_the_rate_leaves_it_to_fill_in(tmp_path, plot):
    proposal = inspected(tmp_path, plot=plot)
    assert list(proposal.lacking) == ["rate"]
    assert f"{4000 / plot:g} kHz" in proposal.lacking["rate"]


@pytest.mark.parametrize("unused", ["zeros", "cross"])
def test_unused_channels_are_no_travels(tmp_path, unused):
    proposal = inspected(tmp_path, unused=unused)
    assert [travel.place for travel in proposal.travels] == [6, 7, 8]
    assert proposal.settings["stroke"] == [160.0, 197.0]
    shown = text_of(words_of(proposal))
    assert ("'Travel 4', 'Travel 5', 'Travel 6'" in shown) == (unused == "cross")


@pytest.mark.parametrize(("stated", "warned"), [([178.0, 150.0], False), ([150.0, 151.0], True)])
def test_a_stated_stroke_that_no_motion_has_is_a_warning(tmp_path, stated, warned):
    proposal = inspected(tmp_path, results={"Stroke (mm)": stated, "Rated Travel (mm)": [178.0]})
    assert [bool(each.record.warning) for each in proposal.motions] == [warned] * 3
