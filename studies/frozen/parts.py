"""What is frozen: a small run, answers to example exports and damaged files, a study."""

import json
import math
import re
import tempfile
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import chdir
from functools import partial
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pandas as pd
import yaml

from breaker.common.randomness import generator
from breaker.common.zarr_store import open_store
from breaker.model.parameters import MOTIONS
from studies.exports.__main__ import call
from studies.faults.files import TEXT
from studies.faults.judge import KINDS, good_file, try_kind
from studies.faults.records import PHYSICAL
from studies.layouts import LAYOUTS
from studies.wrong_inputs.__main__ import run as run_wrong_inputs
from studies.wrong_inputs.__main__ import summary as wrong_summary
from studies.wrong_inputs.kinds import KINDS as WRONG

Numbers = dict[str, float | None]
"""Numbers by names whose parts have slashes between; None where a value is withheld."""

_DAMAGED = 2000  # files; a fifth of a second each
_GOOD = 20  # good records of a motion in each layout, as in the study of faults
_CASES = 4  # inputs of each kind of the study of wrong inputs
_KEPT = re.compile(r"accepted|/fit/|/quantities/|/parameters/")  # of answers to damaged files
_DIGITS = 6  # significant digits that are kept
_WORDS = ("reason", "remarks", "warnings")  # keys and columns of texts
_KEYS = ("kind", "by", "of", "name", "operation", "posterior", "output", "limit", "parameter")


def flat(value: object, name: str = "") -> Iterator[tuple[str, float | None]]:
    """Return all numbers of a document by name; entries of lists are named by what they are of."""
    if isinstance(value, dict):
        for key, each in value.items():
            if key not in _WORDS:
                yield from flat(each, f"{name}/{key}")
    elif isinstance(value, list):
        for index, each in enumerate(value):
            yield from flat(each, f"{name}/{_label(each) or index}")
    elif value is None or isinstance(value, bool | int | float):
        yield name.removeprefix("/"), rounded(value)


def _label(value: object) -> str:
    if not isinstance(value, dict):
        return ""
    keys = ("file", "operation", "motion", "name", "parameter", "limit")
    return " ".join(str(value[key]) for key in keys if isinstance(value.get(key), str | int))


def rounded(value: float | None, digits: int = _DIGITS) -> float | None:
    """Return a finite number with few digits; None for others."""
    if value is None or not math.isfinite(value):
        return None
    return float(f"{value:.{digits}g}")


def table_numbers(table: pd.DataFrame) -> Numbers:
    """Return the numbers of a table by what their row is of and the names of their columns.

    A row whose label stands above already is told apart by its number.
    """
    keys = [key for key in _KEYS if key in table]
    found: Numbers = {}
    seen: set[str] = set()
    for number, row in enumerate(table.to_dict("records")):
        label = "/".join(str(row[key]) for key in keys) or str(number)
        label = f"{label}/{number}" if label in seen else label
        seen.add(label)
        for name, value in row.items():
            if name not in (*keys, *_WORDS) and isinstance(value, bool | int | float | np.number):
                found[f"{label}/{name}"] = rounded(float(value))
    return found


def run(seed: int, cores: int) -> Numbers:
    """Return numbers of the tables and stores in results/, of a run with config/test.yaml."""
    if not Path("results/numbers.csv").exists():
        raise SystemExit("run `snakemake -c2 all --configfile config/test.yaml` here before")
    found: Numbers = {}
    for file in sorted(Path("results").rglob("*.csv")):
        if not {"benchmarks", "rig"} & set(file.parts):
            numbers = table_numbers(pd.read_csv(file, comment="#"))
            found |= {f"{file.relative_to('results')}/{k}": v for k, v in numbers.items()}
    stores = [p.parent for p in Path("results").rglob(".zgroup")]
    stores += [p.parent for p in Path("results").rglob("zarr.json")]
    for store in sorted(set(stores)):
        if store.suffix != ".zarr":
            continue
        for name, values in open_store(store).items():
            if values.dtype.kind in "fiub" and values.size:
                array = values.values.astype(float)
                finite, place = array[np.isfinite(array)], f"{store.relative_to('results')}/{name}"
                found[f"{place}/finite"] = float(finite.size)
                if finite.size:
                    found[f"{place}/mean"] = rounded(finite.mean())
                    found[f"{place}/sd"] = rounded(finite.std())
    return found


def default(seed: int, cores: int) -> Numbers:
    """Return the numbers of the last run with the default settings, which the pages state."""
    return table_numbers(pd.read_csv("docs/numbers.csv", comment="#"))


class _Cells(HTMLParser):
    """Cells of the tables of a page, row by row."""

    def __init__(self) -> None:
        super().__init__()
        self.rows: list[list[str]] = []
        self._inside = False

    def handle_starttag(self, tag: str, attrs: list) -> None:
        if tag == "tr":
            self.rows.append([])
        if tag in ("td", "th") and self.rows:
            self.rows[-1].append("")
            self._inside = True

    def handle_endtag(self, tag: str) -> None:
        self._inside = self._inside and tag not in ("td", "th")

    def handle_data(self, data: str) -> None:
        if self._inside:
            self.rows[-1][-1] += data


def page_numbers(page: str) -> Numbers:
    """Return the numbers in the tables of a page of HTML, by row, cell and place in the cell."""
    cells, found = _Cells(), {}
    cells.feed(page)
    for row, texts in enumerate(cells.rows):
        for cell, text in enumerate(texts):
            for place, number in enumerate(re.findall(r"-?\d+(?:\.\d+)?", text)):
                found[f"{row}/{cell}/{place}"] = float(number)
    return found


