"""Tables of a report: what is measured against limits, and what the model adds."""

from collections.abc import Iterable, Mapping, Sequence, Sized

import numpy as np

from breaker.common.numerals import in_digits, in_p
from breaker.common.parts import Cell, Table
from breaker.diagnosis.answer_words import (
    FEW_DRAWS,
    bounds_in_words,
    first_of_channels,
    how_it_fits,
    is_prior,
    present,
    starred,
    zones_of,
)
from breaker.diagnosis.limits import NORMAL
from breaker.diagnosis.result import (
    QuantityValue,
    RecordResult,
    Value,
)
from breaker.model.quantities import EVENTS, INFERRED
from breaker.records.printed import differs
from breaker.records.proposal import alike

_MOST = 8  # notes below a table
_WORDY = 3  # channels, up to which words stand beside the name of a parameter
_OUT = (
    "OUT OF a family: no drive that the networks know moves like this, so parameters are withheld; "
    "what is measured holds"
)


RESULTS = {
    "fail": ("FAIL", "bad"),
    "inconclusive": ("inconclusive", "doubt"),
    "pass": ("pass", "good"),
}
"""Text and tone of verdicts, the worst first."""

NONE = Cell("–", "faint")
"""Where no value is."""


def some_of(text: str, where: Iterable[str], channels: int) -> str:
    """A text, with the channels that it is about where these are not all."""
    names = [*filter(None, dict.fromkeys(where))]
    if not 0 < len(names) < channels:
        return text
    return f"{text} ({', '.join(names)})"


def named(said: Iterable[tuple[str, str]], channels: int) -> list[str]:
    """Sentences, those that differ in numbers only once, with channels where these are not all.

    Args:
        said: Channel and sentence.
        channels: Number of channels in all.
    """
    groups = alike(("", channel, text) for channel, text in said)
    return few(
        [some_of(each[0][2], (channel for _, channel, _ in each), channels) for each in groups]
    )


def few(lines: Sequence[str]) -> list[str]:
    """The first lines, and how many more there are."""
    more = len(lines) - _MOST
    last = [f"and {more} more, which breaker infer prints"] if more > 0 else []
    return [*lines[:_MOST], *last]


def measured_table(
    title: str,
    channels: Mapping[str, RecordResult],
    printed: Mapping[tuple, tuple[float, str, str]],
    together: str = "",
) -> Table:
    """Return what is measured, first what needs no model.

    Args:
        title: Which motion it is.
        channels: Entry of the motion in the document, by channel.
        printed: What the analyser printed, by file, motion, channel and quantity: the value, what
            differs in its definition, empty if nothing does, and what the analyser means by it. A
            value that differs from the measured one is marked.
        together: By how much poles switch apart, in words.
    """
    found: dict[str, dict[str, QuantityValue]] = {}
    for phase, entry in channels.items():
        for name, each in entry.quantities.items():
            if name not in INFERRED:  # no time that an instrument has
                found.setdefault(name, {})[phase] = each
    rows, said = _times(channels), []
    for name in sorted(found, key=lambda name: any(map(starred, found[name].values()))):
        rows.append(_row(name, found[name], channels))
        of = {p: (each.file, each.motion, p, name) for p, each in channels.items()}
        values = {p: each for p, key in of.items() if (each := printed.get(key))}
        if values:
            odd = next((each[1] for each in values.values() if each[1]), "")
            others = {p: w for p, each in values.items() if (w := _other(found[name].get(p), each))}
            cells = (_printed(values.get(p), p in others) for p in channels)
            label = f"  printed, {odd}" if odd else "  printed"
            rows.append((Cell(label, "faint"), "", *cells))
            said += [(p, f"{name}: {words}") for p, words in others.items()]
    head = ["measured", "unit", *(phase or "value" for phase in channels), "± 95 %"]
    head += ["differ by"] if len(channels) > 1 else []
    head += _heads_of_limits(channels)
    rows = [(*row, *[""] * len(head))[: len(head)] for row in rows]
    return Table(head, rows, title, [*named(said, len(channels)), *_notes(channels, together)])


def _printed(value: tuple[float, str, str] | None, other: bool) -> Cell:
    """What the analyser printed, marked where it is another value than the measured one."""
    text = in_digits(value[0], 4) if value else ""
    return Cell(f"{text} differs", "bad") if other else Cell(text, "faint")


