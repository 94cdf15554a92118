"""Random command lines in a folder full of records: none may change what is there.

``python -m tests.cli.command_lines --lines 1000`` is part of ``make test-faults``; a few dozen of
the same lines are a unit test.
"""

import argparse
import contextlib
import hashlib
import io
import os
import re
import shutil
import sys
import tempfile
from collections.abc import Iterable
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import NamedTuple

import pandas as pd
from tqdm import tqdm

from breaker.cli import main
from breaker.common.randomness import generator
from breaker.configuration.loading import read
from breaker.mechanism.prior import Prior
from breaker.shipped import DEFAULTS, model_file
from tests.cli.conftest import written

BATCH = 25  # lines in one folder
RECORDS = ("a.csv", "b 2.csv", "both.csv", "pair.cfg", "drive/closing/op_1.csv")
FOLDERS = ("drive", "listed", "link", ".")
NEW = (
    "new.csv",
    "new.html",
    "new.yaml",
    "new.png",
    "new.zarr",
    "made/new.csv",
    "drive/closing/op_3.csv",
)
PLACES = (
    *RECORDS,
    *("link.csv", "hard.csv", "link.png", "pair.dat", "listed/operations.csv", "few.yaml"),
    *("config/config.yaml", "own.safetensors", "record.zarr", "record.zarr/.zattrs", "drive"),
    *("link/closing/op_2.csv", "drive/../a.csv", "./open.csv", "record.zarr/x.csv"),
    *("", "/dev/null"),
    *NEW,
)

_HALF = re.compile(r"(^|/)[.][0-9a-f]{8}")  # names of what is being written


class Line(NamedTuple):
    """A command line, and what became of it.

    Attributes:
        number: Of the line, which with the seed says what it is.
        words: Of it.
        status: Exit status; -1 where it ended in an error that nobody caught.
        changed: Inputs that it changed, and what it left half written.
    """

    number: int
    words: tuple[str, ...]
    status: int
    changed: tuple[str, ...]


def build(folder: Path) -> None:
    """Put records of several kinds, links, a configuration and a model into a folder."""
    import xarray as xr

    prior = Prior.from_settings(read(DEFAULTS)["prior"])
    for each in ("drive/closing", "drive/opening", "listed", "config", "made"):
        (folder / each).mkdir(parents=True)
    for name in ("a.csv", "b 2.csv", "drive/closing/op_1.csv", "drive/closing/op_2.csv"):
        written(folder / name, prior, "closing")
    written(folder / "open.csv", prior, "opening")
    written(folder / "both.csv", prior, "closing", "opening")
    shutil.copy(folder / "open.csv", folder / "drive/opening/op_1.csv")
    shutil.copy(folder / "a.csv", folder / "listed/one.csv")
    table = "file,motion,operation\none.csv,closing,1\n"
    (folder / "listed/operations.csv").write_text(table, encoding="utf-8")
    (folder / "pair.cfg").write_text("no real record\n", encoding="utf-8")
    (folder / "pair.dat").write_bytes(bytes(100))
    (folder / "few.yaml").write_text("endurance: {draws: 100}\n", encoding="utf-8")
    shutil.copy(DEFAULTS, folder / "config/config.yaml")
    shutil.copy(model_file("medium_voltage", "levels"), folder / "own.safetensors")
    travel = xr.Dataset({"travel": ("time", [0.0, 1.0])}, {"time": [0.0, 1.0]})
    travel.to_zarr(folder / "record.zarr", zarr_format=2)
    (folder / "link").symlink_to("drive")
    (folder / "link.csv").symlink_to("a.csv")
    (folder / "link.png").symlink_to("drive/closing/op_1.csv")
    os.link(folder / "b 2.csv", folder / "hard.csv")


def state(folder: Path) -> dict[str, tuple]:
    """Kind, link and content of everything in a folder, by name."""
    found = {}
    for path in sorted(folder.rglob("*")):
        link = os.readlink(path) if path.is_symlink() else ""
        content = hashlib.sha256(path.read_bytes()).hexdigest() if path.is_file() else ""
        found[str(path.relative_to(folder))] = (link, path.is_dir(), content)
    return found


