"""The text of curve files: what is read right, and what is refused with line and remedy."""

import time as clock

import numpy as np
import pytest

from breaker.common.randomness import generator
from breaker.drive.simulation.dialects import DIALECTS
from breaker.records.axes import even_times
from breaker.records.cells import strict_numbers, why_none
from breaker.records.files import RejectedCurveError
from breaker.records.formats.registry import look_into, read_columns
from breaker.records.rejections import UnusableError
from breaker.records.settings import TO_MS, complete
from breaker.records.words import split_unit, unit_of
from tests.records.refused import told

TIME = 0.1 * np.arange(40)
TRAVEL = np.round(0.05 * np.arange(40) ** 1.2, 3)
ROWS = [f"{t:.4f},{x:.3f}" for t, x in zip(TIME, TRAVEL, strict=True)]
PLAIN = {"time_unit": "ms"}


@pytest.fixture
def file(tmp_path):
    return tmp_path / "record.csv"


def put(file, lines, *, eol="\n", encoding="utf-8"):
    file.write_bytes(eol.join([*lines, ""]).encode(encoding))


def damaged(at, row):
    """The rows, one of them another."""
    return [*ROWS[:at], row, *ROWS[at + 1 :]]


def read(file, channel="", **settings):
    return read_columns(file, complete({**PLAIN, **settings}), channel)


def assert_read(columns, *, lines=None, remarks=()):
    if columns.time is not None:
        np.testing.assert_allclose(columns.time, TIME, atol=1e-9)
    np.testing.assert_array_equal(columns.travel, TRAVEL)
    assert columns.lines.size == TIME.size
    assert columns.remarks == remarks
    if lines is not None:
        assert columns.lines[0] == lines


def test_a_rate_is_enough_where_there_is_no_column_of_the_time(file):
    put(file, ["travel", *(f"{x:.3f}" for x in TRAVEL)])
    columns = read(file, rate=10.0)
    assert columns.time is None
    assert_read(
        columns, remarks=("there is no column 'time': times are those of the rate, 10 kHz",)
    )
    assert "no line has 'time'" in rejection(file)
    put(file, ["time,travel", *ROWS])
    assert_read(read(file, rate=10.0))


def rejection(file, channel="", **settings):
    return told(file, lambda: read(file, channel, **settings))


# ---- dialects ---------------------------------------------------------------------------------


@pytest.mark.parametrize("name", DIALECTS)
def test_every_dialect_is_read_back_to_its_printed_digits(tmp_path, name):
    """The preamble differs from file to file; a stroke of 14 mm in noise, 10 kHz."""
    dialect, rng = DIALECTS[name], generator(1, "test dialect", name)
    settings, time = complete(dialect.settings), 0.1 * np.arange(300)
    for operation in range(1, 11):
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
    "none": ["time,travel"],
    "units": ["time,travel", "ms,mm"],
    "in brackets": ["time,travel", "[ms],(mm)"],
    "other spellings": ["time,travel", "msec,millimeter"],
    "in the names": ["Time (ms),Travel [mm]"],
    "behind a bar": ["time/ms,travel/mm"],
    "capitals": ["TIME,TRAVEL", "MSEC,MM"],
    "a remark": ["# time,travel", "# nothing", "ms,mm"],
    "long": [*(f"channel {i},{i},{i}" for i in range(45)), "time,travel"],
    "names twice": ["Title,time,travel", "time,travel"],
    "quoted": ['"time","travel"', '"ms","mm"'],
    "an odd quotation mark": ['stroke 5" at most,', '"operator', "time,travel"],
    "blank lines": ["", "a", "", "time,travel", "", "ms,mm", ""],
    "other columns without unit": ["time,travel,x", "ms,mm,1"],
    "trailing": ["time,travel,,", "ms,mm,,"],
}


@pytest.mark.parametrize("name", HEADS)
def test_the_head_is_found(file, name):
    put(file, [*HEADS[name], *ROWS])
    assert_read(read(file), lines=len(HEADS[name]) + 1)


