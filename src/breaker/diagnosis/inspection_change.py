"""The comparison of two visits as one document, and in words.

Words, table, JSON, figure and test report are renderings of it. docs/usage.md explains the keys of
the JSON. A number that is not known is None.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

from breaker.common.document import Document, Remark, Section, Table
from breaker.common.numerals import in_digits, in_p
from breaker.common.plain_values import Plain, plainly
from breaker.diagnosis.changes import (
    VERDICT_WORDS,
    NetworkChanges,
    QuantityChange,
    changes,
    mechanism_changes,
)
from breaker.diagnosis.explanations import Explanation, in_words
from breaker.diagnosis.identity import Difference
from breaker.diagnosis.limits import Verdict
from breaker.diagnosis.tables import limits_table
from breaker.diagnosis.words import say
from breaker.family.networks import CHANGE_OF
from breaker.family.untold import APART, BEYOND, LOOK, UNLIKE, WITHHELD, as_sentence

_NAME = "{:<28}{:>8} {:>8}"
_ROW = "  {:<45} {:>8}  {:<15}{:>7} {:>6} {:>7}"
_GROUPS = {"measured": "measured", "parameter": "inferred"}  # titles, where one begins
_CHANCE = 0.05  # probability of no change, below which records as a whole have changed
_WORSE = 0.5  # probability from which on a change is one to the worse
_NOT_TOLD = {
    "unlike": f"No change of the drive is told: {UNLIKE}",
    "withheld": f"Parameters are withheld: {WITHHELD}",
    "beyond": f"No parameter is told: {BEYOND}",
    "apart": f"No parameter is told: {APART}",
}


@dataclass(frozen=True)
class VisitMatch(Plain):
    """How a visit is like the drives of a family: as a whole, and by part of its motion."""

    p_value: float
    parts: Mapping[str, float | None]

    @property
    def words(self) -> str:
        """How it does not fit, and where most."""
        known = {part: size for part, size in self.parts.items() if size is not None}
        return f"({in_p(self.p_value)}, most at its {max(known, key=known.get)})"


@dataclass(frozen=True)
class Agreement(Plain):
    """How closing and opening agree in the parameter in which they do least; "" of one motion."""

    p_value: float
    parameter: str


@dataclass(frozen=True)
class ComparisonSettings(Plain):
    """What a comparison was made with: the share beyond which a change counts, and the rest."""

    share: float
    seed: int
    misfit_p_value: float


@dataclass(frozen=True)
class RejectedRecord(Plain):
    """A record that was not used, and why."""

    file: str
    motion: str
    visit: str
    reason: str


@dataclass(frozen=True)
class InspectionChange(Plain):
    """The comparison of two visits.

    Attributes:
        parameters: "told"; "withheld", of a drive of no family; "apart", of motions that contradict
            each other; "beyond" any wear; "unlike", of visits that were measured differently.
        family: Of drives whose networks answer, or the nearest.
        matches: How either visit fits it, by motion and visit.
        agreement: Of the motions.
        settings: With which it was made.
        records: How many there are, by motion and visit.
        rejected: Records that were not used.
        differences: In what the visits were measured differently.
        explanations: Why the visits differ, the most probable first.
        changes: Of what is measured, then of parameters and times.
        mechanisms: The same of mechanisms beside the model.
        limits: Verdicts on the visit of today.
        advice: Where to look first.
        dates: Of each visit; empty where they are not known.
        doubts: What is to be said of the records before anything else.
        remount: That the transducer is mounted elsewhere; empty if it is not.
    """

    parameters: str
    family: str
    matches: Mapping[str, Mapping[str, VisitMatch]]
    agreement: Agreement
    settings: ComparisonSettings
    records: Mapping[str, Mapping[str, int]]
    rejected: Sequence[RejectedRecord]
    differences: Sequence[Difference]
    explanations: Sequence[Explanation]
    changes: Sequence[QuantityChange]
    mechanisms: Sequence[QuantityChange]
    limits: Sequence[Verdict]
    advice: Sequence[str] = ()
    dates: Mapping[str, str] = field(default_factory=dict)
    doubts: Sequence[str] = ()
    remount: str = ""

    def plain(self) -> dict:
        """Return the values by name, after what is said of them."""
        said = {"warnings": self.warnings, "headline": self.headline, "trust": self.trust}
        found = said | super().plain()
        return {name: each for name, each in found.items() if name not in ("doubts", "remount")}

    @property
    def warnings(self) -> list[str]:
        """What is to be said first: of the records, and how visits were measured differently."""
        said = [f"WARNING: {each}" for each in self.doubts]
        if self.differences:
            differ = "; ".join(each.words for each in self.differences)
            said.append(
                f"WARNING: {differ}. {as_sentence(UNLIKE)}, or are of different drives or "
                "phases: check transducer, ratio and endurance.format of both. What follows "
                "compares the records, not the drive"
            )
        return said

    @property
    def headline(self) -> str:
        """What measured has changed, and which parameters have, have not, or cannot be told.

        Parameters and mechanisms are told as changed only beside a measured change: networks alone
        raise no alarm.
        """
        if self.differences:
            return self.either or _NOT_TOLD[self.parameters]
        beyond = f"beyond {in_digits(100 * self.settings.share, 4)} %"
        sure, unsure, _ = _by_verdict(self.measured)
        first = f"Measured: {sure or f'no change {beyond}'}"
        if unsure:
            first += f"; cannot be told: {unsure}"
        first = f"{self.either}\n{first}" if self.either else first
        if self.parameters != "told":
            return f"{first}\n{_NOT_TOLD[self.parameters]}"
        sure, unsure, still = _by_verdict(row for row in self.changes if not row.measured)
        if sure and not self.shows_change:
            return f"{first}\nNo parameter is told: nothing measured has changed for sure {beyond}"
        second = f"Changed: {sure}" if sure else f"No parameter changed for sure {beyond}"
        if unsure:
            second += f"; cannot be told: {unsure}"
        if still:
            second += f"; not {beyond}: {still if unsure else 'all others'}"
        sure, *_ = _by_verdict(self.mechanisms if self.shows_change else [])
        third = f"\nMechanisms beside the model, of {CHANGE_OF}: {sure}" if sure else ""
        return f"{first}\n{second}{third}"

    @property
    def either(self) -> str:
        """The possible explanations, where another ratio or rate is one of them; or nothing."""
        return in_words(self.explanations)

    @property
    def trust(self) -> list[str]:
        """How far the comparison can be trusted, in sentences."""
        return [*_trust(self), *filter(None, [self.remount])]

    @property
    def measured(self) -> list[QuantityChange]:
        """Changes of what is measured."""
        return [row for row in self.changes if row.measured]

    @property
    def shows_change(self) -> bool:
        """Whether anything that is measured has changed, or records as a whole have."""
        same = sum(each.probability for each in self.explanations if each.cause == "none")
        whole = bool(self.explanations) and same < _CHANCE
        return whole or any(row.sure for row in self.measured)

    @property
    def reported(self) -> list[QuantityChange]:
        """What is reported as changed: nothing of visits that were measured differently, and
        parameters and mechanisms only where records as a whole have changed.
        """
        rows = [row for row in [*self.changes, *self.mechanisms] if row.sure]
        measured = [] if self.differences else [row for row in rows if row.measured]
        if self.parameters != "told" or not self.shows_change:
            return measured
        return measured + [row for row in rows if not row.measured]

    @property
    def worse(self) -> list[str]:
        """Names of what is reported as changed to the worse, or where neither side is the worse."""
        rows = self.reported
        return [row.name for row in rows if row.worse is None or row.worse > _WORSE]


def visits_document(
    found: NetworkChanges,
    measured: Sequence[QuantityChange],
    differences: Sequence[Difference],
    settings: ComparisonSettings,
    **about: object,
) -> InspectionChange:
    """Return a comparison as a document.

    Args:
        found: What networks infer. Of visits that were measured differently nothing of it is told.
        measured: What ``measured_changes`` returns.
        differences: In what the visits were measured differently.
        settings: With which it was made.
        about: The other fields.
    """
    state = "told" if found.fits else "withheld"
    state = "apart" if len(found.ratios) > 1 else state
    state = "beyond" if found.fits and not found.ratios else state
    matches = {
        motion: {visit: VisitMatch(match.p_value, match.parts) for visit, match in by.items()}
        for motion, by in found.matches.items()
    }
    inferred = [] if differences else changes(found, settings.share)
    return InspectionChange(
        parameters="unlike" if differences else state,
        family=found.family,
        matches=plainly(matches),
        agreement=plainly(Agreement(found.agreement, found.least)),
        settings=settings,
        differences=plainly(differences),
        explanations=plainly(found.explanations),
        changes=[*measured, *inferred],
        mechanisms=[] if differences else mechanism_changes(found, settings.share),
        **about,
    )


def _by_verdict(rows: Iterable[QuantityChange]) -> list[str]:
    """Names of what has changed, and by how much; of what cannot be told; of what has not."""
    names: dict[str, list[str]] = {verdict: [] for verdict in VERDICT_WORDS}
    for row in rows:
        low, middle, high = (in_digits(each, 2, sign=True) for each in row.if_changed)
        percent = f" {middle} % ({low} to {high})"
        names[row.verdict].append(row.label + (percent if row.sure else ""))
    return [", ".join(each) for each in names.values()]


def _trust(document: InspectionChange) -> list[str]:
    """How far networks can be trusted, in sentences."""
    matches = [
        (motion, visit, match)
        for motion, by in document.matches.items()
        for visit, match in by.items()
    ]
    odd = [each for each in matches if each[2].p_value < document.settings.misfit_p_value]
    family = f"the family {document.family}"
    if document.parameters == "withheld" or (odd and document.differences):
        where = ", ".join(f"the {motion} {visit} {match.words}" for motion, visit, match in odd)
        return [
            f"WARNING: not of a drive of {family}, the nearest that ships: {where}. What is "
            "measured holds. Look at these records with breaker infer --plot; where one motion is "
            "odd, compare the other with --motion"
        ]
    least = in_p(min(match.p_value for _, _, match in matches))
    said = [f"drives of {family} look like both visits (least {least})"]
    how = f"{document.agreement.parameter}, {in_p(document.agreement.p_value)}"
    if document.parameters == "beyond":
        said.append(
            f"WARNING: {BEYOND}. Are both visits of the same drive and phase, and are rate and "
            "ratio of both files right?"
        )
    elif document.parameters == "apart":
        said.append(
            f"WARNING: {APART} ({how}), so that something else "
            "has changed, or a record is of another drive; what each indicates is listed apart"
        )
    elif document.agreement.parameter:
        said.append(f"closing and opening agree (least in {how})")
    return said


def visits_said(document: InspectionChange) -> tuple[list[str], list[str]]:
    """Return what is to be said first of a comparison, and how far it can be trusted."""
    counts = [
        f"{motion} {each['before']} before, {each['today']} today"
        for motion, each in document.records.items()
    ]
    first = [*document.warnings, *document.headline.split("\n")]
    when = [f"{visit} {each or 'not stated'}" for visit, each in document.dates.items()]
    said = [f"dates: {', '.join(when)}"] if any(document.dates.values()) else []
    zones = dict.fromkeys(f"{e.name} {e.zone}" for e in document.changes if e.zone)
    said += [say("zones", zones="; ".join(zones))] if zones else []
    return first, [*document.trust, f"records: {'; '.join(counts)}", *said]


def words_of_visits(document: InspectionChange) -> Document:
    """Return a comparison in words."""
    said = [each for some in visits_said(document) for each in some]
    said += [f"rejected: {each.visit}: {each.file}: {each.reason}" for each in document.rejected]
    share, rows, kind = document.settings.share, [], ""
    for row in document.changes:
        if row.kind != kind and row.kind in _GROUPS:
            rows.append(_GROUPS[row.kind])
        kind = row.kind
        rows.append(_cells(row))
    mechanisms = [row for row in document.mechanisms if row.verdict != VERDICT_WORDS[2]]
    least = in_digits(20 * share, 4)
    rows += [f"mechanisms, % of {CHANGE_OF} (P> {least} %)"] if mechanisms else []
    rows += map(_cells, mechanisms)
    beyond = f"P>{in_digits(100 * share, 4)} %"
    first = _NAME.format("", "before", "today")
    head = (first, "change", "90 % interval", "P same", beyond, "P worse")
    limits = [limits_table(document.limits)] if document.limits else []
    parts = [Section(parts=[Table(head, rows, form=_ROW), *limits])]
    if document.advice:
        parts.append(Section(LOOK, [*map(Remark, document.advice)]))
    return Document(summary=said, parts=parts)


def _cells(row: QuantityChange) -> list[str]:
    values = [in_digits(each, 4) for each in (row.before, row.today) if each is not None]
    name, alone = row.label, row.kind == "parameter" and row.motion
    name += f" ({row.unit})" if values else "" if alone else f": {row.meaning}"
    known = [row.unchanged, row.beyond, row.worse]
    return [
        _NAME.format(name, *values) if values else name,
        *change_words(row),
        *("" if each is None else f"{each:.2f}" for each in known),
    ]


def change_words(row: QuantityChange) -> tuple[str, str]:
    """A change in percent, and its 90 % interval."""
    low, middle, high = (f"{round(each, 1) + 0.0:+.1f}" for each in row.if_changed)  # no -0
    return f"{middle} %", f"{low} to {high}"
