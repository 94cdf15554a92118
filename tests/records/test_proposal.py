"""A table is proposed for any folder of records, says what to check, and can be read as it is."""

import csv
import math
import os

import pytest

from breaker.records import table_proposal
from breaker.records.description import describe_file
from breaker.records.header import Header
from breaker.records.operations import read_manifest
from breaker.records.table_proposal import Description, Part, propose_manifest
from tests.exports import pole, write


def folder_of(tmp_path, *names):
    """A folder with empty files."""
    for name in names:
        file = tmp_path / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text("")
    return tmp_path


def proposed(tmp_path, *names):
    """Rows of the proposal as motion, counter, breaker, file and date, and what to check."""
    folder = folder_of(tmp_path, *names)
    text, remarks = propose_manifest(folder)
    (folder / "operations.csv").write_text(text, encoding="utf-8")
    rows = read_manifest(folder / "operations.csv")
    return [
        (motion, o.number, o.breaker, o.file.relative_to(folder).as_posix(), o.date)
        for motion, o in rows
    ], remarks


def test_numbers_are_those_of_the_names_where_they_say_them(tmp_path):
    rows, remarks = proposed(tmp_path, "closing/op_7_10kHz.csv", "closing/op_12_10kHz.csv")
    assert [row[:2] for row in rows] == [("closing", 7), ("closing", 12)]
    assert remarks == []


def test_else_their_dates_order_them_and_no_date_is_that_of_the_file_system(tmp_path):
    names = [
        f"{motion}/x_{day}-11-2024.csv" for motion in ("closing", "opening") for day in (3, 20)
    ]
    folder = folder_of(tmp_path, *names)
    os.utime(folder / names[0], (1e9, 1e9))
    rows, remarks = proposed(folder, *reversed(names))
    assert [(row[1], row[3], row[4]) for row in rows] == [
        (number, f"{motion}/x_{day}-11-2024.csv", f"2024-11-{day:02}")
        for number, day in ((1, 3), (2, 20))
        for motion in ("closing", "opening")
    ]
    assert remarks


def test_folders_say_motion_and_breaker(tmp_path):
    names = ["Q1/Einschaltung ein/1.csv", "Q1/AUS/1.csv", "Q2/1_close.csv", "Q2/1_trip.csv"]
    names.append("opening tests/closing/1.csv")
    rows, _ = proposed(tmp_path, *names)
    assert [row[:4] for row in rows] == [
        ("closing", 1, "", names[4]),
        ("closing", 1, "Q1", names[0]),
        ("opening", 1, "Q1", names[1]),
        ("closing", 1, "Q2", names[2]),
        ("opening", 1, "Q2", names[3]),
    ]


@pytest.mark.parametrize("names", [["1.csv", "2.csv"], ["close-open 1.csv", "close-open 2.csv"]])
def test_a_file_of_no_said_motion_may_hold_both(tmp_path, names):
    rows, remarks = proposed(tmp_path, *names)
    assert [row[:2] for row in rows] == [(m, n) for n in (1, 2) for m in ("closing", "opening")]
    assert "the motion of 2 files, so each has a row of closing and opening" in remarks[0]


def test_any_mixture_gives_a_table_that_can_be_read(tmp_path):
    names = ["closing/x_1_2.csv", "closing/x_1_3.csv", "z.csv", "opening/1.csv", "Q/deep/er/8.xlsx"]
    names += ["closing/a,b \"q;'.csv", "opening/ä ö.txt", ".hidden/1.csv", "~$1.xlsx", "notes.md"]
    rows, _ = proposed(tmp_path, *names, "store.zarr/0/1.csv")
    assert {row[3] for row in rows} == {*names[:7], "store.zarr"}
    for motion in ("closing", "opening"):
        for breaker in ("", "Q/deep/er"):
            of = [row[1] for row in rows if (row[0], row[2]) == (motion, breaker)]
            assert of == list(range(1, len(of) + 1)) or of == [8]


