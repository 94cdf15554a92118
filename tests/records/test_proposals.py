"""Exports of unknown origin: the settings that are proposed read them, or name what is lacking."""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
import pytest
import yaml

from breaker.common.document import text_of
from breaker.records.description import travel_channels
from breaker.records.files import RejectedCurveError
from breaker.records.operations import Operation
from breaker.records.proposal import inspect_file, overlay_of, words_of
from breaker.records.reader import Reader
from tests.exports import way, write

SENSOR = {"start": -2.0, "stop": 58.0, "samples": 151, "noise_sd": 0.1}
MOTIONS = ("closing", "opening")
STROKE = 178.0  # mm


# ---- a table of exports --------------------------------------------------------------------------


class Export(NamedTuple):
    """A file of 10 kHz: lines above its columns; a letter for each column, see ``columns_of``; what
    is proposed for it and what it lacks, with a value that fills it in; and how it is written.
    """

    head: str
    columns: str
    settings: Mapping
    lacking: Mapping = {}
    phases: str = ""
    decimal: str = "."
    encoding: str = "utf-8"
    kind: str = "C"  # its motions
    unit: float = 1.0  # mm of one unit of the reading
    digits: int = 4
    closed: float = 0.0  # reading of the closed breaker, if the reading falls towards it, mm
    name: str = "record.txt"


RATE = {"time_column": None, "rate": 10.0}
EXPORTS = {
    "german": Export(
        "Anlage: Nord\nAbtastrate: 10 kHz\nSchaltfolge: E\n\nWeg L1;Weg L2;Hauptkontakt L1\nmm;mm;",
        *("x;x;c", RATE | {"encoding": "utf-16", "decimal": ","}, {}, "L1 L2", ",", "utf-16"),
    ),
    "chinese": Export(
        "出厂编号：A-99\n采样频率：10kHz\n操作：合闸\n行程A相(mm),行程B相(mm),触头",
        *("x,x,c", RATE | {"encoding": "gb18030"}, {}, "A B", ".", "gb18030"),
    ),
    "no names": Export("", "t\tx", {"time_column": 1, "travel_column": 2}),
    "a count": Export("Sample interval;0.1 ms\nIndex;Travel\n;mm", "n;x", RATE),
    "a ratio": Export(
        "fs = 10k\nÜbersetzung: 1,64 mm/°\nDrehwinkel L1 [°];Drehwinkel L2 [°];K",
        *("x;x;c", {"travel_unit": "deg"}, {"ratio": 1.64}, "L1 L2", ","),
        unit=1.64,
    ),
    "counts": Export(
        "time [s],travel", "s,x", {"travel_unit": "counts"}, {"ratio": 0.05}, unit=0.05, digits=0
    ),
    "O-C-O": Export("t (ms),TRV1(mm)", "t,x", {}, kind="OCO"),
    "falling": Export("t (ms),travel (mm)", "t,x", {"sign": -1}, closed=400, name="closing 1.txt"),
    "no sign": Export("t (ms),TRV1(mm)", "t,x", {}, {"sign": -1}, kind="CO", closed=STROKE),
}


def columns_of(time, export):
    """Columns of time in ms and s, of a count, a travel in its unit, and a contact."""
    share = np.full(time.size, float(export.kind[0] == "O"))
    for k, letter in enumerate(export.kind):
        begin, over = 60.0 + 260.0 * k, 0.2 if len(export.kind) > 1 and letter == "C" else 0.02
        share += (1 if letter == "C" else -1) * way(time, begin, 60.0, over=over)
    noise = np.random.default_rng(0).normal(0.0, 0.05, time.size)
    travel = export.closed + (-1.0 if export.closed else 1.0) * STROKE * share + noise
    return {
        "t": [f"{t:.1f}" for t in time],
        "s": [f"{t / 1e3:.5f}" for t in time],
        "n": [str(i) for i in range(time.size)],
        "x": [f"{x / export.unit:.{export.digits}f}" for x in travel],
        "c": ["1" if s > 0.45 else "0" for s in share],
    }


