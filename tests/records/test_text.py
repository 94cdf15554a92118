"""The text of curve files: what is read right, and what is refused with its line."""

import time as clock

import numpy as np
import pytest

from breaker.common.randomness import generator
from breaker.drive.simulation.dialects import DIALECTS
from breaker.records.axes import even_times
from breaker.records.cells import strict_numbers
from breaker.records.files import RejectedCurveError
from breaker.records.formats.registry import look_into, read_columns
from breaker.records.rejections import UnusableError
from breaker.records.settings import TO_MS, complete
from breaker.records.words import split_unit, unit_of

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


@pytest.mark.parametrize("name", DIALECTS)
def test_every_dialect_is_read_back_to_its_printed_digits(tmp_path, name):
    """The preamble differs from file to file; a stroke of 14 mm in noise, 10 kHz."""
    dialect, rng = DIALECTS[name], generator(1, "test dialect", name)
    settings, time = complete(dialect.settings), 0.1 * np.arange(300)
    for operation in range(1, 6):
        travel = 14 / (1 + np.exp(15 - time)) + 0.1 * rng.standard_normal(time.size)
        file = tmp_path / dialect.file_name("closing", operation)
        dialect.write(file, time, travel, motion="closing", operation=operation)
        columns = read_columns(file, settings)
        if columns.time is None:
            assert settings["rate"] == dialect.rate == 10
        else:
            np.testing.assert_allclose(columns.time * TO_MS[settings["time_unit"]], time, atol=1e-6)
        np.testing.assert_allclose(columns.travel, dialect.reading(travel), rtol=1e-12, atol=1e-12)
        assert columns.remarks == ()


# ---- heads ------------------------------------------------------------------------------------

HEADS = {
    "names": ["time,travel"],
    "units": ["time,travel", "[ms],(mm)"],
    "other spellings": ["TIME,TRAVEL", "msec,millimeter"],
    "in the names": ["Time (ms),Travel [mm]"],
    "behind a bar": ["time/ms,travel/mm"],
    "a remark": ["# time,travel", "# nothing", "ms,mm"],
    "long": [*(f"channel {i},{i},{i}" for i in range(45)), "time,travel"],
    "names twice": ["Title,time,travel", "time,travel"],
    "quoted": ['stroke 5" at most,', '"time","travel"', '"ms","mm"'],
    "blank lines": ["", "a", "", "time,travel", "", "ms,mm", ""],
    "other columns without unit": ["time,travel,x", "ms,mm,1"],
    "trailing": ["time,travel,,", "ms,mm,,"],
    "an exact name": ["Travel [mm],time,travel"],
}


@pytest.mark.parametrize("name", HEADS)
def test_the_head_is_found(file, name):
    before = "7," * (name == "an exact name")
    put(file, [*HEADS[name], *(before + row for row in ROWS)])
    assert_read(read(file), first=len(HEADS[name]) + 1)


@pytest.mark.parametrize(
    "head",
    [
        ["Time,Travel (in),Travel (in)", "ms,L1,L2"],
        ["Time,Travel (in),", "ms,L1,L2"],
        ["Time,Travel,", "t,L1,L2", "ms,in,in"],
    ],
)
def test_both_of_two_lines_of_names_count(file, head):
    put(file, [*head, *(f"{row},7" for row in ROWS)])
    sheet = look_into(file)
    assert sheet.units == ["ms", "inch", "inch"]
    time = str(sheet.column(0))
    assert [sheet.column(1), sheet.column(2)] == ["Travel L1", "Travel L2"]
    assert_read(read(file, "Travel L1", time_column=time, travel_unit="inch"))
    refused(file, "Travel L1", time_column=time)  # in mm
    refused(file, "Travel", time_column=time, travel_unit="inch")


def test_files_without_names_are_read_by_numbers(file):
    numbers = {"time_column": 1, "travel_column": 2}
    preamble = ["made by 7", "rate,10000,1", "10,20"]
    put(file, [*preamble, *(f"{i},{row}" for i, row in enumerate(ROWS))])
    assert_read(read(file, time_column=2, travel_column=3), first=4)
    put(file, ROWS)
    assert_read(read(file, **numbers), first=1)
    refused(file, time_column=1, travel_column=3)
    put(file, ["a,b", "ms,cm", *ROWS])
    assert refused(file, **numbers) == 2


