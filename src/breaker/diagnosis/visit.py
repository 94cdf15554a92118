"""A visit to one breaker: its records, what files state of it, and what has changed since."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import isnan

from breaker.common.numerals import first_of, in_digits
from breaker.common.parts import Cell, Letterhead
from breaker.diagnosis.change_table import NotCompared
from breaker.diagnosis.estimate import DriveRecord
from breaker.diagnosis.identity import dates_in_words
from breaker.diagnosis.inspection_change import InspectionChange
from breaker.diagnosis.overlay import Overlay
from breaker.diagnosis.session import Diagnosis
from breaker.records.files import printable, read_bytes
from breaker.records.header import Header, stated_as
from breaker.records.printed import meant_motions, measured_name, stated_speeds
from breaker.records.words import channel_of, phase_in

_PNG = b"\x89PNG\r\n\x1a\n"
_OF_BREAKER = ("station", "bay", "type", "serial")  # what a file may state of its breaker
_OF_TEST = ("Gas pressure", "Temperature", "Operator")  # what it may state of the test
_ALWAYS = ("Breaker", "Test date")  # rows of the nameplate that say so where nothing is stated


@dataclass(frozen=True, eq=False)
class Visit:
    """What was read of a visit.

    Attributes:
        assessment: What infers and judges the records.
        records, before: Records of the visit, and of the one before.
        overlays: Records over a good one.
        words: What is given beside the records, in words.
    """

    assessment: Diagnosis
    records: Sequence[DriveRecord]
    before: Sequence[DriveRecord] = ()
    overlays: Sequence[Overlay] = ()
    words: Sequence[str] = ()

    @property
    def stated(self) -> dict[str, Header]:
        """What stands above the samples, by file."""
        return {str(each.operation.file): each.stated for each in self.records}

    @property
    def plate(self) -> list[tuple[str, str]]:
        """Nameplate and test, as far as tables and files state them."""
        rows = [each.operation for each in self.records]
        stated = self.stated.values()
        files = dict.fromkeys(each.operation.file for each in self.records if not each.reason)
        temperatures = [in_digits(e.temperature, 4) for e in rows if not isnan(e.temperature)]
        facts = self.assessment.given.known.items()
        known = {
            "Breaker": [e.breaker for e in rows if e.breaker] or [e.serial for e in stated],
            "Test date": [e.operation.date or " or ".join(e.stated.dates) for e in self.records],
            "Visit before": [dates_in_words(self.before)],
            "Files": [first_of([printable(file).rpartition("/")[2] for file in files], 1)],
            **{name.title(): [getattr(e, name) for e in stated] for name in _OF_BREAKER},
            "Linkage ratio": [in_digits(e.ratio, 6) for e in stated if not isnan(e.ratio)],
            **{name: [_stated(each, name) for each in stated] for name in _OF_TEST},
            **({"Temperature": [f"{e} °C" for e in temperatures]} if temperatures else {}),
            "Channels": [each.phase for each in rows],
            "Contacts": [str(each.settings.get("contact_column") or "") for each in rows],
            "Motions": [each.motion for each in self.records],
            "Given": self.words,
            "Known": [f"{name} {mean:g} with an sd of {sd:g}" for name, (mean, sd) in facts],
        }
        always = (*_ALWAYS, "Visit before") if self.before else _ALWAYS
        pairs = [(name, ", ".join(filter(None, dict.fromkeys(e)))) for name, e in known.items()]
        lacking = Cell("not stated", "faint")
        return [(name, text or lacking) for name, text in pairs if text or name in always]

    @property
    def printed(self) -> dict[tuple[str, str, str, str], tuple[float, str, str]]:
        """What the analyser printed, by file, motion, channel and quantity: the value, what differs
        in its definition, and what the analyser means by it.

        A channel is meant by its phase, or else by its number among those of the file.
        """
        speeds = {each.name: each for each in self.assessment.speeds_of(self.records)}
        found = {}
        for file, preamble in self.stated.items():
            own = [each for each in self.records if str(each.operation.file) == file]
            phases = list(dict.fromkeys(each.operation.phase for each in own))
            own_speeds = stated_speeds(preamble)
            for each in preamble.results:
                place, phase = channel_of(each.channel) - 1, phase_in(each.channel) or each.channel
                if phase not in phases and 0 <= place < len(phases):
                    phase = phases[place]
                for motion in meant_motions(each, (record.motion for record in own)):
                    name = measured_name(each, motion)
                    odd = each.quantity == "speed"
                    odd = odd and each.speed(motion, own_speeds) != speeds.get(name)
                    if name and not isnan(each.size):
                        value = each.value * each.size, "other points" * odd, each.quantity
                        found.setdefault((printable(file), motion, phase, name), value)
        return found

    @property
    def changes(self) -> dict[str, InspectionChange | NotCompared]:
        """The comparison with the visit before, by channel.

        One channel in each visit is the same where a visit does not name it.
        """
        if not self.before:
            return {}
        unjudged = replace(self.assessment, limits=())
        rejected = [each.reason for each in self.before if each.reason]
        there = {each.operation.phase for each in self.before}
        phases = list(dict.fromkeys(each.operation.phase for each in self.records))
        alone = len(there) == len(phases) == 1 and not all([*there, *phases])
        found = {}
        for phase in phases:
            before = [e for e in self.before if alone or e.operation.phase == phase]
            today = [e for e in self.records if e.operation.phase == phase]
            lacks = "" if before else f"the visit before has no channel {phase}".rstrip()
            try:
                if not lacks:
                    found[phase] = unjudged.compare({"before": before, "today": today})
            except ValueError as error:
                lacks = str(error).splitlines()[0]
            if lacks:
                found[phase] = NotCompared([*rejected, lacks])
        return found

    @property
    def letterhead(self) -> Letterhead:
        """What the section ``report`` of the configuration puts around the report."""
        settings: Mapping = self.assessment.config["report"]
        lines = [f"{who}: name, date" for who in settings["signatures"]]
        logo = read_logo(settings["logo"]) if settings["logo"] else b""
        return Letterhead(settings["company"] or "", logo, settings["remarks"] or "", lines)


def read_logo(file: str) -> bytes:
    """Return the content of a logo.

    Raises:
        ValueError: If it cannot be read or is not a PNG file.
    """
    try:
        logo = read_bytes(file)
    except ValueError as error:
        raise ValueError(f"report.logo: {error}") from error
    if not logo.startswith(_PNG):
        raise ValueError(f"report.logo: {file} is not a PNG file; convert it to one")
    return logo


def check_visit(visit: Visit) -> None:
    """Refuse a visit of which nothing can be used, or whose files name different breakers.

    Poles of one breaker may have numbers of their own, but one bay.

    Raises:
        ValueError: If it is one of these.
    """
    for what, records in (("record", visit.records), ("record of the visit before", visit.before)):
        if records and all(each.reason for each in records):
            reasons = "\n  ".join(dict.fromkeys(each.reason for each in records))
            raise ValueError(f"no {what} can be used; breaker inspect FILE says how:\n  {reasons}")
    stated = [each.stated for each in visit.records]
    for name, beside in (("serial", "bay"), ("bay", "serial")):
        named, same = ({getattr(each, of) for each in stated} for of in (name, beside))
        if len(named - {""}) > 1 and (len(same) > 1 or not all(same)):
            raise ValueError(
                f"a report is of one breaker, and the files state {name} "
                f"{' and '.join(sorted(named - {''}))}; write one report of each"
            )


def _stated(stated: Header, name: str) -> str:
    """Return what a file states of a test, with its unit; "" where it states nothing."""
    found = stated_as(stated.pairs, name)
    return next((f"{each.text} {each.unit}".rstrip() for each in found), "")
