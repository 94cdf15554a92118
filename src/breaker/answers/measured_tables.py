"""What is measured of one motion of an operation, against limits: a column for each channel."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from breaker.answers.cells import NONE, RESULTS, Cell, Table, named, some_of
from breaker.answers.words import bounds_in_words, starred
from breaker.mechanism import EVENTS, in_digits

__all__ = ["Group", "measured_table"]


class Group(NamedTuple):
    """One motion of an operation.

    Attributes:
        title: Which one it is.
        file, motion: What it is of.
        channels: Entry in the document, by channel.
    """

    title: str
    file: str
    motion: str
    channels: Mapping[str, Mapping]


def measured_table(group: Group, printed: Mapping[tuple, tuple[float, str]]) -> Table:
    """Return what is measured, first what needs no model.

    Args:
        group: The motion.
        printed: What the analyser printed, by file, motion, channel and quantity: the value, and
            what differs in its definition; empty if nothing does.
    """
    found: dict[str, dict[str, Mapping]] = {}
    for phase, entry in group.channels.items():
        for name, each in entry["quantities"].items():
            found.setdefault(name, {})[phase] = each
    rows = _times(group)
    for name in sorted(found, key=lambda name: any(map(starred, found[name].values()))):
        rows.append(_row(name, found[name], group))
        values = [printed.get((group.file, group.motion, p, name), ()) for p in group.channels]
        if any(values):
            odd = next((each[1] for each in values if each and each[1]), "")
            label = f"  printed{', ' * bool(odd)}{odd}"
            said = ["", *(in_digits(each[0], 4) if each else "" for each in values)]
            rows.append(tuple(Cell(each, "faint") for each in (label, *said)))
    head = ["measured", "unit", *(phase or "value" for phase in group.channels), "± 95 %"]
    head += ["differ by"] if len(group.channels) > 1 else []
    head += (
        ["limit", "result"] if any(each.get("limits") for each in group.channels.values()) else []
    )
    rows = [(*row, *[Cell("")] * len(head))[: len(head)] for row in rows]
    return Table(group.title, tuple(head), rows, _notes(group))


def _row(name: str, by: Mapping, group: Group) -> tuple[Cell, ...]:
    """A quantity of all channels, with its limits."""
    known = [each for each in by.values() if each["median"] is not None]
    halves = [(each["interval_95"][1] - each["interval_95"][0]) / 2.0 for each in known]
    cells = [
        Cell(in_digits(each["median"], 4) + "*" * starred(each)) if each in known else NONE
        for each in (by.get(phase) for phase in group.channels)
    ]
    cells.append(Cell(in_digits(max(halves), 2) if halves else ""))
    cells += _spread([each["median"] for each in known], group, "*" * any(map(starred, known)))
    unit = next(iter(by.values()))["unit"]
    return (Cell(name), Cell(unit), *cells, *_limits(name, group.channels))


def _times(group: Group) -> list[tuple[Cell, ...]]:
    """When channels move and contacts switch in the record: what poles differ by."""
    rows = []
    fits = [group.channels.get(phase, {}).get("fit", {}) for phase in group.channels]
    moves = np.array([each.get("moves", np.nan) for each in fits])
    after = np.array([each.get("contact_time", np.nan) for each in fits])
    for name, values in {"first motion": moves, EVENTS[group.motion]: moves + after}.items():
        if np.isfinite(values).any():
            cells = [Cell(f"{each:.2f}") if np.isfinite(each) else NONE for each in values]
            spread = _spread(values[np.isfinite(values)], group)
            rows.append((Cell(f"{name} at"), Cell("ms"), *cells, Cell(""), *spread))
    return rows


def _spread(values: Sequence[float], group: Group, star: str = "") -> list[Cell]:
    """By how much channels differ, with a star where the model has a part; nothing of one."""
    if len(group.channels) == 1:
        return []
    return [Cell(in_digits(np.ptp(values), 2) + star if len(values) > 1 else "")]


def _limits(name: str, channels: Mapping[str, Mapping]) -> tuple[Cell, ...]:
    """What limits ask of a quantity, the worst verdict, and of which channels."""
    rows = [
        (phase, each)
        for phase, entry in channels.items()
        for each in entry.get("limits", ())
        if each["parts"][0]["quantity"] == name
    ]
    asked = dict.fromkeys(
        f"not: {each['words']}" if len(each["parts"]) > 1 else bounds_in_words(each["parts"][0])
        for _, each in rows
    )
    for verdict, (text, tone) in RESULTS.items():
        if of := [phase for phase, each in rows if each["verdict"] == verdict]:
            return Cell(", ".join(asked)), Cell(some_of(text, of, len(channels)), tone)
    return ()


def _notes(group: Group) -> list[str]:
    """Why values are missing, what a star means, and what is doubtful."""
    said, any_star = [], False
    points: dict[str, None] = {}
    for phase, entry in group.channels.items():
        for name, each in entry["quantities"].items():
            any_star |= starred(each)
            if "_speed" in name and not name[-1].isdigit():  # whose name does not say its points
                points[f"{name}: {each['meaning']}"] = None
            said += [(phase, f"– {name}: {each['reason']}")] if each["reason"] else []
        said += [(phase, f"remark: {remark}") for remark in entry["remarks"]]
    event = EVENTS[group.motion]
    star = f"* the time of the {event} was not measured: by the model's, with its interval"
    return [*points, *([star] if any_star else []), *named(said, len(group.channels))]
