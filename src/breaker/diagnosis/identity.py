"""Statements of files about their breaker: nameplate, dates, phases, and printed values.

Records are compared by the phases that tables, files or names state, and never by the number of a
channel or transducer.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from math import isnan

from breaker.common.document import Cell
from breaker.common.numerals import first_of, in_digits
from breaker.common.plain_values import Plain
from breaker.common.text import bare
from breaker.common.wording import Sentence
from breaker.diagnosis.estimate import DriveRecord
from breaker.diagnosis.reading import stated_phase
from breaker.diagnosis.words import say
from breaker.model.quantities import Speed
from breaker.records.dates import earlier
from breaker.records.files import printable
from breaker.records.header import stated_as
from breaker.records.printed import meant_motions, measured_name, stated_speeds
from breaker.records.words import channel_of, phase_in

_OF_BREAKER = ("station", "bay", "type", "serial")
_OF_TEST = ("Gas pressure", "Temperature", "Operator")

Inspections = Mapping[str, Sequence[DriveRecord]]
"""Records "before" and "today"."""


def contradictions(records: Iterable[DriveRecord]) -> list[Sentence]:
    """Return where files state different serial numbers, bays or types of their breaker.

    Poles may have serial numbers of their own; where a table names the breaker, it is right.
    """
    usable, found = [record for record in records if not record.reason], []
    for name in ("serial", "bay", "type"):
        stated = {bare(value): value for e in usable if (value := getattr(e.stated, name))}
        poles = {(phase_of(record), bare(getattr(record.stated, name))) for record in usable}
        phases = {phase for phase, _ in poles} - {""}
        own = name == "serial" and len(poles) == len(phases)
        if len(stated) > 1 and not own and not any(e.operation.breaker for e in usable):
            found.append(say(f"{name}-differs", values=" and ".join(sorted(stated.values()))))
    return found


def doubts_about(records: Sequence[DriveRecord]) -> list[str]:
    """Return warnings where files contradict how they were read, or state several breakers."""
    read = [record.raw.warning for record in records if record.raw and record.raw.warning]
    return list(dict.fromkeys([*read, *contradictions(records)]))


def check_inspection(records: Sequence[DriveRecord], before: Sequence[DriveRecord]) -> None:
    """Raise a ValueError for an inspection without a usable record, or of several breakers."""
    for code, some in (("nothing-usable", records), ("nothing-usable-before", before)):
        if some and all(record.reason for record in some):
            reasons = "\n  ".join(dict.fromkeys(record.reason for record in some))
            raise ValueError(say(code, reasons=reasons))
    if doubts := [doubt for doubt in contradictions(records) if doubt.code != "type-differs"]:
        raise ValueError(say("report-of-several", doubt=doubts[0]))


def days_of(records: Iterable[DriveRecord]) -> str:
    """Return the first and the last day of an inspection; "" where no date is known."""
    days = sorted({record.operation.date[:10] for record in records} - {""})
    return " to ".join(dict.fromkeys([*days[:1], *days[-1:]]))


def order_doubts(inspections: Inspections) -> list[Sentence]:
    """Return a warning where the inspection "before" is later than that of "today"."""
    dates = [
        sorted(e.operation.date for e in some if e.operation.date and not e.reason)
        for some in inspections.values()
    ]
    if not (all(dates) and earlier(dates[0][0], dates[1][-1])):
        return []
    return [say("before-is-later", before=dates[0][0], today=dates[1][-1])]


def phase_of(record: DriveRecord) -> str:
    """Return the phase that the table, the file or its name states; "" where none does.

    In a report a channel without a phase is called by its column, which is not a phase.
    """
    operation = record.operation
    if operation.phase and operation.phase != str(operation.channel):
        return operation.phase
    usual = record.raw.settings["travel_column"] if record.raw else ""
    return stated_phase(record.stated, operation.channel or usual)


def check_phases(inspections: Inspections) -> list[Sentence]:
    """Return a remark (``phase-not-stated``) where records of no stated phase are compared.

    Raises:
        ValueError: If usable records state several phases, or several channels state none.
    """
    used = {name: [e for e in some if not e.reason] for name, some in inspections.items()}
    for some in used.values():
        if len({record.operation.channel for record in some if not phase_of(record)}) > 1:
            raise ValueError(say("phases-needed"))
    phases = {name: {phase_of(record) for record in some} - {""} for name, some in used.items()}
    words = {name: ", ".join(sorted(some)) or "no phase" for name, some in phases.items()}
    if len(set().union(*phases.values())) > 1:
        several = any(len(some) > 1 for some in phases.values())
        raise ValueError(say("several-phases" if several else "different-phases", **words))
    every = (record for some in used.values() for record in some)
    known = all(phase_of(record) or record.operation.breaker for record in every)
    return [] if known else [say("phase-not-stated", **words)]


@dataclass(frozen=True)
class Difference(Plain):
    """Something that was measured differently at two inspections.

    Attributes:
        what, unit, motion: Its name, unit and motion; the motion is empty if it is of all.
        before, today: Its value at either inspection.
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
            f"{value if isinstance(value, str) else in_digits(value, 4)} {self.unit}".rstrip()
            for value in (self.before, self.today)
        )
        return f"{of} was {was} and is {now}"


