"""Whether records are what they are taken for: of one drive and visit, each once, in their order.

What is found is said before anything else; copies count once, and records of several drives have no
common mean.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from breaker.answers.record import Record
from breaker.answers.stated import date_of
from breaker.files import printable
from breaker.mechanism import in_digits
from breaker.records import is_copy

_MOST = 200  # records of a motion, of more than which only equal samples are looked for
_NEAR = 0.7  # of the noise of both, by which the shapes of copies differ at most
# Shares by which neighbours differ, of records in their order, that are of two drives.
_APART = {"stroke": (0.03, "mm"), "duration": (0.25, "ms")}
_SDS = 6.0  # of the noise, by which they differ as well
_NAMED = 4  # files in a sentence


def without_copies(records: Sequence[Record]) -> list[Record]:
    """Return records, of which copies of an earlier one cannot be used, each with the reason."""
    found, first = [], {}
    for each in records:
        of = None if each.reason else _copied(each, first.setdefault(each.motion, _Seen([], {})))
        if of is not None:
            reason = f"{_name(each)} holds the samples of {_name(of, beside=each)}: they count once"
            each = replace(each, reason=reason, raw=None, shape=None, seen=None)
        found.append(each)
    return found


class _Seen(NamedTuple):
    """Records of a motion so far, and these by their samples."""

    records: list[Record]
    samples: dict[bytes, Record]


def _copied(record: Record, seen: _Seen) -> Record | None:
    """The record of which one is a copy, None if it is none; it is seen from then on."""
    key = record.raw.left.tobytes()
    if key in seen.samples and _place(seen.samples[key]) != _place(record):
        return seen.samples[key]
    near = seen.records if len(seen.records) < _MOST else []
    of = next((each for each in near if copies(each, record)), None)
    if of is None:
        seen.records.append(record)
        seen.samples[key] = record
    return of


def copies(one: Record, other: Record) -> bool:
    """Say whether two records of one motion hold the same samples, as exported twice.

    Motions of one channel of a file never do.
    """
    if _place(one) == _place(other):
        return False
    noise = np.hypot(one.seen.noise[0], other.seen.noise[0])
    both = one.shape.present & other.shape.present
    off = (one.shape.way - other.shape.way)[both]
    scale = one.shape.stroke / other.shape.stroke
    alike = abs(np.log(scale)) < noise and off.size and np.sqrt(np.mean(off**2)) < _NEAR * noise
    return bool(alike) and is_copy(one.raw, other.raw)


def _place(record: Record) -> tuple[str, str]:
    """File and channel of a record."""
    return str(record.operation.file), record.operation.channel


def doubts_about(records: Sequence[Record]) -> list[str]:
    """Say what files state against how they were read, and what speaks against records being of
    one drive, in the order of their numbers.
    """
    said = [each.warning for each in records if each.warning]
    usable = [each for each in records if not each.reason]
    said += [*_names_differ(usable), *mixed(usable).values(), *_out_of_order(usable)]
    return list(dict.fromkeys(said))


def mixed(records: Sequence[Record]) -> dict[tuple[str, str, str], str]:
    """Return why records of a breaker, phase and motion are not of one drive, where they are not:
    neighbours in their order differ by more than operations of a drive do.
    """
    groups: dict[tuple[str, str, str], list[Record]] = {}
    for each in records:
        key = each.operation.breaker, each.operation.phase, each.motion
        if not each.reason:
            groups.setdefault(key, []).append(each)
    found = {}
    for key, some in groups.items():
        for name, (share, unit) in _APART.items():
            value = _of_shape(name)
            ordered = sorted(some, key=value)
            values = np.array([value(each) for each in ordered])
            noise = max(float(each.seen.noise[0]) for each in ordered)
            gaps = np.diff(np.log(values))
            if not gaps.size or gaps.max() <= max(share, _SDS * noise):
                continue
            cut = int(gaps.argmax()) + 1
            sides = ordered[:cut], ordered[cut:]
            said = [
                f"{in_digits(np.median(values[s]), 4)} {unit} in {_listed(each)}"
                for s, each in zip((slice(cut), slice(cut, None)), sides, strict=True)
            ]
            found[key] = (
                f"the {name} of the {key[2]} is {' and '.join(said)}, more apart than operations "
                "of one drive: are they of two drives, of two visits, or measured differently? "
                "They are not averaged"
            )
            break
    return found


def _of_shape(name: str) -> Callable[[Record], float]:
    return lambda each: getattr(each.shape, name)


def _names_differ(records: Sequence[Record]) -> list[str]:
    """What files state of their breaker where they differ in it, though no table names breakers."""
    found = []
    if any(each.operation.breaker for each in records):
        return found
    for name in ("serial", "bay", "type"):
        by: dict[str, list[Record]] = {}
        for each in records:
            if said := " ".join(getattr(each.stated, name).casefold().split()):
                by.setdefault(said, []).append(each)
        if len(by) > 1 and not (name == "serial" and _are_poles(records)):
            said = " and ".join(
                f"{getattr(some[0].stated, name)!r} in {_listed(some)}" for some in by.values()
            )
            word = {"serial": "serial numbers"}.get(name, f"{name}s")
            found.append(f"files state different {word}: {said}. Are they of one breaker?")
    return found


def _are_poles(records: Sequence[Record]) -> bool:
    """Whether each record of a motion is of a phase of its own, which may have its own number."""
    phases = [(each.motion, each.operation.phase) for each in records]
    return all(phase for _, phase in phases) and len({*phases}) == len(phases)


def _out_of_order(records: Sequence[Record]) -> list[str]:
    """Where numbers of operations rise while their dates fall."""
    found: dict[tuple[str, str], str] = {}
    rows = sorted(records, key=lambda each: (each.motion, each.operation.number))
    for one, other in pairwise(rows):
        first, second = date_of(one), date_of(other)
        same = one.motion == other.motion and one.operation.breaker == other.operation.breaker
        if same and one.operation.number < other.operation.number and falls(first, second):
            found.setdefault(
                (first, second),
                f"{_name(other)}, operation {other.operation.number}, is of {second}, before "
                f"{_name(one)}, operation {one.operation.number}, of {first}: are the numbers or "
                "the dates wrong?",
            )
    return list(found.values())[:_NAMED]


def falls(first: str, second: str) -> bool:
    """Say whether the second of two dates, as ISO 8601, is before the first; of one without a time
    the day alone counts.
    """
    length = min(len(first), len(second))
    return bool(length) and second[:length] < first[:length]


def visits_in_order(visits: Mapping[str, Sequence[Record]]) -> list[str]:
    """Say where the visit before is later than that of today."""
    dates = {
        visit: sorted(filter(None, (date_of(each) for each in records if not each.reason)))
        for visit, records in visits.items()
    }
    before, today = dates.values()
    if not (before and today and falls(before[0], today[-1])):
        return []
    return [
        f"the records of the visit before are of {before[0]}, and those of today of {today[-1]}, "
        "which is earlier: name the earlier visit first, or mend the dates. Changes are told from "
        "the first to the second as they are named"
    ]


def _name(record: Record, beside: Record | None = None) -> str:
    """Name of a record's file; its channel, where two records are of one file."""
    operation = record.operation
    file, channel = printable(operation.file), operation.phase or operation.channel
    same = beside is not None and beside.operation.file == operation.file
    return (f"channel {printable(channel)}" if channel else "itself") if same else file


def _listed(records: Sequence[Record]) -> str:
    """Names of files, the first few of them."""
    names = list(dict.fromkeys(_name(each).rpartition("/")[2] for each in records))
    more = f" and {len(names) - _NAMED} more" if len(names) > _NAMED else ""
    return ", ".join(names[:_NAMED]) + more
