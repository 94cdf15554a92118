"""One record on each line: each is read with its own number, date and interval, or refused."""

import numpy as np
import pytest

from breaker.common.randomness import generator
from breaker.records.files import RejectedCurveError
from breaker.records.folder import each_line
from breaker.records.formats.detection import look_into, read_columns, records_in
from breaker.records.operations import Operation
from breaker.records.settings import complete

COUNT = 120
VALUES = np.rint(1e2 * generator(1, "records on lines").uniform(10.0, 99.0, (4, COUNT)))
COUNTS = complete(
    {"time_unit": "ms", "travel_column": "Values", "travel_unit": "counts", "ratio": 0.1}
)


def named(k, values):
    """A record; intervals differ from line to line."""
    day = f"2024-11-{20 + k} 15:11:07"
    return f"ID:{k + 5};Time:{day};Interval (ms):0.{k + 1};Values:{values}"


def written(file, sign=","):
    rows = [sign.join(f"{value:.0f}" for value in row) for row in VALUES]
    lines = [named(k, row) for k, row in enumerate(rows)]
    file.write_text("\n".join([*lines, ""]), encoding="utf-8")
    return file


@pytest.mark.parametrize("sign", [",", " ", ";", "\t"])
def test_each_line_is_an_operation(tmp_path, sign):
    file = written(tmp_path / "bench.txt", sign)
    operations = each_line([Operation(1, file)])
    dates = [(item.number, item.date) for item in operations]
    assert dates == [(5 + k, f"2024-11-{20 + k}T15:11:07") for k in range(4)]
    sheet = look_into(file)
    settings = {**COUNTS, **sheet.settings, "travel_column": sheet.names[-1]}
    for k, (operation, values) in enumerate(zip(operations, VALUES, strict=True)):
        columns = read_columns(file, settings, "", operation.line)
        np.testing.assert_array_equal(columns.travel, values)
        np.testing.assert_allclose(columns.time, 0.1 * (k + 1) * np.arange(COUNT))
        assert set(columns.lines) == {operation.line}
        assert columns.remarks == ()
    assert len(read_columns(file, settings).remarks) == 1  # the first of several


@pytest.mark.parametrize("bad", ["12x4", "1_000", "1e99", ""])
def test_a_bad_value_refuses_its_line_alone(tmp_path, bad):
    file = written(tmp_path / "bench.txt")
    lines = file.read_text(encoding="utf-8").splitlines()
    cells = lines[1].split(",")
    lines[1] = ",".join([*cells[:70], bad, *cells[71:]])
    file.write_text("\n".join(lines), encoding="utf-8")
    if bad:
        with pytest.raises(RejectedCurveError) as refused:
            read_columns(file, COUNTS, "", 2)
        assert refused.value.line == 2
    else:
        missing = np.isnan(read_columns(file, COUNTS, "", 2).travel)
        assert np.flatnonzero(missing).tolist() == [70]
    np.testing.assert_array_equal(read_columns(file, COUNTS, "", 3).travel, VALUES[2])


def test_values_that_nothing_names_and_other_lines_are_refused(tmp_path):
    file = tmp_path / "bench.txt"
    file.write_text(named(1, "").replace("Values:", ",".join(["1"] * COUNT)), encoding="utf-8")
    with pytest.raises(RejectedCurveError):
        read_columns(file, COUNTS)
    written(file)
    for settings, line in (({**COUNTS, "delimiter": ";"}, 1), (COUNTS, 9)):
        with pytest.raises(RejectedCurveError):
            read_columns(file, settings, "", line)


def test_thousands_of_records_are_listed_and_none_of_a_wide_table(tmp_path):
    """Of a table with a sample on each line."""
    file = tmp_path / "bench.txt"
    values = ",".join(f"{value:.0f}" for value in VALUES[0])
    file.write_text("\n".join(named(k % 9, values) for k in range(2000)), encoding="utf-8")
    assert len(records_in(file)) == 2000
    head = ",".join(["time", "date", *(f"travel {k}" for k in range(80))])
    rows = [",".join([f"{t / 10}", "2024-11-20", *["1.5"] * 80]) for t in range(40)]
    file.write_text("\n".join([head, *rows]), encoding="utf-8")
    assert records_in(file) == []
