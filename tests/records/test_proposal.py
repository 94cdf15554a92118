"""A table is proposed for any folder of records, with what to check, and can be read as it is."""

import csv
import os

import numpy as np
import pytest

from breaker.records import table_proposal
from breaker.records.description import Description, InspectedMotion
from breaker.records.header import Header
from breaker.records.operations import read_manifest
from breaker.records.table_proposal import propose_manifest
from tests.exports import write


def folder_of(tmp_path, *names):
    """A folder with empty files."""
    for name in names:
        file = tmp_path / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text("")
    return tmp_path


def read_back(folder, text):
    """The rows of a proposed table, which is read as it is."""
    (folder / "operations.csv").write_text(text, encoding="utf-8")
    return read_manifest(folder / "operations.csv")


def proposed(tmp_path, *names):
    """Rows of the proposal as motion, counter, breaker, file and date, and what to check."""
    folder = folder_of(tmp_path, *names)
    text, remarks = propose_manifest(folder, configured=True)
    return [
        (motion, o.number, o.breaker, o.file.relative_to(folder).as_posix(), o.date)
        for motion, o in read_back(folder, text)
    ], remarks


def looked(tmp_path):
    """Rows of the table of a folder, by what is seen in its files, and what to check."""
    text, remarks = propose_manifest(tmp_path)
    return list(csv.DictReader(text.splitlines())), remarks


def test_numbers_are_those_of_the_names_where_they_state_them(tmp_path):
    names = ["op_7.csv", "op_12.csv", ".hidden/1.csv", "~$1.xlsx", "3\n.csv", "notes.md"]
    rows, remarks = proposed(tmp_path, *(f"closing/{name}" for name in names))
    assert [row[:2] for row in rows] == [("closing", 7), ("closing", 12)]
    assert [remark.isprintable() for remark in remarks] == [True]  # no table can have that name
    with pytest.raises(FileNotFoundError):
        propose_manifest(folder_of(tmp_path / "empty", "notes.md"))


@pytest.mark.parametrize(
    ("stems", "numbers"),
    [
        ("op_0005_closing|op_0009_closing", [5, 9]),
        ("record (2)|record (3)", [2, 3]),
        ("2000|2061", [2000, 2061]),
        *((stems, [1, 2]) for stems in ("op_3_10kHz|op_4_10kHz", "000003|000004")),
        *((stems, [1, 2]) for stems in ("run_15h13|run_15h14", "gap_0.5|gap_0.6", "op_5|op_05")),
    ],
)
def test_a_counter_is_the_only_number_of_each_name(tmp_path, stems, numbers):
    rows, _ = proposed(tmp_path, *(f"closing/{stem}.csv" for stem in stems.split("|")))
    assert [row[1] for row in rows] == numbers


def test_else_their_dates_order_them_and_no_date_is_that_of_the_file_system(tmp_path):
    names = [f"{m}/x_{day}-11-2024.csv" for m in ("closing", "opening") for day in (13, 20)]
    folder = folder_of(tmp_path, *names)
    os.utime(folder / names[0], (1e9, 1e9))
    rows, remarks = proposed(folder, *reversed(names))
    assert [(row[1], row[3], row[4]) for row in rows] == [
        (number, f"{motion}/x_{day}-11-2024.csv", f"2024-11-{day:02}")
        for number, day in ((1, 13), (2, 20))
        for motion in ("closing", "opening")
    ]
    assert remarks


def test_folders_state_motion_and_breaker(tmp_path):
    names = ["opening tests/closing/1.csv", "Q1/Einschaltung ein/1.csv", "Q1/AUS/1.csv"]
    names += ["Q2/1_close.csv", "Q3/close-open 1.csv"]
    rows, _ = proposed(tmp_path, *names)
    result = [("closing", "", 0), ("closing", "Q1", 1), ("opening", "Q1", 2), ("closing", "Q2", 3)]
    result += [("closing", "Q3", 4), ("opening", "Q3", 4)]
    assert [row[:4] for row in rows] == [(m, 1, of, names[i]) for m, of, i in result]
    with pytest.raises(ValueError, match="line 2, column motion"):
        proposed(tmp_path / "new", "1.csv", "2.csv")


