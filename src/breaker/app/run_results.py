"""What a run of the workflow left: a life with its limits and plan, and a fleet in its ranks.

Sentences, tables and numbers are those of the run's files, as it wrote them. What reads them is a
third of the page's memory, and is loaded where a run has left something.
"""

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

from breaker.app.curve_traces import plain
from breaker.app.result_folders import FLEET, LIFE
from breaker.common.numerals import in_digits
from breaker.common.zarr_store import open_store
from breaker.documents.parts import Cell, Document, Section, Table
from breaker.drive.fleet.drive_document import FLEET_STATES
from breaker.drive.fleet.fleet_page import TONES, fleet_document
from breaker.drive.life.first_page import in_percent
from breaker.model.parameters import PARAMETERS
from breaker.reading.files.guards import RejectedCurveError, read_bytes
from breaker.reading.files.safe_text import as_meant

_ON = "operation"
_REMEDY = "wait until the run has ended, or start it again: snakemake -c2 all"


class Line(NamedTuple):
    """Values of one quantity.

    Attributes:
        name: What it is called.
        x, middle, low, high: Places and values, ``(t,)``; without an interval the three are one.
    """

    name: str
    x: np.ndarray
    middle: np.ndarray
    low: np.ndarray
    high: np.ndarray


class Panel(NamedTuple):
    """A picture of lines over one axis.

    Attributes:
        title, x, y: What it shows, and what stands along its axes.
        lines: Its lines.
        levels: Names and values of what lies across it.
        places: Names and places of what stands on its axis.
        within: Values that are always in sight.
    """

    title: str
    x: str
    y: str
    lines: Sequence[Line]
    levels: Sequence[tuple[str, float]] = ()
    places: Sequence[tuple[str, float]] = ()
    within: Sequence[float] = ()


@dataclass(frozen=True, eq=False)
class Life:
    """A life as a run has told it.

    Attributes:
        document: Sentences of its first page, limits with their plan, changes.
        limits: Names of the limits, the one that is due first.
        stores: Datasets ``life`` and ``standing``.
    """

    document: Document
    limits: Sequence[str]
    stores: tuple[xr.Dataset, xr.Dataset]

    def panels(self, limit: str) -> list[Panel]:
        """Return the pictures of a limit, if one is named, and that of the parameters."""
        life, _ = self.stores
        asked = life["asked"].values
        noticed = zip(life["change_names"].values, life["start"].values, strict=True)
        places = [(f"change of {name}", float(at)) for name, at in noticed]
        lines = [
            _band(each.word, asked, life["changed"].sel(parameter=each.name).values)
            for each in PARAMETERS
        ]
        title, y = "Changes of parameters since new, median and 90 %", "change (%)"
        of_limit = self._of_limit(limit, places) if limit else []
        return [*of_limit, Panel(title, _ON, y, lines, (), places)]

    def pictures(self, limit: str) -> list[dict]:
        """Return the panels for JSON."""
        return [panel_values(each) for each in self.panels(limit)]

    def _of_limit(self, limit: str, places: Sequence[tuple[str, float]]) -> list[Panel]:
        """What it is about, how probably it is exceeded, what is left, and what a service costs."""
        life, standing = self.stores
        last = standing.isel(operation=-1).sel(limit=limit)
        by = {"exceeded for certain": "certain", "service by": "service_by"}
        told = {words: float(last[name]) for words, name in by.items()}
        places = [*places, *((words, at) for words, at in told.items() if np.isfinite(at))]
        beyond = standing["beyond"].sel(limit=limit).values
        left = life["remaining"].sel(limit=limit).values
        probable = _line("probability", standing["operation"].values, beyond)
        remaining = _band("operations left", life["asked"].values, left)
        cost = _line("cost", last["ahead"].values, last["extra"].values)
        title = f"{limit}: {{}}".format
        more = "what a service costs beyond the best operation"
        return [
            *_values(life, limit, places),
            Panel(title("probability"), _ON, "probability", [probable], (), places, (0.0, 1.0)),
            Panel(title("operations left, 90 %"), _ON, "operations left", [remaining], (), places),
            Panel(title(more), "operations from now", "services", [cost]),
        ]


def _values(life: xr.Dataset, limit: str, places: Sequence[tuple[str, float]]) -> Iterator[Panel]:
    """What a limit is about, a panel for each of its parts."""
    for k in np.flatnonzero(life["part_limit"].values == limit):
        part = life.isel(part=k)
        name = str(part["part_quantity"].item()).replace("_", " ")
        unit = str(part["part_unit"].item())
        side = "above" if part["part_upper"].item() else "below"
        levels = [
            (f"limit: {side} {in_digits(float(part['part_bound']), 4)}", float(part["part_bound"])),
            ("new", float(part["new"])),
        ]
        yield Panel(
            f"{limit}: {life['words'].sel(limit=limit).item()}; median and 90 %",
            _ON,
            f"{name} ({unit})",
            [_band(name, life["asked"].values, part["value"].values)],
            levels,
            places,
        )


def _line(name: str, x: np.ndarray, y: np.ndarray) -> Line:
    return Line(name, x, y, y, y)


def _band(name: str, x: np.ndarray, values: np.ndarray) -> Line:
    low, middle, high = values.T
    return Line(name, x, middle, low, high)


