"""The table of operations is read strictly: each mistake has its line, column and remedy."""

import math
import re
from pathlib import Path

import pytest

from breaker.records.operations import READ, read_manifest
from breaker.records.settings import FORMAT

HEAD = "file,motion,operation"


def read(tmp_path, text, encoding="utf-8"):
    file = tmp_path / "operations.csv"
    file.write_bytes(text if isinstance(text, bytes) else text.encode(encoding))
    return read_manifest(file)


def test_a_table_says_all_there_is_to_say(tmp_path):
    (first, second, third) = read(
        tmp_path,
        "operation,file,motion,channel,breaker,phase,date,temperature,event,from,to\n"
        '7,run/op 1.csv,closing,travel A,Q0,L1,2024-11-20T15:13:07,21.5,"greased, set",0,99.5\n'
        "007,run/op 1.csv,Opening,travel A,Q0,L1,20.11.2024,-3,,200,\n"
        "\n"
        "8,run/öp 2.xlsx,closing,,Q0,L1,,,,,\n",
    )
    motion, operation = first
    assert (motion, operation.number, operation.channel) == ("closing", 7, "travel A")
    assert operation.file == tmp_path / "run/op 1.csv"
    assert (operation.begin, operation.end) == (0.0, 99.5)
    assert (operation.breaker, operation.phase) == ("Q0", "L1")
    assert (operation.date, operation.temperature) == ("2024-11-20T15:13:07", 21.5)
    assert operation.event == "greased, set"
    motion, operation = second
    assert (motion, operation.number, operation.date) == ("opening", 7, "2024-11-20")
    assert operation.begin == 200.0
    assert math.isnan(operation.end)
    assert math.isnan(third[1].temperature)
    assert third[1].event == ""


def test_a_row_states_settings_of_its_record(tmp_path):
    rows = [
        "file,motion,operation,rate,ratio,sign,zero,travel_unit,contact_column,time_column",
        "a.csv,closing,1,10,1.64,-1,rest,deg,Contact 2,none",
        "b.csv,closing,2,20,,,-3,,14,",
        "c.csv,closing,3,,,,,,,1",
        "d.csv,closing,4,,,,,,,",
    ]
    settings = [each.settings for _, each in read(tmp_path, "\n".join(rows))]
    deg = {"travel_unit": "deg", "ratio": 1.64, "zero": "rest", "sign": -1}
    assert settings[0] == {"rate": 10, "time_column": None, "contact_column": "Contact 2", **deg}
    assert settings[1] == {"rate": 20, "zero": -3, "contact_column": 14}
    assert settings[2:] == [{"time_column": 1}, {}]


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig"])
@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
@pytest.mark.parametrize("delimiter", [",", ";"])
def test_tables_of_any_office_are_read(tmp_path, encoding, end, delimiter):
    lines = [HEAD + ",event", "ä.csv,closing,1,", "b.csv,closing,2,"]
    text = end.join(lines).replace(",", delimiter) + end
    found = read(tmp_path, text, encoding)
    assert [each.number for _, each in found] == [1, 2]
    assert found[0][1].file.name == "ä.csv"


def test_semicolons_leave_the_comma_for_decimals(tmp_path):
    text = "file;motion;operation;temperature;to\na.csv;closing;1;21,5;{}\n"
    assert read(tmp_path, text.format("99,25"))[0][1].temperature == 21.5
    assert read(tmp_path, text.format("99,25"))[0][1].end == 99.25
    with pytest.raises(ValueError, match=r"line 2, column to: '1,000' is no number"):
        read(tmp_path, text.format("1,000"))  # a thousand to some