MERGED = {
    "repeated": ["Time,Travel (in),Travel (in)", "ms,L1,L2"],
    "blank": ["Time,Travel (in),", "ms,L1,L2"],
    "with units below": ["Time,Travel,", "t,L1,L2", "ms,in,in"],
}


@pytest.mark.parametrize("name", MERGED)
def test_both_of_two_lines_of_names_count(file, name):
    put(file, [*MERGED[name], *(f"{row},7" for row in ROWS)])
    sheet = look_into(file)
    assert sheet.units == ["ms", "inch", "inch"]
    time = str(sheet.column(0))
    assert [sheet.column(1), sheet.column(2)] == ["Travel L1", "Travel L2"]
    assert_read(read(file, "Travel L1", time_column=time, travel_unit="inch"))
    assert rejection(file, "Travel L1", time_column=time)  # in mm
    assert rejection(file, "L1", time_column=time, travel_unit="inch")


@pytest.mark.parametrize("words", ["OFF ON", "False True", "open closed", "AUS EIN"])
def test_words_for_two_states_are_0_and_1(file, words):
    off, on = words.split()
    states = np.arange(40) > 20
    rows = [f"{row},{on if state else off}" for row, state in zip(ROWS, states, strict=True)]
    put(file, ["time,travel,contact", *rows])
    np.testing.assert_array_equal(look_into(file).columns[2], states)
    np.testing.assert_array_equal(read(file, contact_column="contact").beside["contact"], states)
    put(file, ["time,travel,contact", *rows[:-1], f"{ROWS[-1]},?"])
    assert rejection(file, contact_column="contact").startswith(", line ")


def test_names_with_numbers_are_names_and_a_unit_may_stand_alone(file):
    rows = [f"{row},0,1" for row in ROWS]
    put(file, ["in ms,Travel (in),52a,52b", *rows])
    sheet = look_into(file)
    assert sheet.units == ["ms", "inch", None, None]
    assert [sheet.column(place) for place in (2, 3)] == ["52a", "52b"]


def test_a_text_of_labview_is_read_as_proposed(tmp_path):
    file = tmp_path / "a.lvm"
    head = ["LabVIEW Measurement\t", "Separator\tTab", "***End_of_Header***\t", "\t"]
    head += ["Channels\t1\t\t", "Y_Unit_Label\tmm\t", "X_Dimension\tTime\t"]
    head += ["***End_of_Header***\t\t", "X_Value\ttravel\tComment"]
    put(file, [*head, *(row.replace(",", "\t") for row in ROWS)], eol="\r\n")
    sheet = look_into(file)
    assert sheet.units[:2] == ["s", "mm"]
    settings = {**sheet.settings, "time_column": sheet.column(0), "time_unit": "s"}
    np.testing.assert_array_equal(read(file, **settings).travel, TRAVEL)


def test_an_exact_name_goes_before_a_near_one(file):
    rows = [f"{row},7" for row in ROWS]
    put(file, ["time,travel,Travel [mm]", *rows])
    assert_read(read(file))
    put(file, ["time,TRAVEL [mm],travel (phase 1)", *rows])
    assert_read(read(file))


@pytest.mark.parametrize(
    ("head", "reason"),
    [
        ("ms,cm", "the unit of 'travel' is 'cm', but endurance.format.travel_unit is 'mm'"),
        ("sec,mm", "the unit of 'time' is 'sec', but endurance.format.time_unit is 'ms'"),
        ("ms,°", "the unit of 'travel' is '°', but endurance.format.travel_unit is 'mm'"),
        ("ms,m/s", "the unit of 'travel' is 'm/s', but endurance.format.travel_unit is 'mm'"),
    ],
)
def test_a_contradicting_unit_is_refused(file, head, reason):
    put(file, ["time,travel", head, *ROWS])
    assert rejection(file).startswith(f", line 2: {reason}")
    put(file, ["time ({}),travel [{}]".format(*head.split(",")), *ROWS])
    assert rejection(file).endswith(reason.partition("but ")[2])


def test_an_unknown_unit_is_remarked_on(file):
    put(file, ["time,travel", "ms,span", *ROWS])
    remark = "the unit of 'travel' is 'span', which is not known; endurance.format.travel_unit is "
    assert_read(read(file), remarks=(f"{remark}'mm'",))


