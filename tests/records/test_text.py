"""The text of curve files: what is read right, and what is refused with its line."""

import time as clock
import tracemalloc
from contextlib import suppress

import numpy as np
import pytest

from breaker.common.randomness import generator
from breaker.records.cells import strict_numbers
from breaker.records.files import RejectedCurveError
from breaker.records.formats.detection import look_into, read_columns
from breaker.records.settings import complete

TIME = 0.1 * np.arange(40)
TRAVEL = np.round(0.05 * np.arange(40) ** 1.2, 3)
ROWS = [f"{t:.4f},{x:.3f}" for t, x in zip(TIME, TRAVEL, strict=True)]
PLAIN = {"time_unit": "ms"}
UNTIMED = {"time_column": None, "rate": 10}


@pytest.fixture
def file(tmp_path):
    return tmp_path / "record.csv"


def put(file, lines, *, eol="\n", encoding="utf-8"):
    file.write_bytes(eol.join([*lines, ""]).encode(encoding))


def read(file, channel="", **settings):
    return read_columns(file, complete({**PLAIN, **settings}), channel)


def refused(file, channel="", **settings):
    """The line with the reason for which a file is refused; None where there is none."""
    with pytest.raises(RejectedCurveError) as caught:
        read(file, channel, **settings)
    assert str(caught.value).startswith(str(file))
    assert str(caught.value).isprintable()
    return caught.value.line


def assert_read(columns, *, first=None, remarks=0):
    if columns.time is not None:
        np.testing.assert_allclose(columns.time, TIME, atol=1e-9)
    np.testing.assert_array_equal(columns.travel, TRAVEL)
    assert columns.lines.size == TIME.size
    assert len(columns.remarks) == remarks
    assert first in (None, columns.lines[0])


# ---- heads ------------------------------------------------------------------------------------

HEADS = {
    "units": ["time,travel", "[ms],(mm)"],
    "behind a bar": ["TIME/ms,travel/millimeter"],
    "a remark": ["# made by 7", "# time,travel", "ms,mm"],
    "long": [*(f"channel {i},{i},{i}" for i in range(45)), "time,travel"],
    "names twice": ["Title,time,travel", "time,travel"],
    "quoted": ['stroke 5" at most,', '"time","travel"', '"ms","mm"'],
    "blank lines": ["", "a", "", "time,travel,x", "", "ms,mm,1", ""],
    "an exact name": ["Travel [mm],time,travel"],
}


@pytest.mark.parametrize("name", HEADS)
def test_the_head_is_found(file, name):
    before = "7," * (name == "an exact name")
    put(file, [*HEADS[name], *(before + row for row in ROWS)])
    assert_read(read(file), first=len(HEADS[name]) + 1)


def test_files_without_names_are_read_by_numbers(file):
    preamble = ["made by 7", "rate,10000,1", "10"]
    put(file, [*preamble, *(f"{i},{row}" for i, row in enumerate(ROWS))])
    assert_read(read(file, time_column=2, travel_column=3), first=4)
    put(file, ROWS)
    assert_read(read(file, time_column=1, travel_column=2), first=1)
    refused(file, time_column=1, travel_column=3)
    put(file, ["time,travel,current,travel", *(f"{r},9,{r.split(',')[1]}" for r in ROWS)])
    refused(file)
    assert_read(read(file, channel="4"))
    put(file, ["travel", *(f"{x:.3f}" for x in TRAVEL)])
    assert_read(read(file, **UNTIMED))
    refused(file, rate=10.0)


# ---- units ------------------------------------------------------------------------------------


@pytest.mark.parametrize("head", ["ms,cm", "sec,mm", "ms,°", "ms,m/s"])
def test_a_contradicting_unit_is_refused_and_an_unknown_one_remarked_on(file, head):
    put(file, ["time,travel", head, *ROWS])
    refused(file)
    put(file, ["time ({}),travel [{}]".format(*head.split(",")), *ROWS])
    refused(file)
    put(file, ["time,travel,x", "ms,span,mm", *(f"{row},1" for row in ROWS)])
    assert_read(read(file), remarks=1)


# ---- cells ------------------------------------------------------------------------------------