WRONG = [
    ("", "operations.csv: is empty"),
    (HEAD, "line 1: no operation follows"),
    ("a.csv,closing,1", "line 1, column 1: 'a.csv' is none of file, motion"),
    ("file,motion", "line 1: there is no column operation"),
    ("file,operation,counter", "'counter' is none of .*rename it"),
    (f"{HEAD},file\na.csv,closing,1,a.csv", "line 1, column 4: file is there twice"),
    ("file\tmotion\toperation\na.csv\tclosing\t1", "with commas or semicolons between"),
    (f"{HEAD}\na.csv,closing", "line 2, column 3: the line has 2 cells, but 3 columns"),
    (f"{HEAD}\na.csv,closing,1,", "line 2, column 4: the line has 4 cells, but 3 columns"),
    (f'{HEAD}\n"a.csv,closing,1\n', "is no table: .*quotation marks"),
    (f"{HEAD}\n,closing,1", "line 2, column file: is empty"),
    (f"{HEAD}\n../a.csv,closing,1", "line 2, column file: '../a.csv' is not in the folder"),
    (f"{HEAD}\nb/../../a.csv,closing,1", "is not in the folder of the table; put it there"),
    (f"{HEAD}\n/etc/passwd,closing,1", "is not in the folder"),
    (f"{HEAD}\nC:/a.csv,closing,1", "is not in the folder"),
    (f"{HEAD}\nclosing\\a.csv,closing,1", "write / between"),
    (f"{HEAD}\na\x00.csv,closing,1", r"cannot be printed|is no table"),
    (f"{HEAD}\na.csv,close,1", "line 2, column motion: 'close' is neither closing nor opening"),
    (f"{HEAD}\na.csv,,1", "column motion: '' is neither"),
    (f"{HEAD}\na.csv,closing,1_000", "line 2, column operation: '1_000' is no counter"),
    (f"{HEAD}\na.csv,closing,٣", "column operation: '٣' is no counter; .* digits 0 to 9"),
    (f"{HEAD}\na.csv,closing,-1", "is no counter"),
    (f"{HEAD}\na.csv,closing,1.0", "is no counter"),
    (f"{HEAD}\na.csv,closing,{'9' * 23}", "9 is no counter of operations, which is at most"),
    (f"{HEAD}\na.csv,closing,20241120", "write dates into the column date"),
    (f"{HEAD}\na.csv,closing,1\n\nb.csv,closing,01", "line 4, column operation: closing 1 is in l"),
    (f"{HEAD},date\na.csv,closing,1,11/20/2024", "line 2, column date: '11/20/2024' is no date"),
    (
        f"{HEAD},date\na.csv,closing,1,2024-02-30",
        "column date: '2024-02-30' is no date: day is out",
    ),
    (f"{HEAD},temperature\na.csv,closing,1,293.15", "293.15 is not between -60 and 120 °C"),
    (f"{HEAD},temperature\na.csv,closing,1,1e999", "is not between|is no number"),
    (f"{HEAD},temperature\na.csv,closing,1,nan", "column temperature: 'nan' is no number"),
    (f"{HEAD},temperature\na.csv,closing,1,2_0", "column temperature: '2_0' is no number"),
    (f"{HEAD},from,to\na.csv,closing,1,20,20", "column to: 20 is not after from, 20"),
    (f"{HEAD},from\na.csv,closing,1,1e246", "column from: 1e246 is not between"),
    (f"{HEAD},rate\na.csv,closing,1,10000", "line 2, column rate: 10000 is not between 0.5 and 1"),
    (f"{HEAD},ratio\na.csv,closing,1,0", "line 2, column ratio: 0 is not between 0.000001 and"),
    (f"{HEAD},ratio\na.csv,closing,1,1:2", "column ratio: '1:2' is no number; write it as 21.5"),
    (f"{HEAD},sign\na.csv,closing,1,down", "line 2, column sign: 'down' is none of 1, \\+1, -1"),
    (f"{HEAD},zero\na.csv,closing,1,open", "line 2, column zero: 'open' is no number; write"),
    (f"{HEAD},travel_unit\na.csv,closing,1,ft", "travel_unit: 'ft' is none of mm, cm, m, um, in"),
    (f"{HEAD},contact_column\na.csv,closing,1,0", "0 is no number of a column, 1 to 1000"),
    (f"{HEAD},time_column\na.csv,closing,1,{'9' * 30}", "is no number of a column, 1 to 1000"),
    (f"{HEAD},event\na.csv,closing,1,a\x1b[2J", r"column event: 'a\\x1b\[2J' has signs"),
    (f"{HEAD},event\na.csv,closing,1,{'x' * 201}", "column event: has 201 signs"),
    (f"{HEAD}\nä.csv,closing,1".encode("latin-1"), "line 2: is not UTF-8; save"),
    (f"{HEAD}\na.csv,closing,1".encode("utf-16"), "line 1: is not UTF-8"),
]


@pytest.mark.parametrize(("text", "reason"), WRONG)
def test_a_mistake_is_named_with_its_place_and_remedy(tmp_path, text, reason):
    with pytest.raises(ValueError, match=reason) as told:
        read(tmp_path, text)
    assert "operations.csv" in str(told.value)
    assert str(told.value).replace("\n", "").isprintable()


def test_all_mistakes_are_named_at_once_up_to_ten(tmp_path):
    with pytest.raises(ValueError, match="is wrong:") as told:
        read(tmp_path, HEAD + "\na.csv,close,x" * 30)
    lines = str(told.value).splitlines()
    assert len(lines) == 12
    assert lines[-1] == "  and 50 more"


def test_the_example_of_the_documentation_is_read(tmp_path):
    text = (Path(__file__).parents[2] / "docs/usage.md").read_text(encoding="utf-8")
    (example,) = re.findall(r"```\n(file,motion,operation,.*?)```", text, re.DOTALL)
    found = read(tmp_path, example)
    numbers = [(motion, each.number) for motion, each in found]
    assert numbers == [("closing", 1), ("opening", 1), ("closing", 2)]
    (table,) = re.findall(r"\| column \| meaning \|\n\|.*\n((?:\|.*\n)+)\nThe first three", text)
    named = [re.findall("`(.*?)`", row.split("|")[1]) for row in table.splitlines()]
    assert {name for each in named for name in each} == set(READ)
    assert {*named[-1]} == set(READ) & set(FORMAT)


def test_events_are_of_those_that_are_known(tmp_path):
    """Any text without a list of them; with one, file, line, column, the known, and a remedy."""
    text = f'{HEAD},event\na.csv,closing,1,Greased\nb.csv,closing,2,"greased, painted"\n'
    assert [each.event for _, each in read(tmp_path, text)] == ["Greased", "greased, painted"]
    file = tmp_path / "operations.csv"
    assert len(read_manifest(file, ["greased", "Painted, coated"])) == 2
    with pytest.raises(ValueError, match="painted") as caught:
        read_manifest(file, ["greased", "spring_replaced"])
    assert str(caught.value).startswith(
        f"{file} is wrong:\n  line 3, column event: 'painted' is no"
    )
    assert "greased, " in str(caught.value)
    assert "repair, spring replaced, transducer" in str(caught.value)
    assert "endurance.events" in str(caught.value)


def test_numbers_that_rise_while_dates_fall_are_refused(tmp_path):
    table = tmp_path / "operations.csv"
    head = "file,motion,operation,date\n"
    table.write_text(head + "a.csv,closing,1,2024-05-01\nb.csv,closing,2,2023-05-01\n")
    with pytest.raises(ValueError, match=r"line 3, column date: 2023-05-01, of closing 2, is earl"):
        read_manifest(table)
    table.write_text(
        head + "a.csv,closing,1,2024-05-01\nb.csv,closing,2,\nc.csv,closing,3,2024-05-01\n"
    )
    assert len(read_manifest(table)) == 3
