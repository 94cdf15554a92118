"""Whether records are what they are taken for: of one drive and visit, each once, in their order.

What is found is said before anything else; copies count once, and records of several drives have no
common mean.

Two records are one with the same samples, or if one is an export of the other with other decimals,
another zero, a part cut off, or every second sample. Noise never repeats itself: two operations
differ by the noise of both at least.
"""

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise, permutations
from typing import NamedTuple

import numpy as np

from breaker.common.numerals import first_of, in_digits
from breaker.drive.answers.evidence import DriveRecord
from breaker.drive.answers.file_statements import date_of
from breaker.reading.files.date_text import earlier
from breaker.reading.files.guards import printable
from breaker.reading.files.word_meanings import bare
from breaker.reading.records.motion import LocatedMotion, white_noise

_WHOLE = 0.05  # of a sample, by which the steps of two exports may differ
_LAGS = 3  # samples about the lag that first motions tell, that are tried
_COPIED = 0.4  # of the noise of both, up to which what two records differ by is none
_FEWEST = 100  # samples that both have
_MOST = 200  # records of a motion, of more than which only equal samples are looked for
_NEAR = 0.7  # of the noise of both, by which the shapes of copies differ at most
# Shares by which neighbours differ, of records in their order, that are of two drives.
_APART = {"stroke": (0.03, "mm"), "duration": (0.25, "ms")}
_SDS = 6.0  # of the noise, by which they differ as well
_NAMED = 4  # files in a sentence
# A gap so many times as wide as others, with two records or more on either side, is none of chance.
_CLUSTERS, _LEAST = 5.0, {"stroke": 0.018, "duration": 0.03}
_POLES = 6  # of a breaker, that may be swapped
_SWAPPED = 25.0  # by which what swapped phases leave is less, in squares of sds
_SCATTER = 0.005  # of strokes, durations and shapes, usual from visit to visit


