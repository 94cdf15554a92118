"""Read dates in headers, in cells of tables and in names of files. Light to import.

A date such as 03/04/2026 has two readings; another date of the same column or folder decides.
"""

import re
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from datetime import UTC, date, datetime, time
from pathlib import Path

_YEAR = "((?:19|20)[0-9]{2})"
_DATE = re.compile(
    rf"(?<![0-9])(?:{_YEAR}([-_/.]?)([0-9]{{2}}|[0-9](?=[-_/.]))\2([0-9]{{1,2}})"
    rf"|([0-9]{{1,2}})([-_/.])([0-9]{{1,2}})\6{_YEAR})(?![0-9])"
)
_CLOCK = re.compile(
    r"(?<![0-9:.])([0-9]{1,2})[:h]([0-9]{2})(?::([0-9]{2})(?:[.,][0-9]+)?"
    r"(Z|[+-](?:0[0-9]|1[0-4]):?(?:00|30|45)(?![:0-9]))?)?\s*([ap]\.?m)?",
    re.IGNORECASE,
)


def dates_of(text: str) -> dict[bool, str]:
    """Return the readings of the only date in a text as ISO 8601; the key is True if the day is
    first.

    >>> dates_of("14/03/2021"), dates_of("2021-03-02")[False]
    ({True: '2021-03-14'}, '2021-03-02')
    """
    matches = _DATE.findall(text)
    if len(matches) != 1:
        return {}
    early, _, month, day, first, sign, second, late = matches[0]
    readings = {}
    for day_first in (True, False):
        # With points, the day comes first in the standards of all countries that use points.
        parts = (second, first) if day_first or sign == "." else (first, second)
        with suppress(ValueError):
            numbers = (early, month, day) if early else (late, *parts)
            readings[day_first] = date(*map(int, numbers)).isoformat()
    return readings


def clock_of(text: str) -> str:
    """Return the time of day in a text as ISO 8601, with a T before it; empty if there is none.

    >>> clock_of("2/3/2021 1:05 PM"), clock_of("02:10:00+01:00"), clock_of("400 ms")
    ('T13:05:00', 'T02:10:00+01:00', '')
    """
    for hour, minute, second, offset, half in _CLOCK.findall(text)[:1]:
        of_day = int(hour) % 12 + 12 * (half[0] in "pP") if half else int(hour)
        with suppress(ValueError):
            clock = f"{of_day:02}:{minute}:{second or '00'}{offset.upper()}"
            return f"T{time.fromisoformat(clock).isoformat()}"
    return ""


def day_order(dates: Iterable[Mapping[bool, str]]) -> bool | None:
    """Return whether the day is first, by dates with only one possible order; None if there are no
    such dates, or they contradict each other.
    """
    orders = {order for readings in dates if len(readings) == 1 for order in readings}
    return orders.pop() if len(orders) == 1 else None


def in_order(readings: Mapping[bool, str], order: bool | None = None) -> tuple[str, ...]:
    """Return the one or two readings of a date that an order of day and month allows."""
    kept = [readings[order]] if order in readings else readings.values()
    return tuple(dict.fromkeys(kept))


def cell_date(cell: str, order: bool | None = None) -> str:
    """Return the date, or date and time, in a cell as ISO 8601, by the column's order of day and
    month. Raise ValueError if the cell is not a date, or has two readings.
    """
    days, clock = in_order(dates_of(cell), order), clock_of(cell)
    rest = _DATE.sub("", cell)
    if (_CLOCK.sub("", rest, count=1) if clock else rest).strip(" ,T") or len(days) != 1:
        why = "not a date" if len(days) < 2 else f"{' or '.join(days)}; no other date decides"
        raise ValueError(f"{cell!r} is {why}; write it as 2024-11-20 or 2024-11-20T15:13:07")
    return days[0] + clock


def one_date(cell: str, stated: Sequence[str], file: str | Path) -> str:
    """Return the date of a record from its cell in the table, else from its header, else from the
    name of its file; "" without a date, or with two readings.
    """
    dates = [cell] if cell else stated or in_order(dates_of(Path(file).stem))
    return dates[0] if len(dates) == 1 else ""


def instant(when: str) -> datetime:
    """Return a date as an instant without offset: in UTC if an offset is stated, else unchanged."""
    moment = datetime.fromisoformat(when)
    return moment if moment.tzinfo is None else moment.astimezone(UTC).replace(tzinfo=None)


def earlier(first: str, second: str) -> bool:
    """Return whether the second of two ISO 8601 dates is on an earlier day than the first."""
    return bool(second) and second[:10] < first[:10]