def test_doubled_names_are_refused_and_read_by_number(file):
    put(file, ["time,travel,current,travel", *(f"{r},9,{r.split(',')[1]}" for r in ROWS)])
    assert refused(file) == 1
    assert_read(read(file, travel_column=4))
    assert_read(read(file, channel="4"))


def test_a_rate_is_enough_where_there_is_no_column_of_the_time(file):
    put(file, ["travel", *(f"{x:.3f}" for x in TRAVEL)])
    columns = read(file, rate=10.0)
    assert columns.time is None
    assert_read(columns, remarks=1)
    refused(file)
    put(file, ["time,travel", *ROWS])
    assert_read(read(file, rate=10.0))


# ---- units ------------------------------------------------------------------------------------


@pytest.mark.parametrize("head", ["ms,cm", "sec,mm", "ms,°", "ms,m/s"])
def test_a_contradicting_unit_is_refused(file, head):
    put(file, ["time,travel", head, *ROWS])
    assert refused(file) == 2
    put(file, ["time ({}),travel [{}]".format(*head.split(",")), *ROWS])
    assert refused(file) == 1


def test_an_unknown_unit_is_remarked_on(file):
    put(file, ["time,travel", "ms,span", *ROWS])
    assert_read(read(file), remarks=1)


@pytest.mark.parametrize(
    ("unit", "spellings"),
    {
        "s": ["s", "sec", "Sec.", "seconds", "[s]"],
        "ms": ["ms", "(ms)", "msec", "MS", "milliseconds"],
        "us": ["us", "µs", "μs", "usec", "microseconds"],
        "deg": ["deg", "°", "[Deg]", "degrees", "Grad", "(grados)", "[gradi]", "degrés"],
        "inch": ["in", '"', "inches", "in.", "(in)", "pulgadas", "Zoll", "дюйм"],
        None: ["", "S", "M", "gone", "phase A", "1"],
    }.items(),
)
def test_units_are_known_in_any_spelling(unit, spellings):
    assert [unit_of(text) for text in spellings] == [unit] * len(spellings)


def test_a_unit_behind_a_blank_is_that_of_a_time_or_a_travel():
    names = {"weg cm": "cm", "Travel 1 mm": "mm", "Zeit s": "s", "t msec": "ms", "Hub zoll": "inch"}
    assert {name: split_unit(name)[1] for name in names} == names
    none = ["Coil mA", "Contact s", "Travel min", "travel in", "Travel S", "stroke phase"]
    none += ["Travel (A)", "Travel [V]", "S/W", "travel_in", "travel (S)", "t (Zeit)"]
    assert [split_unit(name) for name in none] == [(name, None) for name in none]


def test_names_with_numbers_are_names_and_a_unit_may_stand_alone(file):
    put(file, ["in ms,Travel (in),52a,52b", *(f"{row},0,1" for row in ROWS)])
    sheet = look_into(file)
    assert sheet.units == ["ms", "inch", None, None]
    assert [sheet.column(place) for place in (2, 3)] == ["52a", "52b"]


# ---- cells ------------------------------------------------------------------------------------

NO_NUMBERS = ["١٢٣", "１２", "−1.5", "0x10", "inf", "-Infinity", "nan1", "1e246", "1e999", "1.5e"]
NO_NUMBERS += ["12345678901234567890123", "15:13:07", "OVERFLOW", "1.5 mm", "1_000", "1'000.5"]


@pytest.mark.parametrize("cell", [*NO_NUMBERS, "1 000", "1.2.3"])
@pytest.mark.parametrize("decimal", [".", ","])
def test_what_is_no_plain_number_is_refused_with_its_line(file, cell, decimal):
    rows = ["time,travel", *ROWS[:20], f"2.0000,{cell}", *ROWS[21:]]
    swap = str.maketrans({",": ";", ".": decimal})
    put(file, [row.translate(swap) for row in rows])
    assert refused(file, delimiter=";", decimal=decimal) == 22