def panel_values(panel: Panel) -> dict:
    """Return a panel for JSON: points where a line has any, of very long ones every so many."""
    lines = [_points(each) for each in panel.lines]
    empty = "" if any(each["x"] for each in lines) else ": beyond the horizon, or not known"
    return {
        "title": panel.title + empty,
        "x": panel.x,
        "y": panel.y,
        "lines": lines,
        "levels": [[name, value] for name, value in panel.levels if np.isfinite(value)],
        "places": [[name, value] for name, value in panel.places],
        "within": list(panel.within),
    }


def _points(line: Line) -> dict:
    known = np.flatnonzero(np.isfinite(line.middle))
    kept = known[:: max(1, known.size // 1000)]
    if known.size:
        kept = np.union1d(kept, known[-1:])
    ends = (line.x, line.middle, line.low, line.high)
    values = [plain(each[kept].astype(float)) for each in ends]
    return {"name": line.name, **dict(zip(("x", "y", "low", "high"), values, strict=True))}


# ---- from files ----------------------------------------------------------------------------------


def read_life(folder: Path) -> Life:
    """Read the life of a run.

    Raises:
        ValueError: If a file of it lacks, or is not as the run wrote it.
    """
    try:
        words = json.loads(read_bytes(folder / LIFE[0]))
        limits, changes = (_table(folder / each) for each in LIFE[1:3])
        stores = tuple(open_store(folder / each).load() for each in LIFE[3:])
        document = _life_document(words, limits, changes, *stores)
        names = [str(each) for each in stores[0]["limit"].values]
    except RejectedCurveError as error:
        raise ValueError(f"{error}: {_REMEDY}") from error
    except FileNotFoundError as error:
        raise ValueError(f"{error.filename} is not there: {_REMEDY}") from error
    except (KeyError, TypeError, IndexError) as error:
        raise ValueError(f"{folder} is not as a run writes it ({error}): {_REMEDY}") from error
    subject = int(stores[1]["subject"].values[-1])
    first = names[subject] if subject >= 0 else ""
    return Life(document, sorted(names, key=lambda name: name != first), stores)


def _table(file: Path) -> pd.DataFrame:
    """A table of a run, as texts."""
    frame = pd.read_csv(BytesIO(read_bytes(file)), dtype=str, keep_default_na=False)
    return frame.rename(columns=as_meant).map(as_meant)


def _life_document(
    words: dict, limits: pd.DataFrame, changes: pd.DataFrame, life: xr.Dataset, standing: xr.Dataset
) -> Document:
    """Sentences of the first page, the table of limits with the plan, and changes."""
    states = standing.attrs["states"]
    tone = TONES[states[int(standing["drive_state"].values[-1])]]
    headline, *others = words["sentences"]
    told = pd.DataFrame(words["limits"])
    plan = limits.drop_duplicates("limit").set_index("limit")
    rows = [
        (*_toned(row), *(_shown(plan.loc[row["limit"]], name) for name in _PLAN))
        for row in told.to_dict("records")
    ]
    head = [*told, *_PLAN.values()]
    noticed = [row for row in changes.to_dict("records") if row["kind"] != "now"]
    parts = [Table(head, rows, "Limits and plan", ["P: probability that the limit is exceeded"])]
    if noticed:
        began = "{start} ({earliest} to {latest})"
        lines = [
            (row["noticed"], began.format_map(row), row["kind"], row["names"]) for row in noticed
        ]
        head = ("noticed at", "began at (90 %)", "kind", "of")
        parts.append(Table(head, lines, "Changes that were noticed"))
    parts.append(Section("Parameters since new", [_since_new(changes.iloc[-1])]))
    return Document("Life", (), [Cell(headline, tone), *others], parts)


_PLAN = {"service_by": "service by", "told_since": "told since", "risk": "risk until the next look"}


def _toned(row: dict) -> list[str]:
    return [Cell(v, TONES.get(v, "")) if name == "state" else v for name, v in row.items()]


def _shown(row: pd.Series, name: str) -> str:
    value = row[name]
    return in_percent(float(value)) if name == "risk" and value else value


def _since_new(row: pd.Series) -> Table:
    known = [each for each in PARAMETERS if row[each.name]]
    ends = [f"{row[f'{each.name}_5']} to {row[f'{each.name}_95']}" for each in known]
    still = [in_percent(float(row[f"{each.name}_unchanged"])) for each in known]
    rows = [
        (each.word, row[each.name], *beside)
        for each, *beside in zip(known, ends, still, strict=True)
    ]
    head = ("parameter", "change (%)", "90 %", "P that it has not changed")
    return Table(head, rows)


def read_fleet(folder: Path) -> Document:
    """Read the fleet of a run: its drives in their ranks, and types.

    Raises:
        ValueError: If a file of it lacks, or is not as the run wrote it.
    """
    try:
        table, types = (_table(folder / each) for each in FLEET)
        spread = pd.to_numeric(table["pole_spread"])
        numbers = {name: pd.to_numeric(types[name]) for name in ("median", "log_sd", "spread")}
        if unknown := set(table["state"]) - set(FLEET_STATES):
            raise ValueError(f"{folder / FLEET[0]} has states that no run tells: {unknown}")
        return fleet_document(table.assign(pole_spread=spread), types.assign(**numbers))
    except RejectedCurveError as error:
        raise ValueError(f"{error}: {_REMEDY}") from error
    except KeyError as error:
        raise ValueError(f"{folder} is not as a run writes it ({error}): {_REMEDY}") from error
