"""What files state of their records, that each counts once, and of one breaker.

Two records are equal if they have the same samples; a copy of a record counts once.
"""

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

from breaker.common.numerals import first_of, in_digits
from breaker.common.plain_values import Plain
from breaker.common.spellings import bare
from breaker.diagnosis.estimate import DriveRecord
from breaker.records.dates import earlier, instant, one_date
from breaker.records.files import printable
from breaker.records.words import channel_of, phase_in

_NAMED = 4  # files in a sentence
_SAME = 1e-6  # share to which two stated ratios are one


def without_copies(records: Sequence[DriveRecord]) -> list[DriveRecord]:
    """Return records; a copy of an earlier one is rejected with the reason."""
    found, first = [], {}
    for each in records:
        if not each.reason:
            of = first.setdefault(samples_of(each), each)
            if _place(of) != _place(each):
                reason = f"{_name(each)} holds the same samples as {_name(of, each)}"
                reason += ": they count once"
                each = replace(each, reason=reason, raw=None, shape=None, seen=None)
        found.append(each)
    return found


def samples_of(record: DriveRecord) -> tuple[str, bytes]:
    """Return the motion of a usable record and its samples, which are alike for copies."""
    return record.motion, record.raw.left.tobytes()


def _place(record: DriveRecord) -> tuple[str, str]:
    """File and channel of a record."""
    return str(record.operation.file), record.operation.channel


def doubts_about(records: Sequence[DriveRecord]) -> list[str]:
    """Return warnings where files contradict how they were read, or state several breakers."""
    said = [each.raw.warning for each in records if each.raw and each.raw.warning]
    said += _names_differ([each for each in records if not each.reason])
    return list(dict.fromkeys(said))


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


def visits_in_order(visits: Mapping[str, Sequence[DriveRecord]]) -> list[str]:
    """Return a warning where the visit before is later than that of today."""
    dates = {
        visit: sorted(
            filter(None, (date_of(each) for each in records if not each.reason)), key=instant
        )
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


def date_of(record) -> str:
    """Return the date of a record as ISO 8601: of its table, or else as its file states it; empty
    where neither does, or day and month may be either.
    """
    return one_date(record.operation.date, record.stated.dates, "")


def dates_in_words(records: Iterable) -> str:
    """Return the days of a visit, the first and the last, both readings of a day and month that may
    be either; empty where nothing states any.
    """
    days = {
        date_of(each)[:10] or " or ".join(day[:10] for day in each.stated.dates) for each in records
    }
    days = sorted(filter(None, days))
    return " to ".join(dict.fromkeys([*days[:1], *days[-1:]]))


def stated_of(records: Iterable) -> dict[str, float | str]:
    """Return what files state of a visit by what it is called: the ratio of the linkage, serial
    number, bay, phase and channel; what they do not, or differently, is left out.
    """
    found: dict[str, set] = {}
    for each in records:
        said = {"linkage ratio": each.stated.ratio, "serial number": each.stated.serial}
        said |= {"bay": each.stated.bay, "phase": _phase(each), "channel": _channel(each)}
        for name, value in said.items():
            if value and value == value:
                found.setdefault(name, set()).add(value)
    return {name: values.pop() for name, values in found.items() if len(values) == 1}


@dataclass(frozen=True)
class Difference(Plain):
    """In what two visits were measured differently: what it is, its unit and motion, empty of all,
    and its value at each visit.
    """

    what: str
    unit: str
    motion: str
    before: float | str
    today: float | str

    @property
    def words(self) -> str:
        """The difference in a sentence."""
        of = f"the {self.what}{' of' * bool(self.motion)} {self.motion}".rstrip()
        was, now = (
            f"{each if isinstance(each, str) else in_digits(each, 4)} {self.unit}".rstrip()
            for each in (self.before, self.today)
        )
        return f"{of} was {was} and is {now}"


def stated_differences(visits: Mapping[str, Sequence[DriveRecord]]) -> list[Difference]:
    """Return in what the files of two visits state different things."""
    first, second = (stated_of(records) for records in visits.values())
    both = [name for name in first if name in second and _differ(first[name], second[name])]
    return [Difference(name, "", "", first[name], second[name]) for name in both]


def _differ(first: float | str, second: float | str) -> bool:
    """Whether two stated things are not the same."""
    if isinstance(first, str):
        return first.casefold().split() != second.casefold().split()
    return abs(second - first) > _SAME * first


def _channel(record) -> str:
    """Number of a record's channel among those of the same name; empty where it has none."""
    column = record.operation.channel or (
        record.raw.settings["travel_column"] if record.raw else ""
    )
    number = re.fullmatch(r"(\D*[^\W\d_])[\W_]*(\d)\W*", str(column))
    return f"{number[1].casefold()} {number[2]}" if number else ""


def _phase(record) -> str:
    """Phase of a record's channel, by its name or its number."""
    phases, operation = record.stated.phases, record.operation
    column = operation.channel or str(record.raw.settings["travel_column"] if record.raw else "")
    return phase_in(column) or phases.get(channel_of(column), phases.get(0, ""))