@pytest.mark.parametrize("decimal", [".", ","])
def test_numbers_are_those_of_python(decimal):
    """Quick and careful reading agree to the last digit; thousands are not decimals."""
    rng = generator(1, "test numbers")
    numbers = [*rng.standard_normal(200), *10.0 ** rng.uniform(-9, 8, 200), 0.0, 1e-400, -0.0]
    shown = [f(float(x)) for x in numbers for f in (repr, "{:.3e}".format, "{:+.4f}".format)]
    cells = [text.replace(".", decimal) for text in [*shown, "5.", ".5", " 7 "]]
    expected = [float(text) for text in [*shown, "5.", ".5", "7"]]
    quick, none = strict_numbers(cells, decimal)
    other = ".," if decimal == "," else ",."
    odd = ["x", f"1{other[0]}234", f"1{other[0]}234{other[1]}5"]
    careful, wrong = strict_numbers([*cells, "", *odd], decimal)
    assert none == []
    assert wrong == [len(cells) + k for k in (1, 2, 3)]
    np.testing.assert_array_equal(quick, expected)
    np.testing.assert_array_equal(careful[:-4], expected)


@pytest.mark.parametrize("cell", ["", "NaN", "#N/A", "-", "---", "  "])
def test_missing_samples_are_nan(file, cell):
    put(file, ["time,travel", *ROWS[:20], f"2.0000,{cell}", *ROWS[21:], "4.0", "4.1,2"])
    columns = read(file)
    assert np.flatnonzero(np.isnan(columns.travel)).tolist() == [20, 40]
    np.testing.assert_allclose(columns.time, [*TIME, 4.0, 4.1])


@pytest.mark.parametrize("words", ["OFF ON", "False True", "open closed", "AUS EIN"])
def test_words_for_two_states_are_0_and_1(file, words):
    off, on = words.split()
    states = np.arange(40) > 20
    rows = [f"{row},{on if state else off}" for row, state in zip(ROWS, states, strict=True)]
    put(file, ["time,travel,contact", *rows])
    np.testing.assert_array_equal(look_into(file).columns[2], states)
    np.testing.assert_array_equal(read(file, contact_column="contact").beside["contact"], states)
    put(file, ["time,travel,contact", *rows[:-1], f"{ROWS[-1]},?"])
    assert refused(file, contact_column="contact")


def test_blanks_at_the_end_are_the_end_of_a_channel(file):
    put(file, ["time,travel,other", *(f"{row},1" for row in ROWS), "4.0,,1", "4.1,,1", ",,", ""])
    assert_read(read(file))
    rows = [row.split(",")[1] for row in ROWS]
    put(file, ["travel,other", *(f"{x},1" for x in rows), ",1", ",1"])
    assert_read(read(file, **UNTIMED))
    put(file, ["travel,other", *(",1" for _ in rows)])
    refused(file, **UNTIMED)


@pytest.mark.parametrize("line", ["", "# stopped here", ";;", "Page 2", '""'])
def test_a_gap_without_a_time_column_is_refused(file, line):
    """With times it is a gap in time; without, all that follows would be early by a sample."""
    rows = [f"0.5;{row.split(',')[1]};7" for row in ROWS]
    put(file, ["current;travel;other", *rows, "", line, "1;"])
    assert_read(read(file, delimiter=";", **UNTIMED))
    put(file, ["current;travel;other", *rows[:20], line, *rows[20:]])
    assert refused(file, delimiter=";", **UNTIMED) == 21
    timed = ["time;travel", *(row.replace(",", ";") for row in ROWS)]
    put(file, [*timed[:20], line, *timed[20:]])
    if line == "Page 2":
        assert refused(file, delimiter=";") == 21
    else:
        assert_read(read(file, delimiter=";"))


def test_a_line_with_too_many_cells_is_refused(file):
    put(file, ["time,travel", *ROWS[:20], f"{ROWS[20]},9", *ROWS[21:]])
    assert refused(file) == 22
    put(file, ["time,travel", *(f"{row}, ,," for row in ROWS)])
    assert_read(read(file))


