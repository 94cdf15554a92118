"""Which operations are in a folder, what is refused before a plan, and the check of a folder."""

import os
from dataclasses import astuple, replace

import numpy as np
import pytest

from breaker.common.document import text_of
from breaker.configuration.data_files import simulated_test
from breaker.configuration.loading import defaults
from breaker.family.endurance import EnduranceTest, write_curve
from breaker.records.acceptance import check_folder, document_of
from breaker.records.curves import Grid, read_curves
from breaker.records.folder import (
    fingerprint,
    known_of,
    list_fleet,
    list_operations,
    record_files,
)
from breaker.records.operations import Operation


def fill(folder, *names):
    for name in names:
        file = folder / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text("", encoding="utf-8")


def table(folder, *rows, head="file,motion,operation,breaker,phase"):
    (folder / "operations.csv").write_text("\n".join([head, *rows]), encoding="utf-8")


def test_files_of_all_readable_kinds_are_records(tmp_path):
    readable = ["1.csv", "10.tsv", "2.TXT", "3.tsv", "4.xlsx", "5.cfg"]
    paired = ["6.cff", "5.dat", ".8.csv", "~$4.xlsx", "11.md"]
    fill(tmp_path, *readable, *paired, "old/12.csv", "operations.csv")
    assert [file.name for file in record_files(tmp_path)] == [*readable]
    assert record_files(tmp_path / "nowhere") == []


def test_one_of_several_breakers_and_phases_must_be_chosen_among_those_that_are_there(tmp_path):
    fill(tmp_path, "1.csv")
    rows = [(b, p) for b in ("Q1", "Q2") for p in ("L1", "L2", "L3")]
    table(tmp_path, *(f"1.csv,closing,7,{b},{p}" for b, p in rows))
    (result,) = list_operations(tmp_path, "closing", breaker="Q2", phase="L3")
    # As tuples: from Python 3.13 on, dataclasses that hold nan are unequal.
    one = Operation(7, tmp_path / "1.csv", breaker="Q2", phase="L3")
    assert astuple(result) == astuple(one)
    for reason, chosen in (
        (r"endurance\.breaker .* Q1, Q2", {}),
        (r"endurance\.breaker .* Q1, Q2", {"breaker": "Q9"}),
        (r"endurance\.phase .* L1, L2, L3", {"breaker": "Q1"}),
        (r"endurance\.phase .* L1, L2, L3", {"breaker": "Q1", "phase": "A"}),
    ):
        with pytest.raises(ValueError, match=reason):
            list_operations(tmp_path, "closing", **chosen)
    with pytest.raises(FileNotFoundError, match="opening"):
        list_operations(tmp_path, "opening", breaker="Q1", phase="L1")
    with pytest.raises(FileNotFoundError, match=r"operations\.csv"):
        list_operations(tmp_path / "nowhere", "closing")
    fleet = list_fleet(tmp_path, breakers=["Q1"], phase="L1")
    assert {name: len(some) for name, some in fleet.items()} == {"Q1": 1}
    with pytest.raises(ValueError, match=r"endurance\.phase is L4"):
        list_fleet(tmp_path, phase="L4")
    table(tmp_path, "1.csv,closing,1,Q3,L1")  # read again where it changes
    assert [*list_fleet(tmp_path)] == ["Q3"]


def test_a_missing_file_does_not_end_the_others(tmp_path):
    """It is rejected when it is read. Planted fault: all are missing."""
    fill(tmp_path, "op_1.csv")
    table(tmp_path, "op_1.csv,closing,1,,", "op_2.csv,closing,2,,")
    assert [item.number for item in list_operations(tmp_path, "closing")] == [1, 2]
    (tmp_path / "op_1.csv").unlink()
    with pytest.raises(ValueError, match=r"op_\d\.csv"):
        list_operations(tmp_path, "closing")


def test_the_fingerprint_changes_with_whatever_a_record_is_read_from(tmp_path):
    fill(tmp_path, "1.cfg", "1.dat", "2.cfg")
    for file in tmp_path.iterdir():
        os.utime(file, (1e9, 1e9))
    result = Operation(1, tmp_path / "1.cfg")
    seen = {fingerprint([result]), fingerprint([result, result])}
    for other in ({"channel": "A"}, {"settings": {"rate": 10.0}}, {"file": tmp_path / "2.cfg"}):
        seen.add(fingerprint([replace(result, **other)]))
    os.utime(result.file, (1e9, 1e9 + 1))
    seen.add(fingerprint([result]))
    result.file.with_suffix(".dat").write_text("new")
    seen.add(fingerprint([result]))
    assert len(seen) == 7
    assert fingerprint([result]) == fingerprint([result])


