"""Measure what commands take for the largest files that are read: 64 MiB of each kind.

Writes each file, runs ``inspect``, ``infer`` and ``manifest`` on it in processes of their own, and
prints the seconds and the memory of each, and what it said first. Processor time counts, since
another job of the machine may halt a process; a hang ends after two minutes. Ends with 1 if a call
takes more than 10 s or 1 GB. Takes ten minutes.

    python -m studies.large_files [KIND ...] [--keep FOLDER]
"""

import argparse
import subprocess
import sys
import tempfile
import zipfile
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np

from breaker.reading.files.guards import LARGEST

SECONDS, BYTES = 10.0, 10**9
"""That a call may take."""
LONGEST = 1_190_000
"""Samples of the longest record that is read."""
_MARK = "took: "
_RUN = f"""
import re, resource, signal, sys
from pathlib import Path
signal.alarm(120)
from breaker.cli import main
main(sys.argv[1:])
used = [resource.getrusage(of) for of in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
# Not ru_maxrss, which begins with that of the process that started this one.
peak = 1024 * int(re.search(r"VmHWM:\\s+(\\d+) kB", Path("/proc/self/status").read_text())[1])
print("{_MARK}", sum(each.ru_utime + each.ru_stime for each in used), peak, file=sys.stderr)
"""
_CALLS = {
    "inspect": ["inspect", "{0}"],
    "infer": ["infer", "{0}"],
    "by number": ["infer", "{0}", "--config", "{1}/own.yaml"],
    "manifest": ["manifest", "{1}"],
}
_NUMBER = "endurance: {format: {time_column: null, rate: 100, travel_column: 1}}\n"


def _motion(samples: int) -> np.ndarray:
    """A closing of 16 mm in the midst of a long record, at 100 kHz."""
    time = (np.arange(samples) - samples / 2) / 100.0
    noise = 0.05 * np.random.default_rng(1).standard_normal(samples)
    return 8.0 * (1.0 + np.tanh(time / 4.0)) + noise


def _rows(samples: int, columns: int = 1, form: str = "{:.5f},{}\n") -> bytes:
    """A text of times, s, and of travels that are alike."""
    motion = (f"{each:.3f}" for each in _motion(samples))
    names = ",".join(["travel", *(f"travel {k}" for k in range(2, columns + 1))])
    rows = (form.format(i / 1e5, ",".join([each] * columns)) for i, each in enumerate(motion))
    return "".join([f"time,{names}\n", *rows]).encode()