# ---- signs between cells, ends of lines, encodings ----------------------------------------------


@pytest.mark.parametrize("eol", ["\n", "\r\n", "\r", "\r\r\n"])
def test_any_end_of_line_will_do(file, eol):
    put(file, ["a", "time,travel", *ROWS, "", "\x1a"], eol=eol)
    assert_read(read(file), first=3)


@pytest.mark.parametrize("delimiter", [",", ";", "\t", "|", " "])
@pytest.mark.parametrize("head", [["time,travel", "[ms],[mm]"], ["time [ms],travel [mm]"]])
def test_any_delimiter_will_do(file, delimiter, head):
    lines = [line.replace(",", delimiter) for line in [*head, *ROWS]]
    if delimiter == " ":
        lines = [f"  {line} \t".replace(" 0", "    0") for line in lines]
    put(file, lines)
    assert_read(read(file, delimiter=delimiter))
    assert look_into(file).settings["delimiter"] == delimiter


def test_decimal_commas_between_commas_need_quotation_marks(file):
    quoted = [",".join(f'"{cell.replace(".", ",")}"' for cell in row.split(",")) for row in ROWS]
    put(file, ["time,travel", *quoted])
    assert_read(read(file, decimal=","))
    put(file, ["time,travel", *(row.replace(".", ",") for row in ROWS)])
    assert refused(file, decimal=",") == 2


@pytest.mark.parametrize(
    ("written", "settings"),
    [
        *(("utf-8", "utf-8"), ("utf-8-sig", "utf-8"), ("utf-16", "utf-16")),
        *(("utf-16-le", "utf-16"), ("utf-16-be", "utf-16-be"), ("gbk", "gb18030")),
        *(("cp1251", "cp1251"), ("cp1252", "cp1252")),
    ],
)
def test_encodings_are_read_and_proposed(file, written, settings):
    names = {"gbk": "行程", "cp1251": "Ход", "cp1252": "Weg ±"}
    name = names.get(written, "行程")
    put(file, [f"time,{name}", *ROWS], encoding=written)
    assert_read(read(file, travel_column=name, encoding=settings))
    assert look_into(file).names[1] == name


@pytest.mark.parametrize("zeros", [b"\0\0\0", None])
def test_zero_bytes_are_refused(file, zeros):
    """Of a crashed disk, or of another encoding: the line ends among them would be lost."""
    put(file, ["time,travel", *ROWS], encoding="utf-8" if zeros else "utf-16-le")
    content = file.read_bytes()
    if zeros:
        file.write_bytes(content[:100] + zeros + content[103:])
    assert refused(file) == (8 if zeros else 1)


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


ODD = [b"\0" * 1_000_000, b"1," * 500_000, b"time,travel\n" + b"1" * 1_000_000, b""]
ODD += [b"time," + b"travel [" * 10_000 + b"\n1,2", b"time;travel\n" * 100_000, b"(" * 99_000]
ODD += [b'"' * 1_000_000, (b" " * 999 + b"\n") * 1_000, b"\n" * 1_000_000]
ODD += [b"time,travel\n1," + b"1.," * 20_000 + b"x"]


@pytest.mark.parametrize("content", ODD, ids=range(len(ODD)))
@pytest.mark.parametrize("delimiter", [",", " "])
def test_odd_files_are_refused_at_once(file, content, delimiter):
    """A file of a MB takes less than a second; what searches backwards would take many minutes."""
    file.write_bytes(content)
    start = clock.process_time()
    refused(file, delimiter=delimiter)
    try:
        columns = read(file, delimiter=delimiter, travel_column=3, **UNTIMED)
    except RejectedCurveError:
        pass
    else:
        assert columns.travel.size == 1  # too few for what comes after
    assert clock.process_time() - start < 60.0


def test_times_that_stand_twice_are_refused():
    """Read by a rate, they would be twice as long."""
    with pytest.raises(UnusableError):
        even_times(np.repeat(TIME, 2), np.arange(80), complete(PLAIN))