def test_what_no_table_can_name_is_left_out_and_said(tmp_path):
    names = "closing/1.csv", "closing/{x} 2.csv", "closing/3\n.csv", "closing/6\u200c.csv"
    folder = folder_of(tmp_path, *names)
    os.mkfifo(folder / "closing/4.csv")
    with open(os.fsencode(folder) + b"/closing/caf\xe9 5.csv", "w"):
        pass
    text, remarks = propose_manifest(folder)
    assert len(text.splitlines()) == 2
    assert len(remarks) == 5
    assert all(each.startswith("left out: ") and each.isprintable() for each in remarks)


@pytest.mark.parametrize(
    ("name", "reason"), [("{}/nowhere", "no folder"), ("", "no folder ''"), ("{}", "no file of a")]
)
def test_a_folder_without_records_has_no_table(tmp_path, name, reason):
    with pytest.raises(FileNotFoundError, match=reason):
        propose_manifest(name.format(tmp_path))


def test_a_folder_of_everything_is_refused_before_it_is_looked_through(tmp_path, monkeypatch):
    monkeypatch.setattr(table_proposal, "MOST_PARTS", 3)
    for name in ("a", "b", "c"):
        (tmp_path / name).mkdir()
    with pytest.raises(FileNotFoundError, match="no file of a"):
        propose_manifest(tmp_path)
    (tmp_path / "d").mkdir()
    with pytest.raises(FileNotFoundError, match=r"more than 3 folders.*name the folder"):
        propose_manifest(tmp_path)


def analysers(tmp_path, *given):
    """Rows of the table of a folder with exports of an analyser, and what to check."""
    for name, settings in given:
        write(tmp_path / name, **settings)
    text, remarks = propose_manifest(tmp_path, look=describe_file)
    (tmp_path / "operations.csv").write_text(text, encoding="utf-8")
    return list(csv.DictReader(text.splitlines())), remarks


def test_an_analysers_files_say_breaker_phase_date_and_motion(tmp_path):
    rows, _ = analysers(
        tmp_path,
        ("b_20-11-2024.csv", {"date": "14/03/2021", "unused": "cross"}),
        ("a.csv", {"date": "22/04/2023", "motions": ("opening",)}),
        ("c.csv", {"serial": "HV-2", "date": "15/03/2021", "seed": 1}),
    )
    said = [(r["breaker"], r["motion"], r["operation"], r["phase"], r["date"][:10]) for r in rows]
    phases = "RYB"
    assert said == [
        *(("HV-2", "closing", "1", phase, "2021-03-15") for phase in phases),
        *(("HV-20417", "closing", "1", phase, "2021-03-14") for phase in phases),
        *(("HV-20417", "opening", "2", phase, "2023-04-22") for phase in phases),
    ]
    assert [row["channel"] for row in rows[:3]] == ["Travel 1", "Travel 2", "Travel 3"]
    assert {row["rate"] for row in rows} == {"10"}
    assert {row["time_column"] for row in rows} == {"none"}
    assert len(read_manifest(tmp_path / "operations.csv")) == 9


def test_two_motions_of_a_kind_in_a_file_are_two_operations(tmp_path):
    motions = ("opening", "closing", "opening")
    rows, _ = analysers(tmp_path, ("a.csv", {"motions": motions, "length": 600.0, "channels": 1}))
    found = [(row["motion"], row["operation"], row["from"], row["to"]) for row in rows]
    assert [each[:2] for each in found] == [("closing", "1"), ("opening", "1"), ("opening", "2")]
    assert found[0][2:] == ("", "")
    assert float(found[1][3]) < 205.0 < float(found[2][2])