def _filled(part: bytes) -> bytes:
    return part * (LARGEST // len(part))


def _workbook(file: Path) -> None:
    import openpyxl

    book = openpyxl.Workbook(write_only=True)
    sheet = book.create_sheet()
    sheet.append(["time", "travel"])
    for i, each in enumerate(_motion(300_000)):
        sheet.append([i / 1e5, float(each)])
    book.save(file)


def _zipped(file: Path) -> None:
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as book:
        book.writestr("xl/worksheets/sheet1.xml", b"<c/>" * (LARGEST // 4 - 100))


def _comtrade(file: Path, kind: str, samples: int, data: bytes) -> None:
    channel = "1,travel,,,mm,0.001,0,0,-32767,32767,1,1,P"
    when = "01/01/2024,00:00:00.000000"
    rate = f"50\n1\n100000,{samples}\n{when}\n{when}\n{kind}\n1\n"
    file.write_text(f"a,b,1999\n1,1A,0D\n{channel}\n{rate}", encoding="utf-8")
    file.with_suffix(".dat").write_bytes(data)


def _comtrade_binary(file: Path, samples: int) -> None:
    rows = np.zeros(samples, [("n", "<u4"), ("at", "<u4"), ("travel", "<i2")])
    rows["n"], rows["at"] = np.arange(1, samples + 1), 10 * np.arange(samples)
    rows["travel"] = 1e3 * _motion(samples)
    _comtrade(file, "BINARY", samples, rows.tobytes())


def _comtrade_text(file: Path, samples: int) -> None:
    rows = (f"{i + 1},{10 * i},{1e3 * each:.0f}\n" for i, each in enumerate(_motion(samples)))
    _comtrade(file, "ASCII", samples, "".join(rows).encode())


def _labelled(file: Path, samples: int, engine: str) -> None:
    import xarray as xr

    travel = _motion(samples)
    data = xr.Dataset({"travel": ("time", travel)}, {"time": np.arange(travel.size) / 1e5})
    data.to_netcdf(file, engine=engine)


FILES: dict[str, tuple[str, Callable[[], bytes] | Callable[[Path], None]]] = {
    "longest record": (".csv", lambda: _rows(LONGEST)),
    "many columns": (".csv", lambda: _rows(310_000, 24)),
    "quoted cells": (".csv", lambda: _rows(LONGEST, 1, '"{:.5f}","{}"\n')),
    "a sign a line": (".csv", lambda: _filled(b"1\n")),
    "lines of samples": (".csv", lambda: _rows(3_600_000)),
    "blank lines": (".txt", lambda: _filled(b"\r\n")),
    "old ends of lines": (".txt", lambda: _filled(b"1\r")),
    "words": (".csv", lambda: _filled(b"once upon a time, there was\n")),
    "one line": (".csv", lambda: _filled(b"1.5,")),
    "bytes by chance": (".csv", lambda: np.random.default_rng(1).bytes(LARGEST - 1)),
    "other letters": (".csv", lambda: _filled("Föder 1,5;мм\n".encode("cp1251", "replace"))),
    "two bytes a sign": (".csv", lambda: _rows(LONGEST).decode().encode("utf-16")),
    "workbook": (".xlsx", _workbook),
    "zipped": (".xlsx", _zipped),
    "COMTRADE, longest": (".cfg", partial(_comtrade_binary, samples=LONGEST)),
    "COMTRADE, binary": (".cfg", partial(_comtrade_binary, samples=LARGEST // 10)),
    "COMTRADE, text": (".cfg", partial(_comtrade_text, samples=720_000)),
    "COMTRADE, long text": (".cfg", partial(_comtrade_text, samples=2_500_000)),
    "NetCDF 3, longest": (".nc", partial(_labelled, samples=LONGEST, engine="scipy")),
    "NetCDF 3": (".nc", partial(_labelled, samples=LARGEST // 16 - 100, engine="scipy")),
    "NetCDF 4, longest": (".nc", partial(_labelled, samples=LONGEST, engine="h5netcdf")),
    "NetCDF 4": (".nc", partial(_labelled, samples=LARGEST // 16 - 2000, engine="h5netcdf")),
}
"""Kinds of files: their ending, and their content or what writes them."""


def write(kind: str, folder: Path) -> Path:
    """Write a file of a kind, and return it."""
    ending, make = FILES[kind]
    file = folder / f"record{ending}"
    if ending in (".csv", ".txt"):
        file.write_bytes(make())
    else:
        make(file)
    return file


def measure(words: list[str]) -> tuple[float, float, str]:
    """Run a command; return its processor time, s, its memory, bytes, and what it says.

    Both are infinite of a command that hangs or is killed.
    """
    done = subprocess.run([sys.executable, "-c", _RUN, *words], capture_output=True, text=True)
    said, _, used = f"{done.stdout} {done.stderr}".rpartition(_MARK)
    seconds, memory = map(float, used.split() or ("inf", "inf"))
    return seconds, memory, " ".join(said.split())


def main() -> int:
    """Print a row for each kind and command; the status is 1 if one takes too much."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("kinds", nargs="*", default=list(FILES), metavar="KIND")
    worst = 0
    for kind in parser.parse_args().kinds:
        with tempfile.TemporaryDirectory() as folder:
            file = write(kind, Path(folder))
            Path(folder, "own.yaml").write_text(_NUMBER, encoding="utf-8")
            for name, words in _CALLS.items():
                seconds, memory, text = measure([each.format(file, folder) for each in words])
                over = seconds > SECONDS or memory > BYTES
                worst |= over
                row = f"{kind:20s}{name:10s}{seconds:7.1f} s {memory / 1e9:6.2f} GB"
                print(row, "over " if over else "     ", text.replace(folder, "")[:110], flush=True)
    return int(worst)


if __name__ == "__main__":
    sys.exit(main())