NO_NUMBERS = ["١٢٣", "−1.5", "0x10", "inf", "nan1", "1e246", "12345678901234567890123", "15:13:07"]
NO_NUMBERS += ["OVERFLOW", "1.5 mm", "1_000", "1'000.5", "1 000", "1.2.3", "2,0,9"]


@pytest.mark.parametrize("cell", NO_NUMBERS)
@pytest.mark.parametrize("decimal", [".", ","])
def test_what_is_no_plain_number_is_refused_with_its_line(file, cell, decimal):
    rows = ["time,travel", *ROWS[:20], f"2.0000,{cell}", *ROWS[21:]]
    put(file, [row.translate(str.maketrans({",": ";", ".": decimal})) for row in rows])
    assert refused(file, delimiter=";", decimal=decimal) == 22


@pytest.mark.parametrize("decimal", [".", ","])
def test_quick_and_careful_reading_agree_to_the_last_digit(decimal):
    numbers = generator(1, "test numbers").standard_normal(200) * 10.0 ** np.arange(-9, 11, 0.1)
    shown = [f(float(x)) for x in numbers for f in (repr, "{:+.3e}".format)] + ["5.", ".5", "7"]
    cells, thousands = [text.replace(".", decimal) for text in shown], "1,234.5"
    quick, none = strict_numbers(cells, decimal)
    careful, wrong = strict_numbers([*cells, "", thousands], decimal)
    assert (none, wrong) == ([], [len(cells) + 1])
    np.testing.assert_array_equal(quick, [*map(float, shown)])
    np.testing.assert_array_equal(careful[:-2], quick)


@pytest.mark.parametrize("cell", ["", "NaN", "#N/A", "---", "  "])
def test_missing_samples_are_nan(file, cell):
    put(file, ["time,travel", *ROWS[:20], f"2.0000,{cell}", *ROWS[21:], "4.0", "4.1,2"])
    columns = read(file)
    assert np.flatnonzero(np.isnan(columns.travel)).tolist() == [20, 40]
    np.testing.assert_allclose(columns.time, [*TIME, 4.0, 4.1])


@pytest.mark.parametrize("words", ["OFF ON", "False True", "AUS EIN"])
def test_words_for_two_states_are_0_and_1(file, words):
    states = np.arange(40) > 20
    rows = [f"{row},{words.split()[closed]}" for row, closed in zip(ROWS, 1 * states, strict=True)]
    put(file, ["time,travel,contact", *rows])
    for column in ("contact", 3):
        paired = read(file, contact_column=column, trigger_column=0).paired
        np.testing.assert_array_equal(paired.pop("contact"), states)
        assert not paired  # the record starts with the trigger
    put(file, ["time,travel,contact", *rows[:-1], f"{ROWS[-1]},?"])
    assert refused(file, contact_column="contact")


def test_blanks_at_the_end_are_the_end_of_a_channel(file):
    put(file, ["time,travel,other", *(f"{row},1" for row in ROWS), "4.0,,1", "4.1,,1", ",,", ""])
    assert_read(read(file))
    put(file, ["travel,other", *(f"{row.split(',')[1]},1" for row in ROWS), ",1", ",1"])
    assert_read(read(file, **UNTIMED))


@pytest.mark.parametrize("line", ["", ";;", "Page 2"])
def test_a_gap_without_a_time_column_is_refused(file, line):
    """With times it is a gap in time; without, all that follows would be early by a sample."""
    rows = [f"0.5;{row.split(',')[1]};7" for row in ROWS]
    put(file, ["current;travel;other", *rows, "", line, "1;"])
    assert_read(read(file, delimiter=";", **UNTIMED))
    put(file, ["current;travel;other", *rows[:20], line, *rows[20:]])
    assert refused(file, delimiter=";", **UNTIMED) == 21
    if line != "Page 2":
        timed = ["time;travel", *(row.replace(",", ";") for row in ROWS)]
        put(file, [*timed[:20], line, *timed[20:]])
        assert_read(read(file, delimiter=";"))


# ---- signs between cells, ends of lines, encodings ----------------------------------------------