def words_of(number: int, seed: int) -> tuple[str, ...]:
    """A command with inputs and outputs drawn at random."""
    rng = generator(seed, "command lines", number)

    def one(of):
        return str(rng.choice(of))

    command = one(["infer", "infer", "inspect", "inspect", "compare", "report", "fit-prior"])
    inputs = {
        "infer": lambda: [one([*RECORDS, *FOLDERS]) for _ in range(rng.integers(1, 3))],
        "inspect": lambda: [one([*RECORDS, *FOLDERS, "record.zarr"])],
        "compare": lambda: [one(RECORDS), "--today", one([*RECORDS, "b 2.csv"])],
        "report": lambda: [one(RECORDS)],
        "fit-prior": lambda: [one(FOLDERS)],
    }[command]()
    outputs = {
        "infer": ("--output", "--plot", "--draws"),
        "report": ("--output",),
        "compare": ("--plot",),
    }.get(command, ("--output", "--plot"))
    words = [command, *inputs]
    same = one(PLACES)
    for option in outputs:
        if rng.random() < 0.6:
            path = one(PLACES if rng.random() < 0.4 else NEW)
            path = same if rng.random() < 0.1 else path
            words += [option, os.path.abspath(path) if path and rng.random() < 0.2 else path]
    if command == "infer" and rng.random() < 0.1:
        words += ["--model", "own.safetensors"]
    return (*words, "--config", "few.yaml")


def try_line(folder: Path, number: int, seed: int) -> Line:
    """Run one line there, in this process, and look at what it changed."""
    os.chdir(folder)
    words, before = words_of(number, seed), state(folder)
    try:
        with contextlib.redirect_stdout(shown := io.StringIO()), contextlib.redirect_stderr(shown):
            status = main(words)
    except SystemExit as error:
        status = int(error.code)
    except Exception:  # what nobody caught is what is looked for
        status = -1
    after = state(folder)
    inputs = [name for name in before if not name.startswith(NEW)]
    changed = [name for name in inputs if after.get(name) != before[name]]
    changed += [name for name in after.keys() - before.keys() if _HALF.search(name)]
    for name in NEW if number % 2 else ():  # what is left may be replaced by the next line
        path = folder / name
        shutil.rmtree(path) if path.is_dir() else path.unlink(missing_ok=True)
    return Line(number, words, status, tuple(changed))


def try_batch(job: tuple[range, int]) -> list[Line]:
    """Run lines in a folder of their own, made anew where one has changed it."""
    numbers, seed = job
    os.environ["TQDM_DISABLE"] = "1"
    with tempfile.TemporaryDirectory() as place, contextlib.chdir(place):
        lines: list[Line] = []
        for number in numbers:
            if not lines or lines[-1].changed:
                folder = Path(place, str(number))
                build(folder)
            lines.append(try_line(folder, number, seed))
            os.chdir(place)
        return lines


def tabulate(lines: Iterable[Line]) -> pd.DataFrame:
    """Count, for each command and for all, what became of its lines."""
    lines = list(lines)
    table = pd.DataFrame(
        {
            "command": [line.words[0] for line in lines],
            "lines": 1,
            "done": [line.status == 0 for line in lines],
            "refused": [line.status in (1, 2) for line in lines],
            "exception": [line.status == -1 for line in lines],
            "changed": [bool(line.changed) for line in lines],
        }
    )
    table = table.groupby("command").sum()
    table.loc["all"] = table.sum()
    return table


def run(lines: int, seed: int, cores: int = 1) -> list[Line]:
    """Run so many lines."""
    jobs = [(range(i, min(i + BATCH, lines)), seed) for i in range(0, lines, BATCH)]
    if cores == 1:
        return [line for job in jobs for line in try_batch(job)]
    with ProcessPoolExecutor(cores) as pool:
        found = tqdm(pool.map(try_batch, jobs), total=len(jobs), mininterval=5, unit="job")
        return [line for each in found for line in each]


def _main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--lines", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=43)
    parser.add_argument("--cores", type=int, default=2)
    parser.add_argument("--table", type=Path, default=Path("results/command_lines.csv"))
    options = parser.parse_args()
    lines = run(options.lines, options.seed, options.cores)
    table = tabulate(lines)
    options.table.parent.mkdir(parents=True, exist_ok=True)
    table.to_csv(options.table)
    print(table.to_string())
    wrong = [line for line in lines if line.changed or line.status == -1]
    for line in wrong[:20]:
        print(f"command lines: {line}", file=sys.stderr)
    return int(bool(wrong))


if __name__ == "__main__":
    sys.exit(_main())