def test_files_state_breaker_phase_date_motion_and_rate(tmp_path):
    """And copies, other files and rates that lack are named."""
    write(tmp_path / "b_20-11-2024.csv", date="14/03/2021", unused="cross")
    write(tmp_path / "a.csv", date="22/04/2023", motions=("opening",))
    write(tmp_path / "c.csv", serial="HV-2", date="15/03/2021", seed=1, rate=20.0, ratio=1.64)
    rows, remarks = looked(tmp_path)
    shown = [(r["breaker"], r["motion"], r["operation"], r["phase"], r["date"][:10]) for r in rows]
    assert shown == [
        *(("HV-2", "closing", "1", phase, "2021-03-15") for phase in "RYB"),
        *(("HV-20417", "closing", "1", phase, "2021-03-14") for phase in "RYB"),
        *(("HV-20417", "opening", "2", phase, "2023-04-22") for phase in "RYB"),
    ]
    assert [row["channel"] for row in rows[:3]] == ["Travel 1", "Travel 2", "Travel 3"]
    assert [row["rate"] for row in rows[2:4]] == ["20", "10"]
    assert {row["time_column"] for row in rows} == {"none"}
    write(tmp_path / "d.csv", serial="HV-2", date="15/03/2021", seed=1, rate=20.0, plot=800.0)
    write(tmp_path / "e.csv", date="14/03/2021", unused="cross", results={"Stroke (mm)": [178.0]})
    (tmp_path / "notes.txt").write_text("Two fitters, see photo 12.\n")
    text, remarks = propose_manifest(tmp_path)
    rows = list(csv.DictReader(text.splitlines()))
    assert {row["rate"] for row in rows if row["file"] == "d.csv"} == {"FILL IN"}
    with pytest.raises(ValueError, match="column rate: is to be filled in"):
        read_back(tmp_path, text)
    for name in ("e.csv", "notes.txt"):
        assert not any(row["file"] == name for row in rows)
        assert any(name in remark for remark in remarks)


def seen_in(tmp_path, files, monkeypatch):
    """Rows for files of one closing, by name: their serial number, dates and phase."""

    def look(opened, _):
        serial, dates, phase = files[opened.file.relative_to(tmp_path).as_posix()]
        return Description(
            Header(serial=serial, dates=dates), (InspectedMotion("closing", "T1", phase),)
        )

    monkeypatch.setattr(table_proposal, "describe_file", look)
    rows = {row["file"]: row for row in looked(folder_of(tmp_path, *files))[0]}
    return [rows[name] for name in files]


def test_what_no_header_states_is_in_the_names_or_to_be_filled_in(tmp_path, monkeypatch):
    either = ("2021-04-05T10:42:17", "2021-05-04T10:42:17")
    files = {f"5 {phase} 14.03.2021.csv": ("8", (), "") for phase in "ABC"}
    files |= {"5.5.2021.csv": ("7", ("2021-03-14",), ""), "x 04.05.2021.csv": ("7", either, "")}
    files |= {"Q2/y 6-5-2021.csv": ("", (), "")}
    rows = seen_in(tmp_path, files, monkeypatch)
    assert [row["phase"] for row in rows] == ["A", "B", "C", "", "", ""]
    assert {row["operation"] for row in rows[:3]} == {"1"}
    assert [row["date"] for row in rows[2:]] == ["2021-03-14", "2021-03-14", "FILL IN", "FILL IN"]
    assert [row["breaker"] for row in rows[2:]] == ["8", "7", "7", "FILL IN"]


def test_settings_in_which_files_differ_are_columns(tmp_path):
    write(tmp_path / "a.csv", channels=1, motions=("closing", "opening"), length=600.0)
    write(tmp_path / "b.csv", channels=1, date="15/03/2021", seed=1, zero=12.0)
    text = (tmp_path / "b.csv").read_text(encoding="utf-8").replace(",", ";")
    (tmp_path / "b.csv").write_bytes(text.replace("Tester", "Müller").encode("latin-1"))
    rows, _ = looked(tmp_path)
    signs = {(row["file"], row["delimiter"], row["encoding"], row["zero"]) for row in rows}
    assert signs == {("a.csv", ",", "utf-8", "0"), ("b.csv", ";", "cp1252", "rest")}


def test_each_line_that_is_a_record_has_a_row_with_its_motion(tmp_path):
    """Planted: a line is there twice."""
    at = np.arange(200.0)
    angle = 60.0 / (1.0 + np.exp(0.4 * (50.0 - at))) + 0.01 * np.sin(at**2)
    lines = []
    for k in range(4):
        values = angle[::-1] if k % 2 else angle
        cells = ",".join(f"{value + 0.01 * (k % 3):.2f}" for value in values)
        before = f"ID:{k + 5};Time:2024-05-0{k + 1} 10:00:00;Interval (ms):0.2"
        lines.append(f"{before};Angle [deg]:{cells}")
    (tmp_path / "bench.txt").write_text("\n".join([*lines, lines[-1]]))
    rows, remarks = looked(tmp_path)
    for k, row in enumerate(rows):
        assert (row["line"], row["operation"]) == (str(k + 1), str(k + 5))
        assert row["date"] == f"2024-05-0{k + 1}T10:00:00"
        assert row["motion"] == ("opening" if k % 2 else "closing")
        assert row["sign"] == "FILL IN"
    assert (len(rows), len(remarks)) == (4, 1)
