"""Tables of operations and settings: a mistake has its place and remedy before a file is opened."""

import math
from dataclasses import astuple

import pytest

from breaker.records.operations import Operation, read_manifest
from breaker.records.settings import complete

HEAD = "file,motion,operation"


def read(tmp_path, text, encoding="utf-8"):
    file = tmp_path / "operations.csv"
    file.write_bytes(text if isinstance(text, bytes) else text.encode(encoding))
    return read_manifest(file)


def test_a_table_states_all_of_an_operation(tmp_path):
    first, second, third = read(
        tmp_path,
        "operation,file,motion,channel,breaker,phase,date,temperature,event,from,to,transducer\n"
        '7,run/op 1.csv,closing,travel A,Q0,L1,2024-11-20T15:13:07,21.5,"greased, set",0,99.5,T 1\n'
        "007,run/op 1.csv,Opening,travel A,Q0,L1,20.11.2024,-3,,200,,\n"
        "\n"
        "8,run/öp 2.xlsx,closing,,Q0,L1,,,,,,\n",
    )
    expected = Operation(
        7,
        tmp_path / "run/op 1.csv",
        begin=0.0,
        end=99.5,
        channel="travel A",
        breaker="Q0",
        phase="L1",
        date="2024-11-20T15:13:07",
        temperature=21.5,
        event="greased, set",
        transducer="T 1",
    )
    # As tuples: from Python 3.13 on, dataclasses that hold nan are unequal.
    assert (first[0], astuple(first[1])) == ("closing", astuple(expected))
    motion, operation = second
    assert (motion, operation.number, operation.date) == ("opening", 7, "2024-11-20")
    assert operation.begin == 200.0
    assert math.isnan(operation.end)
    assert math.isnan(third[1].temperature)


def test_a_row_states_settings_of_its_record(tmp_path):
    rows = [
        "file,motion,operation,rate,ratio,sign,zero,travel_unit,contact_column,time_column",
        "a.csv,closing,1,10,1.64,-1,rest,deg,Contact 2,none",
        "b.csv,closing,2,20,,,-3,,14,1",
        "d.csv,closing,4,,,,,,,",
    ]
    settings = [item.settings for _, item in read(tmp_path, "\n".join(rows))]
    deg = {"travel_unit": "deg", "ratio": 1.64, "zero": "rest", "sign": -1}
    assert settings[0] == {"rate": 10, "time_column": None, "contact_column": "Contact 2", **deg}
    assert settings[1:] == [{"rate": 20, "zero": -3, "contact_column": 14, "time_column": 1}, {}]


SHEETS = {
    "empty columns behind": "file;motion;operation;temperature;;\na.csv;closing;1;21,5;;\n;;;;;\n",
    "tabs": "file\tmotion\toperation\ttemperature\na.csv\tclosing\t1\t21,5\n",
    "quoted cells": '"File";"Motion";"Operation";"Temperature"\n"a.csv";"Closing";"1";"21,5"',
    "commas with a quoted decimal": f'{HEAD},temperature\na.csv,closing,1,"21,5"\n',
    "an empty column between": "file;;motion;operation;temperature\na.csv;;closing;1;21,5\n",
}


@pytest.mark.parametrize("text", SHEETS.values(), ids=SHEETS)
def test_tables_of_spreadsheets_are_read(tmp_path, text):
    ((motion, item),) = read(tmp_path, text, "utf-8-sig")
    assert (motion, item.number, item.temperature) == ("closing", 1, 21.5)


def rows(*cells, more=""):
    return "\n".join([HEAD + more, *cells])


def dated(*cells):
    return rows(*(f"a.csv,closing,{n},{c}" for n, c in enumerate(cells)), more=",date")


def test_other_dates_of_the_column_decide_on_day_and_month(tmp_path):
    for cells, days in (
        (["03/04/2026", "16/04/2026 9:05"], ["2026-04-03", "2026-04-16T09:05:00"]),
        (["3/4/2026 1:05 PM", "3/16/2026", ""], ["2026-03-04T13:05:00", "2026-03-16", ""]),
    ):
        assert [item.date for _, item in read(tmp_path, dated(*cells))] == days
    for cells in (["03/04/2026", "16.04.2026"], ["16/04/2026", "04/17/2026", "03/04/2027"]):
        with pytest.raises(ValueError, match=r"column date: '03/04/202\d' .*-04-03.*-03-04"):
            read(tmp_path, dated(*cells))


def test_days_that_fall_while_numbers_rise_are_refused(tmp_path):
    """But not the night when summer time ends."""
    night = ["2024-10-27T02:50:00+02:00", "2024-10-27T02:10:00+01:00", "2024-10-27", "2024-10-28"]
    assert len(read(tmp_path, dated(*night))) == 4
    with pytest.raises(ValueError, match="line 3, column date: 2024-10-27"):
        read(tmp_path, dated(*night[::-1]))


WRONG = [
    ("", "line 1"),
    (HEAD, "line 1: "),
    ("file,motion", "line 1: .*operation"),
    ('"file,motion', "line 1: .*quotation marks"),
    ("file,operation,counter", "line 1: .*'counter'"),
    (f"{HEAD},file\na.csv,closing,1,a.csv", "line 1: .*'file'"),
    (rows("a.csv,closing"), "line 2, column operation: "),
    (rows("a.csv,closing,1,,x"), "line 2, .*'x'"),
    (rows('"a.csv,closing,1\n'), "line 2: .*quotation marks"),
    (rows("a\x00.csv,closing,1"), "line 2"),
    (rows("a.csv,closing,1", "", "b.csv,closing,01"), "line 4, column operation: .* line 2"),
    (rows("a.csv,closing,1,20,20", more=",from,to"), "line 2, column to: 20 .* 20"),
    (rows("ä.csv,closing,1").encode("latin-1"), "UTF-8"),
]
CELLS = {
    "file": ["", "../a.csv", "b/../../a.csv", "/etc/passwd", "C:/a.csv", "closing\\a.csv"],
    "motion": ["", "close"],
    "operation": ["", "1_000", "٣", "-1", "1.0", "9" * 300, "20241120"],
    "event": ["a\x1b[2J", "x" * 201],
    "temperature": ["293.15", "1e999", "nan", "2_0"],
    "ratio": ["0", "1:2", "1,000"],
}
CELLS |= {"date": ["2024-02-30"], "from": ["1e246"], "rate": ["10000", "fill in"], "zero": ["open"]}
CELLS |= {"sign": ["down"], "travel_unit": ["ft"], "line": ["0"], "contact_column": ["0"]}
CELLS |= {"time_column": ["9" * 30], "breaker": ["FILL IN"]}
for column, cells in CELLS.items():
    for cell in cells:
        row = {"file": "a.csv", "motion": "closing", "operation": "1", column: f'"{cell}"'}
        WRONG.append((f"{','.join(row)}\n{','.join(row.values())}", f"line 2, column {column}: "))


@pytest.mark.parametrize(("text", "reason"), WRONG)
def test_a_mistake_is_named_with_its_place_and_remedy(tmp_path, text, reason):
    with pytest.raises(ValueError, match=reason) as refused:
        read(tmp_path, text)
    assert "operations.csv" in str(refused.value)
    assert str(refused.value).replace("\n", "").isprintable()


# ---- settings ------------------------------------------------------------------------------------


@pytest.mark.parametrize("settings", [{"colour": "red"}, {"encoding": "base64"}])
def test_unknown_settings_are_refused(settings):
    with pytest.raises(ValueError, match=next(iter(settings))):
        complete(settings)