@pytest.mark.parametrize(
    ("unit", "spellings"),
    {
        "s": ["s", "sec", "Sec.", "seconds", "[s]", "(S E C)".replace(" ", "")],
        "ms": ["ms", "[ms]", "(ms)", "msec", "millisec", "MS", "milliseconds"],
        "us": ["us", "µs", "μs", "usec", "microseconds"],
        "deg": ["deg", "°", "degree", "[Deg]", "degrees", "Grad", "(grados)", "[gradi]", "degrés"],
        "mm": ["mm", "MM", "[mm]", "millimetre"],
        "inch": ["in", "inch", '"', "inches", "in.", "(in)", "pulgadas", "Zoll", "дюйм"],
        "counts": ["counts", "digits", "LSB"],
        "V": ["V", "volts"],
        None: ["", "S", "M", "gone", "phase A", "1"],
    }.items(),
)
def test_units_are_known_in_any_spelling(unit, spellings):
    assert [unit_of(text) for text in spellings] == [unit] * len(spellings)


def test_letters_of_phases_are_no_units_of_a_name():
    for name in ("Travel (A)", "Travel [V]", "S/W", "travel_in", "travel (S)", "t (Zeit)"):
        assert split_unit(name) == (name, None)


def test_a_unit_behind_a_blank_is_that_of_a_time_or_a_travel():
    names = {"weg cm": "cm", "Travel 1 mm": "mm", "Zeit s": "s", "t msec": "ms", "Hub zoll": "inch"}
    assert {name: split_unit(name)[1] for name in names} == names
    for name in ("Coil mA", "Contact s", "Travel min", "travel in", "Travel S", "stroke phase"):
        assert split_unit(name) == (name, None)


def test_doubled_names_are_refused_and_read_by_number(file):
    rows = [f"{row},9,{row.split(',')[1]}" for row in ROWS]
    put(file, ["time,travel,current,travel", *rows])
    message = rejection(file)
    assert message.startswith(", line 1: more than one column 'travel'; give its number, 2 or 4")
    assert_read(read(file, travel_column=4))
    assert_read(read(file, channel="4"))


def test_files_without_names_are_read_by_numbers(file):
    preamble = ["made by 7", "rate,10000,1", "10,20"]
    put(file, [*preamble, *(f"{i},{row}" for i, row in enumerate(ROWS))])
    assert_read(read(file, time_column=2, travel_column=3), lines=4)
    put(file, ROWS)
    assert_read(read(file, time_column=1, travel_column=2), lines=1)
    assert_read(read(file, time_column=1, travel_column=2), lines=1)
    assert "has no numbers in column 1 and 3" in rejection(file, time_column=1, travel_column=3)
    put(file, ["t;cm", *ROWS])
    assert_read(read(file, time_column=1, travel_column=2), lines=2)
    put(file, ["a,b", "ms,cm", *ROWS])
    message = rejection(file, time_column=1, travel_column=2)
    assert message.startswith(", line 2: the unit of column 2 is 'cm'")


# ---- cells ------------------------------------------------------------------------------------

SEPARATED = ["1_000", "1'000.5", "1 000", "1.2.3"]
NO_NUMBERS = ["١٢٣", "１２", "−1.5", "0x10", "inf", "-Infinity", "nan1", "1e246", "1e999", "1.5e"]
NO_NUMBERS += ["12345678901234567890123", "15:13:07", "OVERFLOW", "1.5 mm", *SEPARATED]


@pytest.mark.parametrize("cell", NO_NUMBERS)
@pytest.mark.parametrize("decimal", [".", ","])
def test_what_is_no_plain_number_is_refused_with_its_line(file, cell, decimal):
    rows = ["time,travel", *damaged(20, f"2.0000,{cell}")]
    swap = str.maketrans({",": ";", ".": decimal})
    put(file, [row.translate(swap) for row in rows])
    message = rejection(file, delimiter=";", decimal=decimal)
    assert message.startswith(", line 22: 'travel' is ")
    assert ("thousands" in message) == (cell in SEPARATED)