def is_copy(one: LocatedMotion, other: LocatedMotion) -> bool:
    """Say whether two records of a motion hold the same samples.

    Example:
        >>> import numpy as np
        >>> from types import SimpleNamespace
        >>> rng, time = np.random.default_rng(1), 0.1 * np.arange(600)
        >>> way = 14.0 * np.clip((time - 20.0) / 10.0, 0.0, 1.0)
        >>> first, again = (way + 0.05 * rng.standard_normal(600) for _ in range(2))
        >>> def record(samples, every=1):
        ...     return SimpleNamespace(
        ...         left=samples[::every], step=0.1 * every, moves=20.0, time=time[::every],
        ...         inside=slice(None)
        ...     )
        >>> [is_copy(record(first), record(each, 2)) for each in (0.5 + first.round(2), again)]
        [True, False]
    """
    fine, coarse = sorted((one, other), key=lambda each: each.step)
    every = coarse.step / fine.step
    if abs(every - round(every)) > _WHOLE:
        return False
    every = round(every)
    noise = np.hypot(*(white_noise(each.left) for each in (fine, coarse)))
    starts = [
        round((each.moves - float(each.time[each.inside][0])) / each.step)
        for each in (fine, coarse)
    ]
    near = starts[0] - every * starts[1]
    for lag in range(near - _LAGS * every, near + _LAGS * every + 1):
        first = max(0, -(lag // every))  # of the coarse one, that the fine one has
        count = min(coarse.left.size - first, -(-(fine.left.size - lag) // every) - first)
        if count < _FEWEST:
            continue
        part = fine.left[lag + every * first :: every][:count]
        off = part - coarse.left[first : first + count]
        off = off[~np.isnan(off)]
        if off.size >= _FEWEST and off.std() <= _COPIED * noise:
            return True
    return False


def without_copies(records: Sequence[DriveRecord]) -> list[DriveRecord]:
    """Return records, of which copies of an earlier one cannot be used, each with the reason."""
    found, first = [], {}
    for each in records:
        of = None if each.reason else _copied(each, first.setdefault(each.motion, _Seen([], {})))
        if of is not None:
            reason = f"{_name(each)} holds the same samples as {_name(of, each)}: they count once"
            each = replace(each, reason=reason, raw=None, shape=None, seen=None)
        found.append(each)
    return found


class _Seen(NamedTuple):
    """Records of a motion so far, and these by their samples."""

    records: list[DriveRecord]
    samples: dict[bytes, DriveRecord]


def _copied(record: DriveRecord, seen: _Seen) -> DriveRecord | None:
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


def copies(one: DriveRecord, other: DriveRecord) -> bool:
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


def _place(record: DriveRecord) -> tuple[str, str]:
    """File and channel of a record."""
    return str(record.operation.file), record.operation.channel


def doubts_about(records: Sequence[DriveRecord]) -> list[str]:
    """Say what files state against how they were read, and what speaks against records being of
    one drive, in the order of their numbers.
    """
    said = [each.raw.warning for each in records if each.raw and each.raw.warning]
    usable = [each for each in records if not each.reason]
    said += [*_names_differ(usable), *mixed(usable).values(), *_out_of_order(usable)]
    return list(dict.fromkeys(said))


def mixed(records: Sequence[DriveRecord]) -> dict[tuple[str, str, str], str]:
    """Return why records of a breaker, phase and motion are not of one drive, where they are not:
    neighbours in their order differ by more than operations of a drive do.
    """
    groups: dict[tuple[str, str, str], list[DriveRecord]] = {}
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
            cut = int(gaps.argmax()) + 1 if gaps.size else 0
            apart = bool(cut) and gaps.max() > max(share, _SDS * noise)
            if not (apart or (cut and _two_clusters(gaps, cut, _LEAST[name]))):
                continue
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


def _two_clusters(gaps: np.ndarray, cut: int, least: float) -> bool:
    """Whether the widest gap between values in their order has clusters on either side."""
    others = np.delete(gaps, cut - 1)
    wide = gaps[cut - 1] > max(least, _CLUSTERS * others.max(initial=0.0))
    return bool(wide) and min(cut, len(gaps) + 1 - cut) > 1


def _of_shape(name: str) -> Callable[[DriveRecord], float]:
    return lambda each: getattr(each.shape, name)


def _names_differ(records: Sequence[DriveRecord]) -> list[str]:
    """What files state of their breaker where they differ in it, though no table names breakers."""
    found = []
    if any(each.operation.breaker for each in records):
        return found
    for name in ("serial", "bay", "type"):
        by: dict[str, list[DriveRecord]] = {}
        for each in records:
            said = getattr(each.stated, name)
            if said := bare(said) if name == "type" else "".join(said.casefold().split()):
                by.setdefault(said, []).append(each)
        if len(by) > 1 and not (name == "serial" and _are_poles(records)):
            said = " and ".join(
                f"{getattr(some[0].stated, name)!r} in {_listed(some)}" for some in by.values()
            )
            word = {"serial": "serial numbers"}.get(name, f"{name}s")
            found.append(f"files state different {word}: {said}. Are they of one breaker?")
    return found


def _are_poles(records: Sequence[DriveRecord]) -> bool:
    """Whether each record of a motion is of a phase of its own, which may have its own number."""
    phases = [(each.motion, each.operation.phase) for each in records]
    return all(phase for _, phase in phases) and len({*phases}) == len(phases)


def _out_of_order(records: Sequence[DriveRecord]) -> list[str]:
    """Where numbers of operations, of a table or in names, rise while their dates fall."""
    found: dict[tuple[str, str], str] = {}
    rows = [each for each in records if each.operation.date or _is_numbered(each)]
    rows.sort(key=lambda each: (each.motion, each.operation.number))
    for one, other in pairwise(rows):
        first, second = date_of(one), date_of(other)
        same = one.motion == other.motion and one.operation.breaker == other.operation.breaker
        if same and one.operation.number < other.operation.number and earlier(first, second):
            found.setdefault(
                (first, second),
                f"the date of {_name(other)}, operation {other.operation.number}, {second}, is "
                f"earlier than that of operation {one.operation.number}, {first}: are the numbers "
                "or the dates wrong?",
            )
    return list(found.values())[:_NAMED]


def _is_numbered(record: DriveRecord) -> bool:
    """Whether the number of an operation is one in the name of its file, and not of its place."""
    digits = re.findall(r"\d+", _name(record).rpartition("/")[2])
    return record.operation.number in map(int, digits)


def visits_in_order(visits: Mapping[str, Sequence[DriveRecord]]) -> list[str]:
    """Say where the visit before is later than that of today."""
    dates = {
        visit: sorted(filter(None, (date_of(each) for each in records if not each.reason)))
        for visit, records in visits.items()
    }
    before, today = dates.values()
    if not (before and today and earlier(before[0], today[-1])):
        return []
    return [
        f"the records of today are of {today[-1]}, which is earlier than those of the visit "
        f"before, of {before[0]}: name the earlier visit first, or mend the dates. Changes are "
        "told from the first to the second as they are named"
    ]


def swapped(before: Sequence[DriveRecord], today: Sequence[DriveRecord]) -> str:
    """Say which phases are likely swapped between two visits; "" if none are: all are then far more
    like one another of before than like themselves.
    """
    visits = [_poles(visit) for visit in (before, today)]
    phases = sorted(visits[0].keys() & visits[1].keys() - {""})
    if not 2 <= len(phases) <= _POLES:
        return ""
    off = np.array([[_off(visits[0][p], visits[1][q]) for q in phases] for p in phases])
    ways = list(permutations(range(len(phases))))
    left = [off[way, range(len(phases))].sum() for way in ways]
    best = int(np.argmin(left))
    if not left[0] - left[best] > _SWAPPED or left[best] > 0.5 * left[0]:
        return ""
    pairs = [(phases[i], phases[k]) for k, i in enumerate(ways[best]) if i != k]
    said = ", ".join(f"{now} of today looks like {then} of before" for then, now in pairs)
    return f"phases may be swapped between the visits: {said}. Check names of channels and leads"


def _poles(records: Sequence[DriveRecord]) -> dict[str, dict[str, DriveRecord]]:
    """First usable record of each motion of each phase."""
    found: dict[str, dict[str, DriveRecord]] = {}
    for each in records:
        if not each.reason:
            found.setdefault(each.operation.phase, {}).setdefault(each.motion, each)
    return found


def _off(before: Mapping[str, DriveRecord], today: Mapping[str, DriveRecord]) -> float:
    """Squares of what motions of two poles differ by, in their usual scatter."""
    total = 0.0
    for motion in before.keys() & today.keys():
        one, other = before[motion].shape, today[motion].shape
        logs = np.log([one.stroke / other.stroke, one.duration / other.duration])
        total += float(np.square(logs / _SCATTER).sum())
    return total


def _name(record: DriveRecord, beside: DriveRecord | None = None) -> str:
    """Name of a record's file; its channel, where two records are of one file."""
    operation = record.operation
    file, channel = printable(operation.file), operation.phase or operation.channel
    same = beside is not None and beside.operation.file == operation.file
    return (f"channel {printable(channel)}" if channel else "itself") if same else file


def _listed(records: Sequence[DriveRecord]) -> str:
    """Names of files, the first few of them."""
    names = list(dict.fromkeys(_name(each).rpartition("/")[2] for each in records))
    return first_of(names, _NAMED)
