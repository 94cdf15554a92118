"""Table of a report: what has changed since the visit before."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from breaker.common.document import Cell, Table
from breaker.common.numerals import in_digits
from breaker.common.plain_values import note_of
from breaker.diagnosis.changes import VERDICT_WORDS, QuantityChange
from breaker.diagnosis.inspection_change import InspectionChange, change_words
from breaker.diagnosis.tables import NONE, grouped
from breaker.family.untold import LOOK

_TONES = dict(zip(VERDICT_WORDS, ("bad", "doubt", ""), strict=True))
_WIDE = 3  # channels, up to which a change has room for its values


@dataclass(frozen=True)
class NotCompared:
    """A phase that is compared with no visit before, and why."""

    trust: Sequence[str]
    changes: Sequence[QuantityChange] = ()
    warnings: Sequence[str] = ()
    advice: Sequence[str] = ()
    dates: Mapping[str, str] = field(default_factory=dict)


def changes_table(
    changed: Mapping[str, InspectionChange | NotCompared], phases: Sequence[str]
) -> Table:
    """Return what has changed since the visit before, measured first; all else in notes."""
    there = [phase for phase in phases if phase in changed]
    by: dict[tuple, dict[str, QuantityChange]] = {}
    for phase in there:
        for row in changed[phase].changes:
            by.setdefault((row.label, row.kind), {})[phase] = row
    rows, other = [], {VERDICT_WORDS[1]: [], VERDICT_WORDS[2]: []}
    for (label, kind), found in by.items():
        worst = min((each.verdict for each in found.values()), key=VERDICT_WORDS.index)
        first = next(iter(found.values()))
        if worst == VERDICT_WORDS[2] or (worst in other and kind != "measured"):
            other[worst].append(f"{label}, inferred" if kind == "time" else label)
            continue
        cells = [_change(found.get(phase), len(there) <= _WIDE) for phase in there]
        unit = first.unit if kind == "measured" else ""
        source = "measured" if kind == "measured" else "inferred"
        rows.append((label, unit, Cell(source, "faint"), *cells))
    shares = [each.settings.share for each in changed.values() if each.changes]
    notes = [
        f"{how} {in_digits(100.0 * shares[0], 3)} %: {', '.join(names)}"
        for how, names in zip(("perhaps beyond", "not beyond"), other.values(), strict=True)
        if names
    ]
    trust = [(phase, note_of(text)) for phase, each in changed.items() for text in each.trust]
    look = [
        (phase, note_of(f"{LOOK}: {words}"))
        for phase, each in changed.items()
        for words in each.advice
    ]
    notes += grouped(look, changed)
    when = next((each.dates["before"] for each in changed.values() if each.dates), "")
    since = f"since the visit before\n{when}" if when else "since the visit before"
    head = (since, "unit", "", *(phase or "change" for phase in there))
    return Table(head, rows, "Changes", [*notes, *grouped(trust, changed)])


def _change(row: QuantityChange | None, wide: bool) -> Cell:
    if row is None:
        return NONE
    text, span = change_words(row)
    if wide and row.measured:
        values = (in_digits(each, 4) for each in (row.before, row.today))
        text = f"{' → '.join(values)} ({text})"
    elif wide:
        text += f" ({span})"
    return Cell(text, _TONES[row.verdict])