def _json(*arguments: object) -> dict:
    status, text, err = call(*arguments, "--json")
    try:
        return json.loads(text)
    except json.JSONDecodeError:
        raise RuntimeError(f"breaker {arguments}: {status} {err}") from None


def answers(seed: int, cores: int) -> Numbers:
    """Return what the commands answer to the exports of `breaker example`."""
    found: dict[str, object] = {}
    with tempfile.TemporaryDirectory() as scratch, chdir(scratch):
        for name, option in {"rack": [], "worn": ["--worn"], "visits": ["--visits"]}.items():
            call("example", name, *option)
        for file in sorted(Path().glob("*/*.*")):
            layout = Path(f"{file.stem}.yaml")
            call("inspect", file, "--output", layout)
            text = layout.read_text(encoding="utf-8") if layout.exists() else ""
            text = re.sub(r"rate: null(,?).*FILL IN.*", r"rate: 10.0\1", text)
            layout.write_text(text, encoding="utf-8")
            found[f"inspect/{file}"] = yaml.safe_load(text) or {}
            found[f"infer/{file}"] = _json("infer", file, "--config", layout)
        layout = "rack_0001.yaml"
        new, worn = sorted(Path("rack").iterdir()), sorted(Path("worn").iterdir())
        for channel in ("S 1", "R 3"):
            compared = ["compare", *new, "--today", *worn, "--channel", channel]
            found[f"compare/{channel}"] = _json(*compared, "--config", layout)
        before, today = (f"visits/visit_{year}.csv" for year in ("2014-05-12", "2026-03-02"))
        own = ("--config-before", "visit_2014-05-12.yaml")
        own += ("--config-today", "visit_2026-03-02.yaml")
        found["compare/visits"] = _json("compare", before, "--today", today, *own)
        for name, options in {"new": new, "worn": [*worn, "--before", *new]}.items():
            call("report", *options, "--output", f"{name}.html", "--config", layout)
            page = Path(f"{name}.html").read_text(encoding="utf-8")
            found[f"report/{name}"] = page_numbers(page)
    return dict(flat(found))


def _one_damaged(number: int, seed: int) -> Numbers:
    """Return the answer to one damaged file; kinds of damage take turns."""
    kind = KINDS[number % len(KINDS)]
    rng = generator(seed, "frozen damage", kind, number)
    layout = list(LAYOUTS)[rng.integers(len(LAYOUTS))]
    motion = MOTIONS[rng.integers(len(MOTIONS))]
    good = good_file(layout, motion, int(rng.integers(_GOOD)), seed)
    with tempfile.TemporaryDirectory() as scratch:
        file, own = Path(scratch, next(iter(good.files))), Path(scratch, "own.yaml")
        for name, content in good.files.items():
            Path(scratch, name).write_bytes(content)
        if kind in PHYSICAL:
            good.write(file, *PHYSICAL[kind](good.time, good.travel, rng))
        else:
            damaged = Path(scratch, str(rng.choice(list(good.files))))
            damaged.write_bytes(TEXT[kind](damaged.read_bytes(), rng))
        settings = json.loads(json.dumps(good.settings, default=float))
        own.write_text(yaml.safe_dump({"endurance": {"format": settings}}), encoding="utf-8")
        status, text, _ = call("infer", file, "--motion", motion, "--json", "--config", own)
        found: Numbers = {"crashed": float(isinstance(status, str) and "Traceback" in status)}
        try:
            records = json.loads(text)["records"]
        except (json.JSONDecodeError, KeyError):
            records = []
        found["records"] = float(len(records))
        for place, record in enumerate(records):
            for name, value in flat(record, str(place)):
                if _KEPT.search(name) and value is not None:
                    found[name] = rounded(value, 4)
    return {f"{kind}/{number}/{name}": value for name, value in found.items()}


def damaged(seed: int, cores: int) -> Numbers:
    """Return the answers to many damaged files."""
    found: Numbers = {}
    with ProcessPoolExecutor(cores) as pool:
        for one in pool.map(partial(_one_damaged, seed=seed), range(_DAMAGED), chunksize=20):
            found |= one
    return found


def faults(seed: int, cores: int) -> Numbers:
    """Return what the reader makes of damaged files, counted by kind and outcome."""
    count = -(-_DAMAGED // len(KINDS))
    jobs = [(kind, number, seed) for kind in KINDS for number in range(count)]
    with ProcessPoolExecutor(cores) as pool:
        trials = list(pool.map(try_kind, *zip(*jobs, strict=True), chunksize=count))
    table = pd.crosstab([t.kind for t in trials], [t.outcome for t in trials])
    return table_numbers(table.reset_index(names="kind"))


def wrong_inputs(seed: int, cores: int) -> Numbers:
    """Return the table of `studies.wrong_inputs`."""
    rows = run_wrong_inputs([*WRONG], _CASES, seed, cores)
    return table_numbers(wrong_summary(rows).drop(columns="seconds"))


PARTS: dict[str, Callable[[int, int], Numbers]] = {
    "run": run,
    "default": default,
    "answers": answers,
    "damaged": damaged,
    "faults": faults,
    "wrong_inputs": wrong_inputs,
}
"""How the numbers of each part are made, from a seed and the number of cores."""
