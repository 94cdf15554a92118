"""The drives of a fleet: each phase of each breaker, its operations and its visits."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from datetime import timedelta
from typing import NamedTuple

from breaker.records.dates import instant, one_date
from breaker.records.files import Files
from breaker.records.formats.registry import stated_in
from breaker.records.operations import Operation
from breaker.records.settings import FORMAT

_APART = timedelta(days=30)  # between records, from which these are of another visit


class Member(NamedTuple):
    """A drive of a fleet.

    Attributes:
        breaker, phase, type: Names; empty where they are not known.
        operations: By motion, in the order of their numbers.
    """

    breaker: str
    phase: str
    type: str
    operations: Mapping[str, Sequence[Operation]]

    @property
    def numbers(self) -> list[int]:
        """Numbers of its operations, rising."""
        return sorted({each.number for some in self.operations.values() for each in some})

    @property
    def dates(self) -> dict[int, str]:
        """Date of each operation that has one, by its number."""
        rows = (each for some in self.operations.values() for each in some if each.date)
        return {each.number: each.date for each in rows}

    def visits(self) -> list[list[int]]:
        """Return the numbers of the operations of each visit; those without a date stay together.

        >>> dated = {1: "2012-05-01", 2: "2012-05-02", 9: "2026-03-01"}
        >>> rows = [Operation(n, "a.csv", date=date) for n, date in dated.items()]
        >>> Member("Q1", "", "", {"closing": rows}).visits()
        [[1, 2], [9]]
        """
        found: list[list[int]] = []
        dates, last = self.dates, None
        for number in self.numbers:
            day = instant(dates[number]) if number in dates else last
            if not found or (last and day - last > _APART):
                found.append([])
            found[-1].append(number)
            last = day
        return found

    def only(self, numbers: Iterable[int]) -> dict[str, list[Operation]]:
        """Return operations of these numbers, by motion."""
        wanted = set(numbers)
        some = {m: [e for e in each if e.number in wanted] for m, each in self.operations.items()}
        return {motion: each for motion, each in some.items() if each}


def members_of(
    rows: Mapping[str, Sequence[tuple[str, Operation]]],
    motions: Sequence[str],
    settings: Mapping = FORMAT,
) -> list[Member]:
    """Return the drives of breakers, one for each phase.

    Args:
        rows: Motion and operation of each row, by breaker, as of ``folder.list_fleet``. Where the
            table has no date, that of the header or of the name of the file counts.
        motions: Those that are looked at. Where the table names no type, it is that which stands
            above the samples.
        settings: The section ``endurance.format``.
    """
    found, files = [], Files()
    for breaker, of in rows.items():
        for phase in dict.fromkeys(each.phase for _, each in of):
            own = [pair for pair in of if pair[1].phase == phase and pair[0] in motions]
            if not own:
                continue
            each = {m: [_dated(e, settings, files) for of_, e in own if of_ == m] for m in motions}
            each = {m: sorted(some, key=lambda e: e.number) for m, some in each.items() if some}
            named = next((e.type for _, e in own if e.type), "")
            last = own[-1][1]
            named = named or stated_in(files[last.file], settings, last.channel).type
            found.append(Member(breaker, phase, named, each))
    return found


def _dated(operation: Operation, settings: Mapping, files: Files) -> Operation:
    """Return an operation with its one date."""
    if operation.date:
        return operation
    stated = stated_in(files[operation.file], settings, operation.channel)
    return replace(operation, date=one_date("", stated.dates, operation.file))
