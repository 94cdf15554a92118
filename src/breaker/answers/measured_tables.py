"""What is measured of one motion of an operation, against limits: a column for each channel."""

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from breaker.answers.answer import Answer
from breaker.answers.cells import RESULTS, Cell, Table, named, number
from breaker.files import printable
from breaker.mechanism import Limit

__all__ = ["Group", "measured_table"]

_EVENTS = {"closing": "touch", "opening": "parting"}


class Group(NamedTuple):
    """One motion of an operation.

    Attributes:
        channels: Answer, and its entry in the document, by channel.
        phases: Names of all channels of the visit.
    """

    channels: Mapping[str, tuple[Answer, Mapping]]
    phases: Sequence[str]

    @property
    def first(self) -> Answer:
        """The answer of its first channel."""
        return next(iter(self.channels.values()))[0]

    @property
    def motion(self) -> str:
        """ "closing" or "opening"."""
        return self.first.record.motion

    @property
    def file(self) -> str:
        """Where it is from."""
        return printable(self.first.record.operation.file)

    @property
    def title(self) -> str:
        """Which motion it is: when, of several in a file; of which operation, where that counts."""
        record = self.first.record
        of = record.operation
        whole = math.isnan(of.begin) and math.isnan(of.end)
        said = [record.motion if whole else f"{record.motion} at {record.raw.moves:.0f} ms"]
        said += [f"operation {of.number}"] if of.breaker or of.date else []
        return f"{', '.join(said)}: {self.file.rpartition('/')[2]}"


def measured_table(
    group: Group,
    limits: Sequence[Limit],
    printed: Mapping[tuple[str, str, str, str], float],
) -> Table:
    """Return what is measured, first what needs no model.

    Args:
        group: The motion.
        limits: Those of all motions.
        printed: What the analyser printed, by file, motion, channel and quantity.
    """
    limits = [each for each in limits if each.motion == group.motion]
    entries = [_known(entry) for _, entry in group.channels.values()]
    found: dict[str, dict[str, Mapping]] = {}
    for phase, quantities in zip(group.channels, entries, strict=True):
        for name, each in quantities.items():
            found.setdefault(name, {})[phase] = each
    rows = _times(group)
    for name in sorted(found, key=lambda name: _starred(found[name])):
        own = [each for each in limits if name == each.quantities[0]]
        rows.append(_row(name, found[name], group, own))
        values = [printed.get((group.file, group.motion, phase, name)) for phase in group.phases]
        if any(value is not None for value in values):
            said = ["" if value is None else number(value, 4) for value in values]
            rows.append(
                tuple(Cell(each, "faint") for each in ("  printed by the analyser", "", *said))
            )
    head = ["measured", "unit", *(phase or "value" for phase in group.phases), "± 95 %"]
    head += (["differ by"] if len(group.phases) > 1 else []) + (
        ["limit", "result"] if limits else []
    )
    rows = [(*row, *[Cell("")] * len(head))[: len(head)] for row in rows]
    return Table(group.title, tuple(head), rows, _notes(group.channels, group.motion))


def _known(entry: Mapping) -> dict[str, Mapping]:
    """Quantities of a channel; no value that rests on the network where its draws are too few."""
    few = "hardly a draw of the network is left: see what the model adds"
    withheld = {"median": None, "source": None, "reason": few}
    if not entry["fit"]["why_unresolved"]:
        return entry["quantities"]
    return {
        name: each if each["source"] in ("measured", None) else {**each, **withheld}
        for name, each in entry["quantities"].items()
    }


def _starred(by: Mapping[str, Mapping]) -> bool:
    """Whether the model has a part in a quantity of any channel."""
    return any(each["source"] not in ("measured", None) for each in by.values())


def _row(name: str, by: Mapping, group: Group, limits: Sequence[Limit]) -> tuple[Cell, ...]:
    """A quantity of all channels, with its limits."""
    known = [each for each in by.values() if each["median"] is not None]
    halves = [(each["interval_95"][1] - each["interval_95"][0]) / 2.0 for each in known]
    cells = [_value(by.get(phase)) for phase in group.phases]
    cells.append(Cell(number(max(halves), 2) if halves else ""))
    if len(group.phases) > 1:
        cells.append(_spread([each["median"] for each in known]))
    result = _result(group.channels, [each.pair or each.name for each in limits])
    unit = next(iter(by.values()))["unit"]
    return (Cell(name), Cell(unit), *cells, Cell(_bounds(limits)), result)


def _times(group: Group) -> list[tuple[Cell, ...]]:
    """When channels move and contacts switch in the record: what poles differ by."""
    raws = {phase: answer.record.raw for phase, (answer, _) in group.channels.items()}
    rows = []
    names = {"first motion at": "moves", f"{_EVENTS[group.motion]} at": "switching"}
    for name, of in names.items():
        values = [getattr(raws.get(phase), of, np.nan) for phase in group.phases]
        cells = [Cell(f"{value:.2f}" if np.isfinite(value) else "–") for value in values]
        if np.isfinite(values).any():
            rows.append((Cell(name), Cell("ms"), *cells, Cell(""), _spread(values)))
    return rows


def _value(each: Mapping | None) -> Cell:
    """A value; with a star where the model has a part in it."""
    if each is None or each["median"] is None:
        return Cell("–", "faint")
    return Cell(number(each["median"], 4) + "*" * (each["source"] != "measured"))


def _spread(values: Sequence[float]) -> Cell:
    there = [value for value in values if np.isfinite(value)]
    return Cell(number(np.ptp(there), 2) if len(there) > 1 else "")


def _bounds(limits: Sequence[Limit]) -> str:
    """What limits ask of a quantity, in short."""
    said = []
    for limit in limits:
        (_, value, is_upper), *more = limit.parts
        said.append(f"not: {limit.words}" if more else f"{'≤' if is_upper else '≥'} {value:g}")
    return ", ".join(said)


def _result(by: Mapping, names: Sequence[str]) -> Cell:
    """The worst verdict on some limits, and of which channels."""
    found: dict[str, list[str]] = {}
    for phase, (_, entry) in by.items():
        for each in entry.get("limits", ()):
            if each["name"] in names:
                found.setdefault(each["verdict"], []).append(phase)
    for verdict, (text, tone) in RESULTS.items():
        if verdict in found:
            where = [*filter(None, dict.fromkeys(found[verdict]))]
            named = f" ({', '.join(where)})" if 0 < len(where) < len(by) else ""
            return Cell(text + named, tone)
    return Cell("")


def _notes(by: Mapping, motion: str) -> list[str]:
    """Why values are missing, what a star means, and what is doubtful."""
    said = []
    starred = False
    for phase, (_, entry) in by.items():
        for name, each in _known(entry).items():
            starred |= bool(each["source"]) and each["source"] != "measured"
            if each["reason"]:
                said.append((phase, f"– {name}: {each['reason']}"))
        said += [(phase, f"remark: {remark}") for remark in entry["remarks"]]
    star = (
        f"* the time of the {_EVENTS[motion]} was not measured: by the model's, with its interval"
    )
    return [*([star] if starred else []), *named(said, len(by))]