def test_copies_and_rates_that_lack_are_named(tmp_path):
    both = {"motions": ("closing",), "channels": 1}
    rows, remarks = analysers(
        tmp_path,
        ("a.csv", both),
        ("b.csv", both),
        ("c.csv", both | {"rate": 20.0, "ratio": 1.64, "date": "02/04/2021"}),
        ("d.csv", both | {"plot": 800.0, "date": "02/05/2021"}),
    )
    assert [(row["file"], row["rate"]) for row in rows] == [
        ("a.csv", "10"),
        ("c.csv", "20"),
        ("d.csv", "FILL IN"),
    ]
    with pytest.raises(ValueError, match=r"column rate: is to be filled in for d\.csv, which does"):
        read_manifest(tmp_path / "operations.csv")
    shown = "; ".join(remarks)
    for said in ("left out: b.csv", "first d.csv"):
        assert said in shown


def said_of(tmp_path, files):
    """Rows and remarks for files of one closing: by name their serial number, dates and phase."""
    folder_of(tmp_path, *files)

    def look(file):
        serial, dates, phase = files[file.relative_to(tmp_path).as_posix()]
        part = Part("closing", "T1", phase, math.nan, math.nan, math.nan)
        return Description(Header(serial=serial, dates=dates), (part,), 10.0)

    text, remarks = propose_manifest(tmp_path, look=look)
    return {row["file"]: row for row in csv.DictReader(text.splitlines())}, remarks


def test_files_of_a_pole_each_are_poles_of_one_operation(tmp_path):
    days = {"x": "2021-07-11", "y": "2021-03-11"}
    files = {f"{k}-{p}.csv": ("7", (day,), p) for k, day in days.items() for p in "RYB"}
    rows, _ = said_of(tmp_path, files)
    assert [(rows[name]["operation"], rows[name]["date"]) for name in files] == [
        *[("2", days["x"])] * 3,
        *[("1", days["y"])] * 3,
    ]


def test_what_no_file_states_is_that_of_its_folder_or_to_be_filled_in(tmp_path):
    files = {"a.csv": ("7", (), ""), "b.csv": ("", (), ""), "Q2/c.csv": ("", (), "")}
    rows, remarks = said_of(tmp_path, files)
    assert [rows[name]["breaker"] for name in files] == ["7", "FILL IN", "Q2"]
    assert any("the breaker of 1 files is to be filled in, first b.csv" in each for each in remarks)


def test_poles_that_no_text_names_are_named_by_files(tmp_path):
    named = {f"5 {phase} 14.03.2021.csv": ("8", (), "") for phase in "ABC"}
    rows, _ = said_of(tmp_path, named | {"9.csv": ("7", (), "")})
    assert [rows[name]["phase"] for name in named] == ["A", "B", "C"]
    assert {rows[name]["operation"] for name in named} == {"1"}
    assert rows["9.csv"]["phase"] == ""


@pytest.mark.parametrize("phases", [["R-1 CT", "Y-1 CT"], ["Y-1", "Y-2"], ["L1", "L2"]])
def test_phases_are_those_of_the_header_as_they_stand_there(tmp_path, phases):
    for seed, phase in enumerate(phases):
        pole(tmp_path / f"{'ab'[seed]}.csv", phase, seed)
    rows, _ = analysers(tmp_path)
    assert [(row["phase"], row["operation"]) for row in rows] == [(each, "1") for each in phases]


def test_a_date_is_that_of_the_header_or_else_of_the_name(tmp_path):
    either = ("2021-04-05T10:42:17", "2021-05-04T10:42:17")
    files = {"5.5.2021.csv": ("7", ("2021-03-14",), ""), "x 04.05.2021.csv": ("7", either, "")}
    files |= {"6.5.2021.csv": ("7", (), ""), "y 6-5-2021.csv": ("7", (), "")}
    rows, remarks = said_of(tmp_path, files)
    dates = {name: row["date"] for name, row in rows.items()}
    assert [dates[name] for name in files] == ["2021-03-14", "FILL IN", "2021-05-06", "FILL IN"]
    assert any("the date of 2 files is to be filled in" in each for each in remarks)