@pytest.mark.parametrize("name", EXPORTS)
def test_what_is_proposed_for_an_export_reads_it(tmp_path, name):
    export = EXPORTS[name]
    time = 0.1 * np.arange(2600 * len(export.kind) + 600)
    columns = columns_of(time, export)
    sign = export.columns.strip("tsnxc")[:1]
    rows = zip(*(columns[kind] for kind in export.columns.split(sign)), strict=True)
    lines = [sign.join(row).replace(".", export.decimal) for row in rows]
    file = tmp_path / export.name
    file.write_text("\n".join([*filter(None, [export.head]), *lines, ""]), export.encoding)
    proposal = inspect_file(file, SENSOR)
    assert proposal.settings | export.settings == proposal.settings
    assert [*proposal.lacking] == [*export.lacking]
    motions = "".join(item.motion[0].upper() for item in proposal.motions)
    assert motions == export.kind * (len(export.phases.split()) or 1)
    if export.phases:
        assert " ".join(name for name, _ in travel_channels(file).values()) == export.phases
    printed = yaml.safe_load(overlay_of(proposal))["endurance"]["format"]
    settings = printed | export.lacking | {"stroke": None}
    for item in proposal.motions:
        reader = Reader(settings | {"travel_column": item.column})
        operation = Operation(1, file, begin=item.begin, end=item.end)
        assert reader.read(operation, item.motion).segment.stroke == pytest.approx(STROKE, abs=0.5)


# ---- motions and channels ------------------------------------------------------------------------


def written(file, head, *columns):
    rows = [",".join(f"{value:.4f}" for value in row) for row in zip(*columns, strict=True)]
    file.write_text("\n".join([head, *rows, ""]), encoding="utf-8")
    return file


def test_every_motion_of_every_channel_is_read_in_its_part(tmp_path):
    """A breaker closes and opens twice; B falls where A rises, is larger, and rests at 20 mm."""
    time = np.arange(0.0, 400.0, 0.1)
    ways = [1.0 / (1.0 + np.exp(at - time)) for at in (50.0, 150.0, 250.0, 350.0)]
    way = ways[0] - ways[1] + ways[2] - ways[3]
    noise = 0.1 * np.random.default_rng(1).standard_normal(time.size)
    columns = time + 250.0, 16.0 * way + noise, 40.0 - 20.0 * way + noise
    file = written(tmp_path / "a.csv", "t (ms),A (mm),B (mm)", *columns)
    proposal = inspect_file(file, SENSOR)
    result = [(item.column, item.motion) for item in proposal.motions]
    assert result == [(c, m) for c, first in (("A", 1), ("B", -1)) for m in (MOTIONS[::first] * 2)]
    for item, at in zip(proposal.motions, [300.0, 400.0, 500.0, 600.0] * 2, strict=True):
        seen = item.record.moves, item.begins, item.arrives
        assert seen == pytest.approx((at - 5.0, at - 3.9, at + 3.0), abs=2.0)
        assert (item.begin, item.end) == pytest.approx((at - 50.0, at + 50.0), abs=1.0)
    assert proposal.settings["stroke"] == pytest.approx([0.9 * 16.0, 1.1 * 20.0], rel=0.03)
    assert proposal.settings["zero"] == "rest"
    assert [t.place for t in inspect_file(file, SENSOR, "3").findings.travels] == [2]
    assert inspect_file(file, SENSOR, "B").settings["travel_column"] == "B"
    flat = written(tmp_path / "b.csv", "time,travel", time / 1e3, 0.1 * np.sin(1e3 * time))
    for refused, channel in ((file, "C"), (flat, "")):
        with pytest.raises(RejectedCurveError):
            inspect_file(refused, SENSOR, channel)


@pytest.mark.parametrize("title", [[], ["", "[Channel B]", "Time (ms),Travel (mm)"]])
def test_channels_one_below_the_other_are_refused(tmp_path, title):
    time = np.arange(0.0, 300.0, 0.2)
    block = [f"{t:.1f},{178 * y:.2f}" for t, y in zip(time, way(time, 60.0, 60.0), strict=True)]
    lines = ["Time (ms),Travel (mm)", *block, *title, *block]
    (tmp_path / "a.csv").write_text("\n".join(lines), encoding="utf-8")
    with pytest.raises(RejectedCurveError):
        inspect_file(tmp_path / "a.csv", SENSOR)


# ---- the export of an analyser -------------------------------------------------------------------


def inspected(tmp_path, **given):
    write(tmp_path / "export.csv", **given)
    return inspect_file(tmp_path / "export.csv", SENSOR)


def test_unused_channels_are_no_travels(tmp_path):
    proposal = inspected(tmp_path, unused="cross")
    assert [travel.place for travel in proposal.findings.travels] == [6, 7, 8]
    assert proposal.settings["stroke"] == [160.0, 197.0]
    assert "'Travel 4', 'Travel 5'" in text_of(words_of(proposal))


@pytest.mark.parametrize(("stated", "warned"), [([178.0, 150.0], False), ([150.0, 151.0], True)])
def test_a_stated_stroke_that_no_motion_has_is_a_warning(tmp_path, stated, warned):
    proposal = inspected(tmp_path, results={"Stroke (mm)": stated, "Rated Travel (mm)": [178.0]})
    assert [bool(motion.record.warning) for motion in proposal.motions] == [warned] * 3
