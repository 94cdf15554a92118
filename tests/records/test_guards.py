"""A file is opened only if it is one, and nothing waits; what is said of it can be printed."""

import os
import threading
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from breaker.common.zarr_store import open_store, save
from breaker.family.curve_file import write_curve
from breaker.records.curves import Grid, read_curves
from breaker.records.files import LARGEST, RejectedCurveError, read_bytes
from breaker.records.operations import Operation


def a_large_file(file: Path) -> None:
    with file.open("wb") as stream:
        stream.truncate(LARGEST + 1)


MADE = {
    "pipe": os.mkfifo,
    "folder": Path.mkdir,
    "device": lambda file: file.symlink_to("/dev/zero"),
    "loop": lambda file: file.symlink_to(file.name),
    "broken link": lambda file: file.symlink_to("nowhere.csv"),
    "large": a_large_file,
    "none": lambda file: None,
}


@pytest.mark.parametrize("made", MADE.values(), ids=MADE)
def test_what_is_no_file_is_rejected_and_nothing_waits(tmp_path, made):
    file, said = tmp_path / "op_1.csv", []
    made(file)

    def read():
        try:
            read_bytes(file)
        except RejectedCurveError as error:
            said.append(str(error))

    thread = threading.Thread(target=read, daemon=True)
    thread.start()
    thread.join(timeout=2.0)
    assert not thread.is_alive(), "waits for a pipe that nobody writes to"
    assert said[0].startswith(f"{file}: ")


# ---- what becomes of such files ------------------------------------------------------------------


def test_a_file_that_cannot_be_read_is_one_row_that_can_be_stored(tmp_path):
    """Whatever stands in a folder: a row with its reason, which a store and a table can hold."""
    time = np.arange(0.0, 100.0, 0.1)
    travel = 14.0 / (1.0 + np.exp(25.0 - time))
    made = {
        "pipe.csv": os.mkfifo,
        "empty.csv": lambda file: file.write_bytes(b""),
        "binary.csv": lambda file: file.write_bytes(bytes(range(256)) * 40),
        "a\n\t\x1b[2J.csv": Path.mkdir,
        "binary.xlsx": lambda file: file.write_bytes(b"PK\3\4" + bytes(100)),
        "pipe.cfg": os.mkfifo,
        "no\0name.csv": lambda file: None,
        "x" * 300 + ".csv": lambda file: None,
    }
    for name, make in made.items():
        make(tmp_path / name)
    odd = Path(os.fsdecode(os.fsencode(tmp_path) + b"/caf\xe9.csv"))
    fine = odd.with_name("fine" + odd.name)
    odd.write_bytes(b"?")
    write_curve(fine, time, travel, motion="closing", operation=1)
    files = [tmp_path / name for name in made] + [odd, fine]
    operations = [Operation(i, file) for i, file in enumerate(files, start=1)]

    curves = read_curves(operations, {}, Grid(np.arange(-2.0, 58.0, 0.4)), "closing")
    assert curves.accepted.values.tolist() == [False] * (len(files) - 1) + [True]
    save(curves, tmp_path / "curves.zarr")
    read = open_store(tmp_path / "curves.zarr").load()
    xr.testing.assert_identical(read.drop_attrs(), curves.drop_attrs())
    assert curves.file.values[-1].endswith(r"finecaf\udce9.csv")
    for text in (*curves.reason.values, *curves.file.values):
        assert text.isprintable()
        text.encode("utf-8")
