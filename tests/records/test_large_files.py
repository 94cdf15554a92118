"""Files larger than a record: they are answered or refused, in little memory."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from breaker.records.formats.registry import look_into

MOST = 400  # MiB, imports included; a small file takes a third of it

LOOK = """
import re, sys
from pathlib import Path
from breaker.records.settings import FORMAT
from breaker.records.formats.registry import look_into, read_columns
try:
    look_into(sys.argv[1])
    read_columns(sys.argv[1], FORMAT | {"time_column": None, "rate": 10, "travel_column": 1})
except ValueError as error:
    print(str(error)[:400])
# Not ru_maxrss, which begins with that of the process that started this one.
print(int(re.search(r"VmHWM:\\s+(\\d+) kB", Path("/proc/self/status").read_text())[1]) // 1024)
"""


@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="tells no peak of memory")
@pytest.mark.parametrize(
    "text",
    [
        (",".join(["1.5"] * 1_000_000) + "\n") * 8,
        (",".join(["1"] * 30) + "\n") * 300_000,
        "1\r" * 20_000_000,
        "1\n" * 1_300_000,
    ],
    ids=["columns", "cells", "returns", "samples"],
)
def test_what_no_recorder_writes_is_refused_in_little_memory(tmp_path, text):
    file = tmp_path / "hostile.csv"
    file.write_text(text, encoding="utf-8", newline="")
    refused, peak = subprocess.check_output([sys.executable, "-c", LOOK, file], text=True).split(
        "\n"
    )[:2]
    assert refused.startswith(str(file))
    assert int(peak) < MOST


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