def _other(each: QuantityValue | None, printed: tuple[float, str, str]) -> str:
    """By how much a measured quantity is not what the analyser printed; empty where it is that, or
    where it is counted between other points or not by the record alone.
    """
    value, odd, quantity = printed
    if odd or each is None or each.source != "measured":
        return ""
    measured = each.median
    if not differs(quantity, value, measured, (each.interval_95[1] - measured) / NORMAL[95]):
        return ""
    share = 100.0 * (measured / value - 1.0)
    more = f"{in_digits(abs(share), 2)} % {'more' if share > 0.0 else 'less'}"
    return (
        f"measured {in_digits(measured, 4)} {each.unit}, {more} than printed: are scale, ratio and "
        "channel right? Limits judge the measured one"
    )


def _row(name: str, by: Mapping, channels: Mapping[str, RecordResult]) -> tuple[str, ...]:
    """A quantity of all channels, with its limits."""
    known = [each for each in by.values() if each.median is not None]
    cells = [
        in_digits(each.median, 4) + "*" * starred(each) if each in known else NONE
        for each in (by.get(phase) for phase in channels)
    ]
    cells.append(in_digits(max(each.half for each in known), 2) if known else "")
    cells += _spread([each.median for each in known], channels, "*" * any(map(starred, known)))
    unit = next(iter(by.values())).unit
    return (name, unit, *cells, *_limits(name, by, channels))


def _times(channels: Mapping[str, RecordResult]) -> list[tuple[str, ...]]:
    """When channels move and contacts switch in the record: what poles of one record differ by."""
    rows = []
    event = EVENTS[next(iter(channels.values())).motion]
    moves = np.array([each.fit.moves for each in channels.values()])
    switches = np.array([each.fit.switches for each in channels.values()])
    one = len({each.file for each in channels.values()}) == 1
    named = {"first motion at": moves, f"{event} at": switches}
    for name, values in named.items():
        if np.isfinite(values).any():
            cells = [f"{each:.2f}" if np.isfinite(each) else NONE for each in values]
            spread = _spread(values[np.isfinite(values)], channels)
            rows.append((name, "ms", *cells, "", *(spread if one else ())))
    return rows


def _spread(values: Sequence[float], channels: Sized, star: str = "") -> list[str]:
    """By how much channels differ, with a star where the model has a part; nothing of one."""
    if len(channels) == 1:
        return []
    return [in_digits(np.ptp(values), 2) + star if len(values) > 1 else ""]


def _heads_of_limits(channels: Mapping[str, RecordResult]) -> list[str]:
    """Names of the columns of limits; none without any, and a reference only where one has it."""
    if not any(each.limits for each in channels.values()):
        return []
    beside = ["reference", "deviation"] if _have_references(channels) else []
    return [*beside, "tolerance", "verdict"]


def _have_references(channels: Mapping[str, RecordResult]) -> bool:
    """Whether any limit is a tolerance away from a value."""
    limits = (each for entry in channels.values() for each in entry.limits or ())
    return any(each.parts[0].reference is not None for each in limits)


def _limits(
    name: str, by: Mapping[str, QuantityValue], channels: Mapping[str, RecordResult]
) -> tuple[str, ...]:
    """Cells of the columns of limits: the worst verdict, and of which channels."""
    rows = [
        (phase, each)
        for phase, entry in channels.items()
        for each in entry.limits or ()
        if each.parts[0].quantity == name
    ]
    asked, references, deviations = {}, {}, []
    for phase, each in rows:
        part, reference = each.parts[0], each.parts[0].reference
        words = f"not: {each.words}" if len(each.parts) > 1 else bounds_in_words(part)
        if reference is not None:
            words = f"± {in_digits(part.bounds[1] - reference, 3)}"
            references[in_digits(reference, 4)] = None
            value = by[phase].median if phase in by else None
            deviations += [] if value is None else [value - reference]
        asked[words] = None
    beside = ()
    if _have_references(channels):
        most = max(deviations, key=abs, default=None)
        sign = "+" if most is not None and most > 0.0 else ""
        off = "" if most is None else sign + in_digits(most, 2)
        beside = ", ".join(references), off
    for verdict, (text, tone) in RESULTS.items():
        if of := [phase for phase, each in rows if each.verdict == verdict]:
            told = Cell(some_of(text, of, len(channels)), tone)
            return (*beside, ", ".join(asked), told)
    return ()