def test_thousands_are_not_read_as_decimals():
    for cell, decimal in (("1,234", "."), ("1.234", ","), ("1,234.5", "."), ("1.234,5", ",")):
        values, wrong = strict_numbers(["1", cell], decimal)
        assert values[0] == 1.0
        assert wrong == [1]
        assert "endurance.format.decimal" in why_none(cell)


@pytest.mark.parametrize("decimal", [".", ","])
def test_numbers_are_those_of_python(decimal):
    """Quick and careful reading agree to the last digit."""
    rng = generator(1, "test numbers")
    numbers = [*rng.standard_normal(200), *10.0 ** rng.uniform(-9, 8, 200), 0.0, 1e-400, -0.0]
    shown = [f(float(x)) for x in numbers for f in (repr, "{:.3e}".format, "{:+.4f}".format)]
    cells = [text.replace(".", decimal) for text in [*shown, "5.", ".5", " 7 "]]
    expected = [float(text) for text in [*shown, "5.", ".5", "7"]]
    quick, none = strict_numbers(cells, decimal)
    careful, wrong = strict_numbers([*cells, "", "x"], decimal)
    assert none == []
    assert wrong == [len(cells) + 1]
    np.testing.assert_array_equal(quick, expected)
    np.testing.assert_array_equal(careful[:-2], expected)


@pytest.mark.parametrize("cell", ["", "NaN", "#N/A", "-", "---", "  "])
def test_missing_samples_are_nan(file, cell):
    put(file, ["time,travel", *damaged(20, f"2.0000,{cell}"), "4.0", "4.1,2"])
    columns = read(file)
    assert np.flatnonzero(np.isnan(columns.travel)).tolist() == [20, 40]
    np.testing.assert_allclose(columns.time, [*TIME, 4.0, 4.1])


def test_blanks_at_the_end_are_the_end_of_a_channel(file):
    put(file, ["time,travel,other", *(f"{row},1" for row in ROWS), "4.0,,1", "4.1,,1", ",,", ""])
    assert_read(read(file))
    rows = [row.split(",")[1] for row in ROWS]
    put(file, ["travel,other", *(f"{x},1" for x in rows), ",1", ",1"])
    assert_read(read(file, time_column=None, rate=10))
    put(file, ["travel,other", *(",1" for _ in rows)])
    assert "'travel' has no samples" in rejection(file, time_column=None, rate=10)


@pytest.mark.parametrize("line", ["", "# stopped here", ";;", "Page 2", '""'])
def test_a_gap_without_a_time_column_is_refused(file, line):
    """With times it is a gap in time; without, all that follows would be early by a sample."""
    rows = [f"0.5;{row.split(',')[1]};7" for row in ROWS]
    settings = {"delimiter": ";", "time_column": None, "rate": 10}
    put(file, ["current;travel;other", *rows, "", line, "1;"])
    assert_read(read(file, **settings))
    put(file, ["current;travel;other", *rows[:20], line, *rows[20:]])
    message = rejection(file, **settings)
    assert message.startswith(", line 21: stands before a line that is blank, a remark or too sh")
    put(file, ["time;travel", *(row.replace(",", ";") for row in ROWS)])
    lines = file.read_text(encoding="utf-8").splitlines()
    if line != "Page 2":
        put(file, [*lines[:20], line, *lines[20:]])
        assert_read(read(file, delimiter=";"))


def test_a_line_with_too_many_cells_is_refused(file):
    put(file, ["time,travel", *damaged(20, f"{ROWS[20]},9")])
    message = rejection(file)
    assert message.startswith(", line 22: 3 cells where there are 2 columns; see")
    put(file, ["time,travel", *(f"{row}, ,," for row in ROWS)])
    assert_read(read(file))


# ---- signs between cells, ends of lines, encodings ----------------------------------------------


@pytest.mark.parametrize("eol", ["\n", "\r\n", "\r", "\r\r\n"])
def test_any_end_of_line_will_do(file, eol):
    put(file, ["a", "time,travel", *ROWS, "", ""], eol=eol)
    assert_read(read(file), lines=3)
    file.write_bytes(file.read_bytes() + b"\x1a")
    assert_read(read(file))


