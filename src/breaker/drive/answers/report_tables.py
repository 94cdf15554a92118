"""Tables of a report: what is measured against limits, and what the model adds."""

from collections.abc import Iterable, Mapping, Sequence, Sized

import numpy as np

from breaker.common.numerals import in_digits, in_p
from breaker.documents.parts import Cell, Table
from breaker.drive.answers.answer_document import (
    Estimate,
    QuantityEstimate,
    RecordAnswer,
)
from breaker.drive.answers.answer_words import (
    FEW_DRAWS,
    bounds_in_words,
    first_of_channels,
    how_it_fits,
    is_prior,
    present,
    starred,
    zones_of,
)
from breaker.drive.answers.limit_verdicts import NORMAL
from breaker.drive.answers.simultaneity import simultaneity_of
from breaker.quantities.catalogue import INFERRED
from breaker.quantities.speeds import EVENTS
from breaker.reading.inspection.printed_comparison import differs
from breaker.reading.inspection.proposal_words import alike

RESULTS = {
    "fail": ("FAIL", "bad"),
    "not shown": ("not shown", "doubt"),
    "pass": ("pass", "good"),
}
"""Text and tone of verdicts, the worst first."""

_MOST = 8  # notes below a table
_OUT = (
    "OUT OF a family: no drive that the networks know moves like this, so parameters are withheld; "
    "what is measured holds"
)


NONE = Cell("–", "faint")
"""Where no value is."""


def some_of(text: str, where: Iterable[str], channels: int) -> str:
    """A text, with the channels that it is about where these are not all."""
    names = [*filter(None, dict.fromkeys(where))]
    return f"{text} ({', '.join(names)})" if 0 < len(names) < channels else text


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
    return [*lines[:_MOST], *([f"and {more} more, which breaker infer prints"] if more > 0 else [])]


def measured_table(
    title: str,
    channels: Mapping[str, RecordAnswer],
    printed: Mapping[tuple, tuple[float, str, str]],
) -> Table:
    """Return what is measured, first what needs no model.

    Args:
        title: Which motion it is.
        channels: Entry of the motion in the document, by channel.
        printed: What the analyser printed, by file, motion, channel and quantity: the value, what
            differs in its definition, empty if nothing does, and what the analyser means by it. A
            value that differs from the measured one is marked.
    """
    found: dict[str, dict[str, QuantityEstimate]] = {}
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
            label = f"  printed{', ' * bool(odd)}{odd}"
            rows.append((Cell(label, "faint"), "", *cells))
            said += [(phase, f"{name}: {words}") for phase, words in others.items()]
    head = ["measured", "unit", *(phase or "value" for phase in channels), "± 95 %"]
    head += ["differ by"] if len(channels) > 1 else []
    head += ["limit", "result"] if any(each.limits for each in channels.values()) else []
    rows = [(*row, *[""] * len(head))[: len(head)] for row in rows]
    return Table(head, rows, title, [*named(said, len(channels)), *_notes(channels)])


def _printed(value: tuple[float, str, str] | None, other: bool) -> Cell:
    """What the analyser printed, marked where it is another value than the measured one."""
    text = in_digits(value[0], 4) if value else ""
    return Cell(f"{text} differs", "bad") if other else Cell(text, "faint")


def _other(each: QuantityEstimate | None, printed: tuple[float, str, str]) -> str:
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
    by = f"{in_digits(abs(share), 2)} % {'more' if share > 0.0 else 'less'}"
    return (
        f"measured {in_digits(measured, 4)} {each.unit}, {by} than printed: are scale, ratio "
        "and channel right? Limits judge the measured one"
    )


def _row(name: str, by: Mapping, channels: Mapping[str, RecordAnswer]) -> tuple[str, ...]:
    """A quantity of all channels, with its limits."""
    known = [each for each in by.values() if each.median is not None]
    cells = [
        in_digits(each.median, 4) + "*" * starred(each) if each in known else NONE
        for each in (by.get(phase) for phase in channels)
    ]
    cells.append(in_digits(max(each.half for each in known), 2) if known else "")
    cells += _spread([each.median for each in known], channels, "*" * any(map(starred, known)))
    unit = next(iter(by.values())).unit
    return (name, unit, *cells, *_limits(name, channels))


def _times(channels: Mapping[str, RecordAnswer]) -> list[tuple[str, ...]]:
    """When channels move and contacts switch in the record: what poles of one record differ by."""
    rows = []
    event = EVENTS[next(iter(channels.values())).motion]
    moves = np.array([each.fit.moves for each in channels.values()])
    switches = np.array([each.fit.switches for each in channels.values()])
    one = len({each.file for each in channels.values()}) == 1
    for name, values in {"first motion": moves, event: switches}.items():
        if np.isfinite(values).any():
            cells = [f"{each:.2f}" if np.isfinite(each) else NONE for each in values]
            spread = _spread(values[np.isfinite(values)], channels)
            rows.append((f"{name} at", "ms", *cells, "", *(spread if one else ())))
    return rows


