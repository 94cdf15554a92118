"""What several studies share: options, tables, and calls of the command `breaker`."""

import argparse
import contextlib
import io
import signal
import sys
import traceback
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from importlib.metadata import entry_points
from itertools import starmap
from pathlib import Path

import pandas as pd


def parser(description: str) -> argparse.ArgumentParser:
    """Return a parser with the options for a table and its rows, which most studies have."""
    options = argparse.ArgumentParser(description=description.splitlines()[0])
    options.add_argument("--table", type=Path, metavar="CSV", help="summary")
    options.add_argument("--rows", type=Path, metavar="CSV", help="a row for each result")
    return options


def sampled(options: argparse.ArgumentParser, **counts: int) -> argparse.ArgumentParser:
    """Add options for numbers of samples, a seed, and processes."""
    for name, default in (counts | {"cores": 1}).items():
        options.add_argument(f"--{name}", type=int, default=default)
    return options


def report(given: argparse.Namespace, table: pd.DataFrame, rows: pd.DataFrame) -> None:
    """Print a table, and write it and its rows to the files that are given."""
    print(table.to_string(index=False))
    for file, part in ((given.table, table), (given.rows, rows)):
        if file:
            file.parent.mkdir(parents=True, exist_ok=True)
            part.to_csv(file, index=False)


def in_pool(function: Callable, jobs: Iterable[tuple], cores: int) -> Iterator:
    """Yield what a function returns for tuples of arguments, in their order, from processes."""
    jobs = [*jobs]
    if cores == 1:
        yield from starmap(function, jobs)
        return
    with ProcessPoolExecutor(cores) as pool:
        yield from pool.map(function, *zip(*jobs, strict=True), chunksize=1)


def append(rows: pd.DataFrame, file: str | Path, float_format: str | None = None) -> None:
    """Add rows to a CSV file, which gets its header with the first of them."""
    header = not Path(file).exists()
    rows.to_csv(file, mode="a", header=header, index=False, float_format=float_format)


def call(*arguments: object, limit: int = 180) -> tuple[int | str, str, str]:
    """Return status (or the trace of an exception), text and errors of the command `breaker`."""

    def late(*_):
        raise TimeoutError(f"no answer in {limit} s")

    out, err = (io.TextIOWrapper(io.BytesIO(), encoding="utf-8") for _ in range(2))
    (command,) = entry_points(group="console_scripts", name="breaker")
    before, status = sys.argv, 0
    sys.argv = ["breaker", *map(str, arguments)]
    signal.signal(signal.SIGALRM, late)
    signal.alarm(limit)
    try:
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            status = command.load()() or 0
    except SystemExit as leave:
        status = leave.code or 0
    except Exception:
        status = traceback.format_exc()
    finally:
        signal.alarm(0)
        sys.argv = before
    out.flush(), err.flush()
    return status, *(stream.buffer.getvalue().decode("utf-8", "replace") for stream in (out, err))
