"""A file is opened only if it is one, and nothing waits; its reason can be printed and stored."""

import os
import threading
from pathlib import Path

import numpy as np
import xarray as xr

from breaker.common.zarr_store import open_store, save
from breaker.family.curve_file import write_curve
from breaker.records.curves import Grid, read_curves
from breaker.records.files import LARGEST
from breaker.records.operations import Operation

MADE = {
    "pipe.csv": os.mkfifo,
    "pipe.cfg": os.mkfifo,
    "folder.csv": Path.mkdir,
    "device.csv": lambda file: file.symlink_to("/dev/zero"),
    "loop.csv": lambda file: file.symlink_to(file.name),
    "broken link.csv": lambda file: file.symlink_to("nowhere.csv"),
    "large.csv": lambda file: [file.touch(), os.truncate(file, LARGEST + 1)],
    "none.csv": lambda file: None,
    "empty.csv": Path.touch,
    "binary.csv": lambda file: file.write_bytes(bytes(range(256)) * 40),
    "binary.xlsx": lambda file: file.write_bytes(b"PK\3\4" + bytes(100)),
    "x" * 300 + ".csv": lambda file: None,
    "no\0name.csv": lambda file: None,
    "a\n\t\x1b[2J.csv": Path.mkdir,
}


def test_whatever_cannot_be_read_is_one_row_that_can_be_stored(tmp_path):
    """In a thread, for a reader may wait for a pipe that nobody writes to."""
    for name, make in MADE.items():
        make(tmp_path / name)
    time = np.arange(0.0, 100.0, 0.1)
    odd = Path(os.fsdecode(os.fsencode(tmp_path) + b"/caf\xe9.csv"))
    fine = odd.with_name("fine" + odd.name)
    odd.write_bytes(b"?")
    write_curve(fine, time, 14.0 / (1.0 + np.exp(25.0 - time)), motion="closing", operation=1)
    files, result = [*(tmp_path / name for name in MADE), odd, fine], []
    operations = [Operation(i, file) for i, file in enumerate(files, start=1)]
    grid = Grid(np.arange(-2.0, 58.0, 0.4))
    thread = threading.Thread(
        target=lambda: result.append(read_curves(operations, {}, grid, "closing")), daemon=True
    )
    thread.start()
    thread.join(timeout=60.0)
    (curves,) = result
    assert curves.accepted.values.tolist() == [False] * (len(files) - 1) + [True]
    for file, reason in zip(files, curves.reason.values[:-4], strict=False):
        assert reason.startswith(str(file))
    save(curves, tmp_path / "curves.zarr")
    read = open_store(tmp_path / "curves.zarr").load()
    xr.testing.assert_identical(read.drop_attrs(), curves.drop_attrs())
    assert curves.file.values[-1].endswith(r"finecaf\udce9.csv")
    for text in (*curves.reason.values, *curves.file.values):
        assert text.isprintable()
        text.encode("utf-8")