def _notes(channels: Mapping[str, RecordResult], together: str) -> list[str]:
    """Why values are missing, what a star means, and what is doubtful."""
    said, any_star = [], False
    for phase, entry in channels.items():
        for name, each in entry.quantities.items():
            any_star |= starred(each) and name not in INFERRED
            said += [(phase, f"– {name}: {each.reason}")] if each.reason else []
        said += [(phase, f"remark: {each}") for each in entry.remarks]
    event = EVENTS[entry.motion]
    star = f"* the time of the {event} was not measured: by the model's, with its interval"
    points = zones_of(entry.quantities for entry in channels.values())
    first = [together] if together else []
    return [*first, *points, *([star] if any_star else []), *named(said, len(channels))]


def model_table(entries: Sequence[RecordResult]) -> Table:
    """Return parameters of the first operation of each channel, a row each, and how far they can be
    trusted.
    """
    first, heads, trusts, said = first_of_channels(entries), [], [], []
    for entry in first:
        phase, fit = entry.phase, entry.fit
        trusts.append(_trust(entry))
        if fit.misfit:
            said.append(("", _OUT))
        elif fit.why_unresolved:
            said.append((phase, f"{FEW_DRAWS}, so none is shown: {fit.why_unresolved}"))
        said += [
            (phase, f"beside the model it has {name}: {each.meaning}")
            for name, each in present(entry.mechanisms).items()
        ]
        of = " + ".join(fit.motions or [entry.motion])
        heads.append(f"{phase}: {of}" if phase else of)
    names, grey = _inferred(entries[0]), False
    rows: list[tuple[str, ...]] = [("trust", "", *trusts)]
    for name, of in names.items():
        known = [_inferred(each)[name] for each in first]
        grey |= any(map(is_prior, known))
        unit = "" if of.unit == "1" else of.unit
        label = _label(name, of) if len(first) <= _WORDY else name
        rows.append((label, unit, *map(_posterior, known)))
    head = ["of the model", "unit", *heads]
    notes = named(said, len(first))
    if len(first) > _WORDY:
        notes.append("; ".join(_label(*each) for each in names.items()))
    if any(each.fit.resolved for each in first):
        notes.append("medians and 95 % intervals of the first operation of each channel")
        notes += ["grey: nearly all prior, the record adds little"] if grey else []
    return Table(head, rows, "What the model adds", [*notes, *_limits_of_model(entries)])


def _trust(entry: RecordResult) -> Cell:
    """How far the parameters of a record can be trusted."""
    fit = entry.fit
    how = how_it_fits(fit.p_value, fit.misfit)
    family = fit.family.replace("_", " ")
    trust = f"{how} {family}\n{in_p(fit.p_value)}"
    if fit.misfit:
        return Cell(trust, "bad")
    if fit.why_unresolved:
        return Cell("not resolved", "doubt")
    return Cell(trust, "doubt" * (how != "fits"))


def _limits_of_model(entries: Sequence[RecordResult]) -> list[str]:
    """Verdicts on limits on what the model adds."""
    names = _inferred(entries[0])
    by: dict[tuple[str, str], dict[str, dict[str, None]]] = {}
    for entry in entries:
        for each in entry.limits or ():
            if each.parts[0].quantity in names:
                results = by.setdefault((each.name, each.words), {})
                results.setdefault(each.verdict, {})[entry.phase or entry.motion] = None
    notes = []
    for (name, words), results in by.items():
        told = "; ".join(f"{RESULTS[each][0]} {', '.join(of)}" for each, of in results.items())
        notes.append(f"limit {name}, {words}: {told}")
    return notes


def _inferred(entry: RecordResult) -> dict[str, Value]:
    """Parameters of a record, and the wipe that follows from the gap."""
    return {**entry.parameters, "spring_compression": entry.quantities["spring_compression"]}


def _label(name: str, of: Value) -> str:
    return f"{name}: {of.meaning}"


def _posterior(each: Value) -> Cell:
    if each.median is None:
        return NONE
    low, high = (in_digits(end, 2) for end in each.interval_95)
    both = f"{in_digits(each.median, 3)}\n{low}–{high}"
    return Cell(both, "faint" * is_prior(each))