def test_each_record_is_read_with_what_its_row_states(tmp_path):
    """A linkage in degrees and half its rate, without times; and rows that state too little."""
    times = np.arange(0.0, 200.0, 0.1)
    travel = 14.0 / (1.0 + np.exp(60.0 - times))
    for name, reading in {"mm": travel, "deg": (90.0 - travel / 0.5)[::2]}.items():
        np.savetxt(tmp_path / f"{name}.csv", reading, fmt="%.3f", header="travel", comments="")
    rows = ["mm.csv,closing,1,10,,,", "deg.csv,closing,2,5,deg,0.5,-1"]
    rows += ["mm.csv,closing,3,,,,", "deg.csv,closing,4,5,deg,,-1"]
    table(tmp_path, *rows, head="file,motion,operation,rate,travel_unit,ratio,sign")
    listed = list_operations(tmp_path, "closing")
    grid = Grid(np.arange(-2.0, 58.0, 0.4))
    curves = read_curves(listed, {"time_column": None, "zero": "rest"}, grid, "closing")
    assert curves.accepted.values.tolist() == [True, True, False, False]
    assert curves.rate.values[:2] == pytest.approx([10.0, 5.0])
    strokes = curves.measured.sel(quantity="stroke").values[:2]
    assert strokes == pytest.approx([14.0, 14.0], abs=0.05)
    for reason, column in zip(curves.reason.values[2:], ("rate", "ratio"), strict=True):
        assert f"column {column} of operations.csv" in reason


def test_what_is_known_of_operations_of_any_motion(tmp_path):
    """An event belongs to the next operation that is looked at, whichever motion's row has it."""
    rows = [
        "a.csv,closing,1,L1,20,",
        "b.csv,opening,1,L1,24,greased",
        "c.csv,closing,4,L1,,inspected",
        "d.csv,opening,4,L1,,inspected",
        "e.csv,opening,5,L1,,remounted",
        "f.csv,opening,9,L1,-3,overhaul",
        "g.csv,opening,6,L2,99,repair",
    ]
    table(tmp_path, *rows, head="file,motion,operation,phase,temperature,event")
    operations = [item for _, item in list_fleet(tmp_path, phase="L1")[""]]
    events, conditions = known_of(operations, [1, 6, 8])
    assert events == {1: "greased", 6: "inspected, remounted"}
    assert conditions == {"temperature": {1: 22.0, 9: -3.0}}
    assert known_of([], [1]) == ({}, {})


def test_lines_are_operations_with_their_numbers_and_dates(tmp_path):
    """Planted fault: another file with the number of a line."""
    fill(tmp_path, "op_9.csv")
    values = ",".join(str(1200 + k % 7) for k in range(80))
    rows = [f"ID:{n};Time:2024-11-20 15:1{n}:07;Interval (ms):0.4;Values:{values}" for n in (3, 4)]
    (tmp_path / "angle.txt").write_text("\n".join(rows), encoding="utf-8")
    rows = ["angle.txt,closing,1,,", "op_9.csv,closing,9,,"]
    table(tmp_path, *rows)
    listed = [(o.number, o.line, o.date) for o in list_operations(tmp_path, "closing")]
    assert listed == [(3, 1, "2024-11-20T15:13:07"), (4, 2, "2024-11-20T15:14:07"), (9, 0, "")]
    table(tmp_path, *rows, "op_4.csv,closing,4,,")
    with pytest.raises(ValueError, match=r"angle\.txt, line 2 and .*op_4|op_4.* and .*line 2"):
        list_operations(tmp_path, "closing")


# ---- the check of a folder before training -------------------------------------------------------


@pytest.fixture(scope="module")
def life():
    return EnduranceTest.from_settings(simulated_test(defaults()), seed=1)


@pytest.fixture
def folder(tmp_path, life):
    """Twelve closings and an opening, of which a table names two breakers."""
    rows = []
    for motion, count in (("closing", 12), ("opening", 1)):
        for number in range(1, count + 1):
            name = f"{motion}_{number:03d}.csv"
            record = life.record(motion, number)
            write_curve(tmp_path / name, *record, motion=motion, operation=number)
            rows.append(f"{name},{motion},{number},CB{1 + number % 2},L1")
    table(tmp_path, *rows)
    return tmp_path


def test_a_folder_is_checked_by_breaker_phase_and_motion(folder):
    def check(**chosen):
        endurance = {"format": {}, "breaker": None, "phase": None} | chosen
        return check_folder(folder, endurance, defaults()["sensor"], ["closing", "opening"])

    checked = check()
    result = {item.name: len(item.accepted) for item in checked}
    expected = {"CB1 L1 closing": 6, "CB2 L1 closing": 6, "CB1 L1 opening": 0, "CB2 L1 opening": 1}
    assert result == expected
    assert [item.name for item in checked if item.error] == ["CB1 L1 opening"]
    line = text_of(document_of(checked)).splitlines()[1].split()
    assert line[:7] == ["CB1", "L1", "closing", "6", "6", "0", "0"]
    assert 14 < float(line[7]) <= float(line[9]) < 15
    assert {e.name.split()[0] for e in check(breaker="CB2")} == {"CB2"}