def stated_differences(inspections: Inspections) -> list[Difference]:
    """Return in which ratio, serial number or bay the files of two inspections differ."""
    found = []
    for name, key in {"linkage ratio": "ratio", "serial number": "serial", "bay": "bay"}.items():
        both = [{getattr(e.stated, key) for e in some} for some in inspections.values()]
        before, today = ([value for value in each if value and value == value] for each in both)
        if len(before) == len(today) == 1 and _as_stated(before[0]) != _as_stated(today[0]):
            found.append(Difference(name, "", "", before[0], today[0]))
    return found


def _as_stated(value: float | str) -> str:
    """Return a number as texts round it, or a name in any spelling."""
    return bare(value) if isinstance(value, str) else in_digits(value, 6)


def nameplate(
    records: Sequence[DriveRecord], before: Sequence[DriveRecord] = ()
) -> list[tuple[str, str | Cell]]:
    """Return nameplate and test as far as tables and files state them, as rows of a report."""
    rows, stated = [e.operation for e in records], [e.stated for e in records]
    read = (e.operation for e in records if not e.reason)
    files = dict.fromkeys(printable(e.file).rpartition("/")[2] for e in read)
    known = {
        "Breaker": [e.breaker for e in rows if e.breaker] or [e.serial for e in stated],
        "Test date": [e.date for e in rows],
        "Earlier inspection": [days_of(before)],
        "Files": [first_of([*files], 1)],
        **{name.title(): [getattr(e, name) for e in stated] for name in _OF_BREAKER},
        "Linkage ratio": [in_digits(e.ratio, 6) for e in stated if not isnan(e.ratio)],
    }
    for name in _OF_TEST:
        pairs = [pair for e in stated for pair in stated_as(e.pairs, name)[:1]]
        known[name] = [f"{pair.text} {pair.unit}".rstrip() for pair in pairs]
    degrees = [f"{in_digits(e.temperature, 4)} °C" for e in rows if not isnan(e.temperature)]
    known["Temperature"] = degrees or known["Temperature"]
    known["Contacts"] = [str(e.settings.get("contact_column") or "") for e in rows]
    always = {"Breaker", "Test date", *(["Earlier inspection"] if before else [])}
    pairs = [(name, ", ".join(filter(None, dict.fromkeys(e)))) for name, e in known.items()]
    lacking = Cell("not stated", "faint")
    return [(name, text or lacking) for name, text in pairs if text or name in always]


def printed_values(
    records: Sequence[DriveRecord], speeds: Sequence[Speed]
) -> dict[tuple[str, str, str, str], tuple[float, str, str]]:
    """Return values that the analyser printed, by file, motion, phase and quantity.

    A channel of a printed value is its phase, or else its place among those of the file. The value
    stands with how its definition differs, and with its quantity.
    """
    defined, found = {speed.name: speed for speed in speeds}, {}
    for file, stated in {str(e.operation.file): e.stated for e in records}.items():
        own = [record for record in records if str(record.operation.file) == file]
        phases = list(dict.fromkeys(record.operation.phase for record in own))
        zones = stated_speeds(stated)
        for printed in stated.results:
            phase = phase_in(printed.channel) or printed.channel
            place = channel_of(printed.channel) - 1
            if phase not in phases and 0 <= place < len(phases):
                phase = phases[place]
            for motion in meant_motions(printed, (record.motion for record in own)):
                name = measured_name(printed, motion)
                other = printed.speed(motion, zones) != defined.get(name)
                other = other and printed.quantity == "speed"
                if name and not isnan(printed.size):
                    value = printed.value * printed.size, "other points" * other, printed.quantity
                    found.setdefault((printable(file), motion, phase, name), value)
    return found
