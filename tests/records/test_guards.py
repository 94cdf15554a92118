"""A file is opened only if it is one, and nothing waits; what is said of it can be printed."""

import os
import threading
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from breaker.common.zarr_store import open_store, save
from breaker.drive.simulation.export import write_curve
from breaker.records.curves import read_curves
from breaker.records.files import (
    LARGEST,
    RejectedCurveError,
    printable,
    read_bytes,
)
from breaker.records.grid import Grid
from breaker.records.operations import Operation


def a_pipe(file: Path) -> None:
    os.mkfifo(file)


def a_folder(file: Path) -> None:
    file.mkdir()


def a_device(file: Path) -> None:
    file.symlink_to("/dev/zero")


def a_loop(file: Path) -> None:
    file.symlink_to(file.name)


def a_broken_link(file: Path) -> None:
    file.symlink_to("nowhere.csv")


def a_large_file(file: Path) -> None:
    with file.open("wb") as stream:
        stream.truncate(LARGEST + 1)


@pytest.mark.parametrize(
    "made",
    [a_pipe, a_folder, a_device, a_loop, a_broken_link, a_large_file, lambda file: None],
)
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


@pytest.mark.parametrize("name", ["a\0b.csv", "x" * 300 + ".csv", "\ud800.csv"])
def test_a_name_that_no_file_has_is_rejected(tmp_path, name):
    with pytest.raises(RejectedCurveError) as told:
        read_bytes(tmp_path / name)
    assert str(told.value).isprintable()


@pytest.mark.parametrize(
    ("text", "shown"),
    [("närüß 1.csv", "närüß 1.csv"), ("a\nb\t\x1b[2J", r"a\nb\t\x1b[2J"), ("\udcff", r"\udcff")],
)
def test_what_cannot_be_printed_is_escaped(text, shown):
    assert printable(text) == shown
    assert str(RejectedCurveError(text, "why", line=3)) == f"{shown}, line 3: why"


# ---- what becomes of such files ------------------------------------------------------------------


def test_a_file_that_cannot_be_read_is_one_row_that_can_be_stored(tmp_path):
    """Whatever stands in a folder: a row with its reason, which a store and a table can hold."""
    time = np.arange(0.0, 100.0, 0.1)
    travel = 14.0 / (1.0 + np.exp(25.0 - time))
    made = {
        "pipe.csv": a_pipe,
        "empty.csv": lambda file: file.write_bytes(b""),
        "binary.csv": lambda file: file.write_bytes(bytes(range(256)) * 40),
        "a\n\t\x1b[2J.csv": a_folder,
        "pipe.xlsx": a_pipe,
        "binary.xlsx": lambda file: file.write_bytes(b"PK\3\4" + bytes(100)),
        "pipe.cfg": a_pipe,
        "pipe.nc": a_pipe,
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
    curves[["file", "reason"]].to_dataframe().to_csv(tmp_path / "curves.csv")
    rows = pd.read_csv(tmp_path / "curves.csv", keep_default_na=False)
    assert rows.reason.tolist() == curves.reason.values.tolist()
    assert rows.file.values[-1].endswith(r"finecaf\udce9.csv")
    for text in (*rows.reason, *rows.file):
        assert text.isprintable()
        text.encode("utf-8")