def _spread(values: Sequence[float], channels: Sized, star: str = "") -> list[str]:
    """By how much channels differ, with a star where the model has a part; nothing of one."""
    if len(channels) == 1:
        return []
    return [in_digits(np.ptp(values), 2) + star if len(values) > 1 else ""]


def _limits(name: str, channels: Mapping[str, RecordAnswer]) -> tuple[str, ...]:
    """What limits ask of a quantity, the worst verdict, and of which channels."""
    rows = [
        (phase, each)
        for phase, entry in channels.items()
        for each in entry.limits or ()
        if each.parts[0].quantity == name
    ]
    asked = dict.fromkeys(
        f"not: {each.words}" if len(each.parts) > 1 else bounds_in_words(each.parts[0])
        for _, each in rows
    )
    for verdict, (text, tone) in RESULTS.items():
        if of := [phase for phase, each in rows if each.verdict == verdict]:
            return ", ".join(asked), Cell(some_of(text, of, len(channels)), tone)
    return ()


def _notes(channels: Mapping[str, RecordAnswer]) -> list[str]:
    """Why values are missing, what a star means, and what is doubtful."""
    said, any_star = [], False
    for phase, entry in channels.items():
        for name, each in entry.quantities.items():
            any_star |= starred(each) and name not in INFERRED
            said += [(phase, f"– {name}: {each.reason}")] if each.reason else []
        said += [(phase, f"remark: {remark}") for remark in entry.remarks]
    event = EVENTS[entry.motion]
    star = f"* the time of the {event} was not measured: by the model's, with its interval"
    together = [each for each in [simultaneity_of(channels)] if each]
    points = zones_of(entry.quantities for entry in channels.values())
    return [*together, *points, *([star] if any_star else []), *named(said, len(channels))]


def model_table(entries: Sequence[RecordAnswer]) -> Table:
    """Return parameters of the first operation of each channel, and how far they can be trusted."""
    first, rows, said = first_of_channels(entries), [], []
    for entry in first:
        phase, fit = entry.phase, entry.fit
        fits = f"{fit.family.replace('_', ' ')}\n{in_p(fit.p_value)}"
        how = how_it_fits(fit.p_value, fit.misfit)
        trust = Cell(f"{how} {fits}", "doubt" * (how != "fits"))
        if fit.misfit:
            trust = Cell(f"{how} {fits}", "bad")
            said.append(("", _OUT))
        elif fit.why_unresolved:
            trust = Cell("not resolved", "doubt")
            said.append((phase, f"{FEW_DRAWS}, so none is shown: {fit.why_unresolved}"))
        said += [
            (phase, f"beside the model it has {name}: {each.meaning}")
            for name, each in present(entry.mechanisms).items()
        ]
        of = " and ".join(fit.motions or [entry.motion])
        cells = map(_posterior, _inferred(entry).values())
        rows.append((f"{phase}: {of}" if phase else of, trust, *cells))
    names = _inferred(entries[0])
    units = (f"{n}\n{'' if each.unit == '1' else each.unit}" for n, each in names.items())
    notes = named(said, len(first))
    if any(each.fit.resolved for each in first):
        notes.append("; ".join(f"{name}: {each.meaning}" for name, each in names.items()))
        grey = any(is_prior(each) for entry in first for each in entry.parameters.values())
        said = "medians and 95 % intervals of the first operation of each channel"
        notes.append(said + "; grey: nearly all prior, the record adds little" * grey)
    by: dict[str, dict[str, dict[str, None]]] = {}
    for entry in entries:
        for each in entry.limits or ():
            if each.parts[0].quantity in names:
                results = by.setdefault(f"limit {each.name}, {each.words}", {})
                where = results.setdefault(RESULTS[each.verdict][0], {})
                where[entry.phase or entry.motion] = None
    for limit, results in by.items():
        told = (f"{result} {', '.join(where)}" for result, where in results.items())
        notes.append(f"{limit}: {'; '.join(told)}")
    return Table(("channel", "trust", *units), rows, "What the model adds", notes)


def _inferred(entry: RecordAnswer) -> dict[str, Estimate]:
    """Parameters of a record, and the wipe that follows from the gap."""
    return {**entry.parameters, "wipe": entry.quantities["wipe"]}


def _posterior(each: Estimate) -> Cell:
    if each.median is None:
        return NONE
    low, high = (in_digits(end, 2) for end in each.interval_95)
    return Cell(f"{in_digits(each.median, 3)}\n{low}–{high}", "faint" * is_prior(each))


def mass_table(entries: Sequence[RecordAnswer]) -> list[Table]:
    """Return what parameters of the first operation of each channel are with the moving mass; none
    where it is not known.
    """
    first: dict[str, RecordAnswer] = {}
    for entry in entries:
        if entry.with_mass:
            first.setdefault(entry.phase, entry)
    if not first:
        return []
    names = next(iter(first.values())).with_mass
    units = (f"{name}\n{each.unit}" for name, each in names.items())
    rows = [(phase, *map(_posterior, each.with_mass.values())) for phase, each in first.items()]
    notes = ["; ".join(f"{name}: {each.meaning}" for name, each in names.items())]
    return [Table(("channel", *units), rows, "With the moving mass", notes)]
