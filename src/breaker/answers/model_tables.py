"""Tables beside what is measured: changes since the visit before, and what the model adds."""

from collections.abc import Mapping, Sequence

from breaker.answers.cells import NONE, RESULTS, Cell, Table, named
from breaker.answers.changed import VERDICT_WORDS
from breaker.answers.visited import change_words, label_of
from breaker.mechanism import in_digits, in_p

__all__ = ["changes_table", "model_table"]

_TONES = dict(zip(VERDICT_WORDS, ("bad", "doubt", ""), strict=True))
_WIDE = 3  # channels, up to which a change has room for its values
_FEW = "prior, facts or the contact's time leave hardly a draw of the network, so none is shown: "
_OUT = (
    "OUT OF a family: no drive that the networks know moves like this, so parameters are withheld; "
    "what is measured holds"
)


def changes_table(changed: Mapping[str, Mapping], phases: Sequence[str]) -> Table:
    """Return what has changed since the visit before, measured first; all else in notes."""
    there = [phase for phase in phases if phase in changed]
    by: dict[tuple, dict[str, Mapping]] = {}
    for phase in there:
        for row in changed[phase]["changes"]:
            by.setdefault((label_of(row), row["kind"]), {})[phase] = row
    rows, other = [], {VERDICT_WORDS[1]: [], VERDICT_WORDS[2]: []}
    for (label, kind), found in by.items():
        worst = min((each["verdict"] for each in found.values()), key=VERDICT_WORDS.index)
        first = next(iter(found.values()))
        if worst == VERDICT_WORDS[2] or (worst in other and kind != "measured"):
            other[worst].append(f"{label}, inferred" if kind == "time" else label)
            continue
        cells = [_change(found.get(phase), len(there) <= _WIDE) for phase in there]
        unit, source = (first["unit"], "measured") if kind == "measured" else ("", "inferred")
        rows.append((Cell(label), Cell(unit), Cell(source, "faint"), *cells))
    shares = [each["settings"]["share"] for each in changed.values() if each["changes"]]
    notes = [
        f"{how} beyond {in_digits(100.0 * shares[0], 3)} %: {', '.join(names)}"
        for how, names in zip(("perhaps", "not"), other.values(), strict=True)
        if names
    ]
    trust = [(phase, text) for phase, each in changed.items() for text in each["trust"]]
    head = ("since the visit before", "unit", "", *(phase or "change" for phase in there))
    return Table("Changes", head, rows, [*notes, *named(trust, len(changed))])


def _change(row: Mapping | None, wide: bool) -> Cell:
    if row is None:
        return NONE
    text, span = change_words(row)
    if wide and "before" in row:
        values = (in_digits(row[visit], 4) for visit in ("before", "today"))
        text = f"{' → '.join(values)} ({text})"
    elif wide:
        text += f" ({span})"
    return Cell(text, _TONES[row["verdict"]])


def model_table(entries: Sequence[Mapping]) -> Table:
    """Return parameters of the first operation of each channel, and how far they can be trusted."""
    first: dict[tuple, Mapping] = {}
    for entry in entries:
        first.setdefault((entry.get("phase") or "", *entry["fit"]["motions"]), entry)
    rows, said = [], []
    for (phase, *_), entry in first.items():
        fit = entry["fit"]
        fits = f"{fit['family'].replace('_', ' ')}\n{in_p(fit['p_value'])}"
        trust = Cell(f"fits {fits}")
        if fit["misfit"]:
            trust = Cell(f"OUT OF {fits}", "bad")
            said.append(("", _OUT))
        elif fit["why_unresolved"]:
            trust = Cell("not resolved", "doubt")
            said.append((phase, _FEW + fit["why_unresolved"]))
        of = " and ".join(fit["motions"] or [entry["motion"]])
        cells = map(_posterior, entry["parameters"].values())
        rows.append((Cell(f"{phase}: {of}" if phase else of), trust, *cells))
    names = entries[0]["parameters"]
    units = (f"{n}\n{'' if each['unit'] == '1' else each['unit']}" for n, each in names.items())
    notes = named(said, len(first))
    if any(each["fit"]["resolved"] for each in first.values()):
        notes.append("; ".join(f"{name}: {each['meaning']}" for name, each in names.items()))
        notes.append("medians and 95 % intervals of the first operation of each channel")
    by: dict[str, dict[str, dict[str, None]]] = {}
    for entry in entries:
        for each in entry.get("limits", ()):
            if each["parts"][0]["quantity"] in names:
                results = by.setdefault(f"limit {each['name']}, {each['words']}", {})
                where = results.setdefault(RESULTS[each["verdict"]][0], {})
                where[entry.get("phase") or entry["motion"]] = None
    for limit, results in by.items():
        told = (f"{result} {', '.join(where)}" for result, where in results.items())
        notes.append(f"{limit}: {'; '.join(told)}")
    return Table("What the model adds", ("channel", "trust", *units), rows, notes)


def _posterior(each: Mapping) -> Cell:
    if each["median"] is None:
        return NONE
    low, high = (in_digits(end, 2) for end in each["interval_95"])
    return Cell(f"{in_digits(each['median'], 3)}\n{low}–{high}")
