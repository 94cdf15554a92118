"""Tables beside what is measured: changes since the visit before, and what the model adds."""

from collections.abc import Mapping, Sequence

from breaker.answers.answer import Answer
from breaker.answers.cells import RESULTS, Cell, Table, named, number
from breaker.answers.changed import VERDICT_WORDS
from breaker.mechanism import Limit

__all__ = ["changes_table", "model_table"]

_TONES = dict(zip(VERDICT_WORDS, ("bad", "doubt", ""), strict=True))
_WIDE = 3  # channels, up to which a change has room for its values


def changes_table(changed: Mapping[str, Mapping], phases: Sequence[str]) -> Table:
    """Return what has changed since the visit before, measured first; all else in notes."""
    rows_of = {
        phase: {(row["name"], row["motion"], row["kind"]): row for row in each["changes"]}
        for phase, each in changed.items()
    }
    there = [phase for phase in phases if phase in rows_of]
    rows, other = [], {VERDICT_WORDS[1]: [], VERDICT_WORDS[2]: []}
    for key in dict.fromkeys(key for each in rows_of.values() for key in each):
        name, motion, kind = key
        found = {phase: rows_of[phase][key] for phase in there if key in rows_of[phase]}
        label = f"{name} ({motion})" if motion and motion not in name else name
        worst = min((each["verdict"] for each in found.values()), key=VERDICT_WORDS.index)
        if worst in other and name != "stroke":
            other[worst].append(label)
            continue
        cells = [_change(found.get(phase), len(there) <= _WIDE) for phase in there]
        measured = kind == "measured"
        unit = next(iter(found.values()))["unit"] if measured else ""
        source = Cell("measured" if measured else "inferred", "faint")
        rows.append((Cell(label), Cell(unit), source, *cells))
    share = [100.0 * each["settings"]["share"] for each in changed.values() if each["changes"]]
    beyond = f"beyond {share[0]:g} %" if share else ""
    words = {VERDICT_WORDS[1]: f"perhaps {beyond}", VERDICT_WORDS[2]: f"not {beyond}"}
    notes = [f"{words[each]}: {', '.join(names)}" for each, names in other.items() if names]
    trust = [(phase, text) for phase, each in changed.items() for text in each["trust"]]
    head = ("since the visit before", "unit", "", *(phase or "change" for phase in there))
    return Table("Changes", head, rows, [*notes, *named(trust, len(changed))])


def _change(row: Mapping | None, wide: bool) -> Cell:
    if row is None:
        return Cell("–", "faint")
    low, middle, high = (round(each, 1) + 0.0 for each in row["change"])  # no -0
    text = f"{middle:+.1f} %"
    if wide and "before" in row:
        text = f"{number(row['before'], 4)} → {number(row['today'], 4)} ({text})"
    elif wide:
        text += f" ({low:+.0f} to {high:+.0f})"
    return Cell(text, _TONES[row["verdict"]])


def model_table(pairs: Sequence[tuple[Answer, Mapping]], limits: Sequence[Limit]) -> Table:
    """Return parameters of the first operation of each channel, and how far they can be trusted."""
    first: dict[tuple, tuple[Answer, Mapping]] = {}
    for answer, entry in pairs:
        first.setdefault((entry.get("phase", ""), *answer.motions), (answer, entry))
    rows, few, names = [], [], {}
    for (phase, *_), (_, entry) in first.items():
        fit, names = entry["fit"], entry["parameters"]
        of = " and ".join(fit["motions"] or [entry["motion"]])
        name = fit["family"].replace("_", " ")
        trust = Cell(f"fits {name}\np = {fit['p_value']:.2g}")
        if fit["misfit"]:
            trust = Cell(f"OUT OF {name}\np = {fit['p_value']:.1g}", "bad")
        elif fit["why_unresolved"]:
            trust = Cell("not resolved", "doubt")
            said = "prior, facts or the contact's time leave hardly a draw of the network"
            few.append((phase, f"{said}, so none is shown: {fit['why_unresolved']}"))
        cells = [
            Cell("–", "faint") if fit["why_unresolved"] else _posterior(each)
            for each in entry["parameters"].values()
        ]
        rows.append((Cell(f"{phase}\n{of}" if phase else of), trust, *cells))
    units = (
        f"{name}\n{'' if each['unit'] == '1' else each['unit']}" for name, each in names.items()
    )
    notes = named(few, len(first))
    notes += ["; ".join(f"{name}: {each['meaning']}" for name, each in names.items())]
    notes += ["medians, and below them 95 % intervals, of the first operation of each channel"]
    if any(entry["fit"]["misfit"] for _, entry in first.values()):
        notes.append(
            "OUT OF a family: no drive that the networks know moves like this, so parameters are "
            "withheld; what is measured holds"
        )
    parameters = [each for each in limits if each.quantities[0] in names]
    by: dict[str, dict[str, list[str]]] = {}
    for _, entry in pairs:
        for each in entry.get("limits", ()):
            where = by.setdefault(each["name"], {}).setdefault(RESULTS[each["verdict"]][0], [])
            where.append(entry.get("phase", "") or entry["motion"])
    for limit in parameters:
        name = limit.pair or limit.name
        said = [f"{r} {', '.join(dict.fromkeys(p))}" for r, p in by.get(name, {}).items()]
        notes.append(f"limit {name}, {limit.words}: {'; '.join(said) or 'not judged'}")
    return Table("What the model adds", ("channel", "trust", *units), rows, notes)


def _posterior(each: Mapping) -> Cell:
    if each["median"] is None:
        return Cell("–", "faint")
    low, high = (number(end, 2) for end in each["interval_95"])
    return Cell(f"{number(each['median'], 3)}\n{low}–{high}")