@pytest.mark.parametrize("delimiter", [",", ";", "\t", "|", " "])
@pytest.mark.parametrize("eol", ["\n", "\r\n", "\r", "\r\r\n"])
def test_any_delimiter_and_end_of_line_will_do(file, delimiter, eol):
    lines = [line.replace(",", delimiter) for line in ["time,travel", "[ms],[mm]", *ROWS]]
    if delimiter == " ":
        lines = [f"  {line} \t".replace(" 0", "    0") for line in lines]
    put(file, [*lines, "", "\x1a"], eol=eol)
    assert_read(read(file, delimiter=delimiter), first=3)
    assert look_into(file).settings["delimiter"] == delimiter


@pytest.mark.parametrize(
    ("written", "settings", "name"),
    [
        ("utf-8", "utf-8", "行程"),
        ("utf-8-sig", "utf-8", "行程"),
        ("utf-16", "utf-16", "行程"),
        ("gbk", "gb18030", "行程"),
        ("cp1251", "cp1251", "Ход"),
        ("cp1252", "cp1252", "Weg ±"),
    ],
)
def test_encodings_are_read_and_proposed(file, written, settings, name):
    put(file, [f"time,{name}", *ROWS], encoding=written)
    assert_read(read(file, travel_column=name, encoding=settings))
    assert look_into(file).names[1] == name


# ---- sizes ------------------------------------------------------------------------------------


def test_long_files_are_read_block_by_block(file):
    time = np.arange(100_000)
    put(file, ["time,travel", *(f"{t},{t % 7}.25" for t in time)])
    columns = read(file)
    np.testing.assert_array_equal(columns.time, time)
    np.testing.assert_array_equal(columns.travel, time % 7 + 0.25)
    np.testing.assert_array_equal(columns.lines, time + 2)
    with file.open("a", encoding="utf-8") as stream:
        stream.write("100000,?\n")
    assert refused(file) == 100_002


ODD = {
    "zeros": b"\0" * 1_000_000,
    "cells": b"1," * 500_000,
    "a long number": b"time,travel\n" + b"1" * 1_000_000,
    "nothing": b"",
    "another encoding": "time,travel\n0,1".encode("utf-16-le"),
    "brackets": b"time," + b"travel [" * 10_000 + b"\n1,2",
    "quotation marks": b'"' * 1_000_000,
    "blanks": (b" " * 999 + b"\n") * 1_000,
    "a long line": b"time,travel\n1," + b"1.," * 20_000 + b"x",
}


@pytest.mark.parametrize("content", ODD.values(), ids=ODD)
@pytest.mark.parametrize("delimiter", [",", " "])
def test_odd_files_are_refused_at_once(file, content, delimiter):
    """A file of a MB takes less than a second; what searches backwards would take many minutes."""
    file.write_bytes(content)
    start = clock.process_time()
    refused(file, delimiter=delimiter)
    with suppress(RejectedCurveError):
        columns = read(file, delimiter=delimiter, travel_column=3, **UNTIMED)
        assert columns.travel.size == 1  # too few for what comes after
    assert clock.process_time() - start < 60.0


# ---- files larger than a record -----------------------------------------------------------------


@pytest.mark.parametrize(
    "text",
    [
        (",".join(["1.5"] * 1_000_000) + "\n") * 8,
        (",".join(["1"] * 30) + "\n") * 300_000,
        "1\n" * 1_300_000,
    ],
    ids=["columns", "cells", "samples"],
)
def test_what_no_recorder_writes_is_refused_in_little_memory(file, text):
    file.write_text(text, encoding="utf-8", newline="")
    tracemalloc.start()
    with pytest.raises(RejectedCurveError):
        look_into(file)
    refused(file, travel_column=1, **UNTIMED)
    most = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert most < 2**28  # bytes; the largest file takes a quarter of it


@pytest.mark.parametrize("bad", ['"x', '"1;2', "1;2;3;4;5", "\0"])
def test_lines_that_are_short_long_or_quoted_oddly_hide_no_others(tmp_path, bad):
    """The third column is empty but for the last lines, which are read in a block of their own."""
    rows = [f"{i};{i / 7:.3f}" for i in range(20_000)] + [f"{i};1;2" for i in range(20_000)]
    rows[100] = bad
    file = tmp_path / "odd.txt"
    file.write_text("\n".join(rows), encoding="utf-8")
    time, _, third = look_into(file).columns[:3]
    assert np.isfinite(time).sum() >= 39_999
    assert np.isfinite(third[-20_000:]).sum() >= 19_999