@pytest.mark.parametrize("delimiter", [",", ";", "\t", "|", " "])
@pytest.mark.parametrize("head", [["time,travel", "[ms],[mm]"], ["time [ms],travel [mm]"]])
def test_any_delimiter_will_do(file, delimiter, head):
    lines = [line.replace(",", delimiter) for line in [*head, *ROWS]]
    if delimiter == " ":
        lines = [f"  {line.replace(' ', '    ')} \t" for line in lines]
        lines[: len(head)] = [line.strip() for line in lines[: len(head)]]
    put(file, lines)
    assert_read(read(file, delimiter=delimiter))


def test_decimal_commas_between_commas_need_quotation_marks(file):
    quoted = [",".join(f'"{cell.replace(".", ",")}"' for cell in row.split(",")) for row in ROWS]
    put(file, ["time,travel", *quoted])
    assert_read(read(file, decimal=","))
    put(file, ["time,travel", *(row.replace(".", ",") for row in ROWS)])
    assert "4 cells where there are 2 columns" in rejection(file, decimal=",")


@pytest.mark.parametrize(
    ("written", "settings"),
    [
        ("utf-8", "utf-8"),
        ("utf-8-sig", "utf-8"),
        ("utf-8-sig", "utf-8-sig"),
        ("utf-16", "utf-16"),
        ("utf-16-le", "utf-16"),
        ("utf-16-be", "utf-16"),
        ("utf-16-be", "utf-16-be"),
        ("latin-1", "latin-1"),
        ("cp1252", "cp1252"),
        ("gbk", "gbk"),
    ],
)
def test_encodings_and_byte_order_marks(file, written, settings):
    name = "行程" if written == "gbk" or written.startswith("utf") else "Weg ±"
    put(file, [f"time,{name}", *ROWS], encoding=written)
    assert_read(read(file, travel_column=name, encoding=settings))


def test_zero_bytes_are_told(file):
    """Of a crashed disk, or of another encoding: the line ends among them would be lost."""
    put(file, ["time,travel", *ROWS])
    content = bytearray(file.read_bytes())
    content[100:103] = b"\0\0\0"
    file.write_bytes(content)
    assert "has zero bytes: it is damaged" in rejection(file)
    put(file, ["time,travel", *ROWS], encoding="utf-16-le")
    message = rejection(file)
    assert message.startswith(", line 1: has zero bytes")
    assert "endurance.format.encoding" in message


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
    assert rejection(file).startswith(", line 100002: 'travel' is '?'")


@pytest.mark.parametrize(
    "content",
    [
        b"\0" * 1_000_000,
        b"," * 1_000_000,
        b"1," * 500_000,
        b"time,travel\n" + b"1" * 1_000_000,
        b"time,travel\n" + b"1,1," * 20_000 + b"\n1,x",
        b"time," + b"travel [" * 10_000 + b"\n1,2",
        b"time,travel\n1," + b"1," * 40_000,
        b"time;travel\n" * 100_000,
        b'"' * 1_000_000,
        (b" " * 999 + b"\n") * 1_000,
        b"\n" * 1_000_000,
        b"(" * 99_000,
        b"time,travel\n1," + b"1.," * 30_000 + b"x",
        b"",
    ],
    ids=range(14),
)
@pytest.mark.parametrize("delimiter", [",", " "])
def test_odd_files_are_refused_at_once(file, content, delimiter):
    """A file of a MB takes less than a second; what searches backwards would take many minutes."""
    file.write_bytes(content)
    start = clock.process_time()
    assert len(rejection(file, delimiter=delimiter)) < 2_000
    try:
        columns = read(file, delimiter=delimiter, time_column=None, rate=10, travel_column=3)
    except RejectedCurveError:
        pass
    else:
        assert columns.travel.size == 1  # too few for what comes after
    assert clock.process_time() - start < 60.0


def test_times_that_stand_twice_are_refused_without_a_rate_in_their_stead():
    """Read by a rate, they would be twice as long."""
    with pytest.raises(UnusableError) as refused:
        even_times(np.repeat(TIME, 2), np.arange(80), complete(PLAIN))
    assert "null" not in str(refused.value)
