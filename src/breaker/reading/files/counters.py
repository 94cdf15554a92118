"""Counters of operations: as names say them, or else in the order of visits."""

from collections import Counter, defaultdict
from collections.abc import Mapping, Sequence
from datetime import datetime
from itertools import pairwise

from breaker.common.numerals import natural
from breaker.reading.files.date_text import earlier
from breaker.reading.files.file_facts import FoundFile, Row
from breaker.reading.files.file_names import numbers_in
from breaker.reading.files.operations_table import FILL_IN

_APART = 6 * 3600.0  # s, from which a file is of another visit, as dates alone are


def with_counters(rows: Sequence[Row]) -> tuple[list[tuple[int, Row]], list[str]]:
    """Return the operations of a breaker with their counters, and what to check of these.

    Files of one pole each are poles of the same operations. Where names say no counter, the first
    operations of a visit, in any motion and pole, are those after the last of the visit before.
    """
    groups: dict[tuple[str, str], list[Row]] = defaultdict(list)
    for row in rows:
        groups[row.motion, row.phase].append(row)
    said: dict[tuple[str, str, int], int] = {}
    for group in groups.values():
        numbers = numbers_in([row.file.stem for row in group])
        if all(isinstance(each, int) for each in numbers) and len({*numbers}) == len(numbers):
            said |= dict(zip(map(_key, group), numbers, strict=True))
    remarks, visits = [], _by_visits(rows)
    found = [(said.get(_key(row), visits[_key(row)]), row) for row in rows]
    if len(said) < len(rows):
        open_ = [row.file for row in rows if _key(row) not in said]
        name = "" if open_[0].breaker == FILL_IN else open_[0].breaker
        remarks.append(
            f"{name}: ".removeprefix(": ") + f"{len(open_)} operations are numbered from 1 in the "
            f"order of {_order(open_)}, as the names do not say the counter"
        )
    for key in groups:
        own = {n: row for n, row in found if (row.motion, row.phase) == key}
        remarks += _falling(dict(sorted(own.items())))
    return found, remarks


def _key(row: Row) -> tuple[str, str, int]:
    return row.file.path, row.motion, row.place


def _by_visits(rows: Sequence[Row]) -> dict[tuple[str, str, int], int]:
    """Counters in the order of dates, or else of the times of writing."""
    found: dict[tuple[str, str, int], int] = {}
    before, counts, last = 0, Counter(), ""
    dated = all(row.file.day not in ("", FILL_IN) for row in rows)
    for row in sorted(rows, key=lambda row: (_when(row.file), natural(row.file.path), row.place)):
        when = _when(row.file)
        if dated and last and _are_apart(last, when):
            before, counts = before + max(counts.values()), Counter()
        # Poles without a name have one operation each.
        poles = {p.phase if p.phase != FILL_IN else row.file.path for p in row.parts} or {""}
        keys = [(row.motion, pole) for pole in poles]
        number = max(counts[key] for key in keys) + 1
        counts.update({key: number - counts[key] for key in keys})
        found[_key(row)] = before + number
        last = when
    return found


def _when(file: FoundFile) -> str:
    """Date and time by which files are in order, as ISO 8601."""
    known = file.day not in ("", FILL_IN)
    return file.day if known else datetime.fromtimestamp(file.written).isoformat()


def _are_apart(one: str, other: str) -> bool:
    if "T" not in one or "T" not in other:
        return one[:10] != other[:10]
    first, second = (datetime.fromisoformat(each) for each in (one, other))
    return (second - first).total_seconds() > _APART


def _order(files: Sequence[FoundFile]) -> str:
    """By what files are in order, in words."""
    if any(file.day in ("", FILL_IN) for file in files):
        return "the times at which the files were written, where they have no date"
    stated = all(file.seen.preamble.dates for file in files)
    return "the dates that they state" if stated else "the dates in their names"


def _falling(rows: Mapping[int, Row]) -> list[str]:
    """Say where the dates of files fall while the numbers in their names rise."""
    for (first, one), (second, other) in pairwise(rows.items()):
        if FILL_IN not in (one.file.day, other.file.day) and earlier(one.file.day, other.file.day):
            return [
                f"the date of {other.file.path}, operation {second}, {other.file.day}, is earlier "
                f"than that of operation {first}, {one.file.day}: mend the numbers or the dates; "
                "the table is refused as it is"
            ]
    return []