def test_other_files_decide_on_day_and_month(tmp_path):
    one = {"channels": 1}
    given = [(f"{k}.csv", one | {"date": day, "seed": k}) for k, day in enumerate(["03/04/2021"])]
    rows, _ = analysers(tmp_path, *given)
    assert [row["date"] for row in rows] == ["FILL IN"]
    given += [("8.csv", one | {"date": "16/04/2021", "seed": 8})]
    rows, remarks = analysers(tmp_path, *given)
    assert [row["date"][:10] for row in rows] == ["2021-04-03", "2021-04-16"]
    assert any("0.csv" in each and "order of another file" in each for each in remarks)
    rows, _ = analysers(tmp_path, *given, ("9.csv", one | {"date": "04/17/2021", "seed": 9}))
    assert "FILL IN" in [row["date"] for row in rows]


def test_equal_samples_count_once_unless_files_state_otherwise(tmp_path):
    """A copy that was saved again has other bytes; copies of two breakers are a doubt."""
    one = {"channels": 1, "bay": "Bay 4"}
    rows, remarks = analysers(
        tmp_path,
        ("a.csv", one),
        ("b.csv", one | {"results": {"Stroke (mm)": [178.0]}}),
        ("c.csv", one | {"serial": "HV-2"}),
        ("d.csv", one | {"seed": 1}),
    )
    assert sorted({row["file"] for row in rows}) == ["a.csv", "c.csv", "d.csv"]
    assert {row["breaker"] for row in rows} == {"HV-20417", "HV-2"}
    assert any("left out: b.csv has the samples of a.csv" in each for each in remarks)
    assert any("c.csv has the samples of a.csv, but" in each for each in remarks)


def test_channels_without_phases_are_to_be_filled_in(tmp_path):
    (tmp_path / "a.csv").touch()
    parts = [Part("closing", f"T{i}", "", math.nan, math.nan, math.nan) for i in (1, 2)]
    text, _ = propose_manifest(tmp_path, look=lambda _: Description(parts=tuple(parts)))
    assert [row["phase"] for row in csv.DictReader(text.splitlines())] == ["FILL IN"] * 2


def test_a_motion_that_is_a_guess_is_to_be_filled_in(tmp_path):
    folder = folder_of(tmp_path, "a.csv", "closing/b.csv")
    part = Part("closing", "s", "", math.nan, math.nan, math.nan)
    seen = Description(parts=(part,), settings={"sign": 1, "delimiter": "\t"}, sure=False)
    text, _ = propose_manifest(folder, look=lambda _: seen)
    rows = {row["file"]: row for row in csv.DictReader(text.splitlines())}
    assert (rows["a.csv"]["motion"], rows["closing/b.csv"]["motion"]) == ("FILL IN", "closing")
    assert rows["a.csv"]["delimiter"] == "tab"


def test_what_is_no_record_is_said(tmp_path):
    (tmp_path / "notes.txt").write_text("Two fitters, see photo 12.\n")
    (tmp_path / "hours.csv").write_text("h,degC\n" + "".join(f"{i},{i % 7}\n" for i in range(99)))
    rows, remarks = analysers(tmp_path, ("a.csv", {"channels": 1}))
    assert [row["file"] for row in rows] == ["a.csv"]
    shown = "; ".join(remarks)
    for said in ("left out: notes.txt", "left out: hours.csv", "motions: [closing]"):
        assert said in shown


def test_settings_in_which_files_differ_are_columns(tmp_path):
    write(tmp_path / "a.csv", channels=1, motions=("closing", "opening"), length=600.0)
    write(tmp_path / "b.csv", channels=1, date="15/03/2021", seed=1, zero=12.0)
    text = (tmp_path / "b.csv").read_text(encoding="utf-8").replace(",", ";").replace("Ä", "A")
    (tmp_path / "b.csv").write_bytes(text.replace("Tester", "Müller").encode("latin-1"))
    rows, _ = analysers(tmp_path)
    signs = {(row["file"], row["delimiter"], row["encoding"], row["zero"]) for row in rows}
    assert signs == {("a.csv", ",", "utf-8", "0"), ("b.csv", ";", "cp1252", "rest")}
