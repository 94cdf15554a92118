"""An answer in words: a document of sections, one for each record."""

from collections.abc import Iterable, Mapping, Sequence

from breaker.common.numerals import in_digits, in_p
from breaker.common.parts import (
    Document,
    Remark,
    Section,
    Table,
)
from breaker.diagnosis.inference import SURPRISING
from breaker.diagnosis.limits import VERDICTS, JudgedPart, Verdict
from breaker.diagnosis.result import (
    DiagnosisResult,
    Fit,
    QuantityValue,
    RecordResult,
    Spread,
    Together,
    Value,
)
from breaker.model.quantities import EVENTS

_ROW = "  {:<19} {:>8}  {:<20} {:<7} {}"
_LIMIT = "  {:<20} {:<9} {:>8}  {:<20} {}"
_SHARED = "  {:<19} {:>9}  {:<22} {:>9} {:>12}  {:<7}{}"
_CELLS, _SHORT = 3, "  {:<32} {:<32} {:<32}"  # of a line of a short section
_EDGE = 0.02  # p-value, below which a record is at the edge of a family
_THERE = 0.9  # probability from which on a mechanism is there; from 1 less it on it is not
_PRIOR = 0.8  # share of the prior's variance, from which on a record says hardly anything
FEW_DRAWS = "the prior or known values leave hardly a draw of the network"
"""Why an answer is not resolved."""


def words_of(answer: DiagnosisResult) -> Document:
    """Return an answer in words: a section for each record, short where there are several files."""
    records = answer.records
    section = _short if len({each.file for each in records}) > 1 else _long
    first, accepted = [], any(each.accepted for each in records)
    if accepted:
        first = [f"WARNING: {each}" for each in answer.warnings] + answer.drive["words"]
    if accepted and section is _short:
        first.append(
            "± is half of a 95 % interval, * by the model's contact event; --json, --output and "
            "--draws have all numbers"
        )
        first += zones_of(each.quantities for each in records if each.accepted)
    parts = []
    for file in dict.fromkeys(each.file for each in records):
        there = [each for each in records if each.file == file]
        parts += [section(each) if each.accepted else _rejected(each, there) for each in there]
    parts += [_together(motion, each) for motion, each in answer.together.items()]
    return Document(summary=first, parts=parts)


def _rejected(record: RecordResult, of_file: Sequence[RecordResult]) -> Section:
    """A section that says why. Of which motion only where the file has another one."""
    title = _title(record) if len(of_file) > 1 else record.file
    return Section(title, [Remark(f"rejected: {record.reason}")])


def _long(record: RecordResult) -> Section:
    """A section with everything that is known of a record, what is measured first."""
    measured, inferred = _both(record)
    rows = [_row(name, each, _source(each)) for name, each in measured.items()]
    parts = [Table(("", "value", "95 % interval", "", ""), rows, form=_ROW)]
    if record.fit.resolved:
        together = " of both motions together" if len(record.fit.motions) > 1 else ""
        parts += [f"inferred{together}", *_inferred(inferred), *_mechanisms(record.mechanisms)]
    parts += limit_tables(record.limits or ())
    return Section(_title(record), [*parts, *_ending(record)])


def _source(each: QuantityValue) -> str:
    """How a quantity is known, or why it is not; of a speed with its zone, of a time with its
    zero.
    """
    what = each.meaning if each.unit == "ms" else each.zone
    return ", ".join(filter(None, (what, each.source or each.reason)))


def zones_of(records: Iterable[Mapping[str, QuantityValue]]) -> list[str]:
    """Say between which points each speed of some records is the mean, if there is one."""
    return zones_in_words((n, e.zone) for each in records for n, e in each.items() if e.zone)


def zones_in_words(zones: Iterable[tuple[str, str]]) -> list[str]:
    """Say the zones of speeds, each a name and a zone, once; nothing of none."""
    said = "; ".join(" ".join(pair) for pair in dict.fromkeys(zones))
    return [f"speeds, means of the drive: {said}"] if said else []


def _inferred(some: Mapping[str, Value]) -> list[Table]:
    rows = [_row(n, e, e.reason or f"{e.meaning}{_of_prior(e)}") for n, e in some.items()]
    return [Table(rows=rows, form=_ROW)]


def present(some: Mapping[str, Value]) -> dict[str, Value]:
    """Return the mechanisms beside the model that a drive has for sure, by name."""
    return {name: each for name, each in some.items() if each.probability >= _THERE}


def _mechanisms(some: Mapping[str, Value]) -> list:
    """What the drive has beside the model for sure, and what it may have or has not."""
    there = present(some)
    perhaps = {n: e for n, e in some.items() if 1.0 - _THERE < e.probability < _THERE}
    names = {
        "perhaps": [f"{name} {100.0 * e.probability:.0f} %" for name, e in perhaps.items()],
        "not there": [name for name in some if name not in there | perhaps],
    }
    rows = [_row(name, each, each.meaning) for name, each in there.items()]
    said = [Remark(f"{title}: {', '.join(each)}") for title, each in names.items() if each]
    return ["mechanisms beside the model", Table(rows=rows, form=_ROW), *said] if some else []


def _of_prior(each: Value) -> str:
    """How much of an interval is the prior, as a share of its variance; "" where it is not told."""
    if each.prior_share is None:
        return ""
    return "; nearly all prior" if is_prior(each) else f"; {100.0 * each.prior_share:.0f} % prior"


def first_of_channels(entries: Iterable[RecordResult]) -> list[RecordResult]:
    """Return the first of each channel, and of the motions that were inferred together."""
    first: dict[tuple, RecordResult] = {}
    for entry in entries:
        first.setdefault((entry.phase, *entry.fit.motions), entry)
    return list(first.values())


def is_prior(each: Value) -> bool:
    """Whether a record says hardly anything of a parameter, so that its interval is the prior's."""
    return (each.prior_share or 0.0) >= _PRIOR


def _both(found: RecordResult | Together) -> tuple[dict, dict]:
    """What is measured of a record, or of several, or is not shown; and what is inferred."""
    drawn = {n: each for n, each in found.quantities.items() if each.source == "inferred"}
    others = {n: each for n, each in found.quantities.items() if n not in drawn}
    alone = {n: each for n, each in others.items() if not starred(each)}
    return alone | others, found.parameters | drawn


def _short(record: RecordResult) -> Section:
    """A section of a few lines, what is measured first."""
    parts: list = []
    for title, some in zip(("", "inferred"), _both(record), strict=True):
        cells = [
            f"{n} {_number(e.median)}{'*' * (not title and starred(e))} ±{in_digits(e.half, 2)}"
            for n, e in some.items()
            if e.median is not None
        ]
        parts += [f"  {title}:"] if cells and title else []
        cells += [""] * (-len(cells) % _CELLS)
        rows = [cells[k : k + _CELLS] for k in range(0, len(cells), _CELLS)]
        parts.append(Table(rows=rows, form=_SHORT))
        parts += [Remark(f"no {n}: {each.reason}") for n, each in some.items() if each.reason]
    return Section(_title(record), [*parts, *limit_tables(record.limits or ()), *_ending(record)])


def starred(each: QuantityValue) -> bool:
    """Whether the model has a part in a quantity."""
    return each.source not in ("measured", None)


def limit_tables(limits: Sequence[Verdict]) -> list[Table]:
    """Return a table of verdicts, a row for each limit, or for each quantity of it; or none."""
    rows: list = []
    for limit in limits:
        first = limit.name, limit.verdict
        for part in limit.parts:
            passes = f"{part.quantity} {bounds_in_words(part)} {_unit(part.unit)}"
            rows.append((*first, *_numbers(part.value, part.interval_95), passes.rstrip()))
            first = "", ""
        several = f"fails where {limit.words}" if len(limit.parts) > 1 else ""
        rows += [Remark(e, " " * 23, " " * 23) for e in (str(limit.reason or ""), several) if e]
    head = ("limit", "verdict", "value", "95 % interval", "passes")
    return [Table(head, rows, form=_LIMIT)] if limits else []


def bounds_in_words(part: JudgedPart) -> str:
    """Which values of a quantity pass."""
    low, high = (None if each is None else _number(each) for each in part.bounds)
    return f"{low} to {high}" if low and high else f"up to {high}" if high else f"from {low}"


def _title(record: RecordResult) -> str:
    known = record.about
    about = [f"operation {record.operation}"] if {"phase", "date"} & known.keys() else []
    about += [str(known[name]) for name in ("breaker", "phase", "date") if known.get(name)]
    part = [f"{name} {at:.0f}" for name, at in record.part.items()]
    about += [f"{' '.join(part)} ms"] if part else []
    return ", ".join([f"{record.file}: {record.motion}", *about])


def _row(name: str, each: Value, last: str) -> tuple[str, ...]:
    return (name, *_numbers(each.median, each.interval_95), _unit(each.unit), last)


def _numbers(value: float | None, ends: Sequence[float]) -> tuple[str, str]:
    """A value and its interval, or where it is missing."""
    return ("-", "") if value is None else (_number(value), _interval(ends))


def _unit(unit: str) -> str:
    return "" if unit == "1" else unit


def _ending(record: RecordResult) -> list[Remark]:
    """Whether the answer can be trusted, what is doubtful, and the verdict."""
    fit, said = record.fit, [_fit(record.fit)]
    if fit.contact_surprise is not None:
        how = "agree" if abs(fit.contact_surprise) <= SURPRISING else "do NOT agree"
        about = f"{in_digits(fit.contact_time, 4)} ms after the first motion"
        event, off = EVENTS[record.motion], f"{fit.contact_surprise:+.1f} sd"
        said.append(f"recorded {event} {about}, {off} from the inferred one: they {how}")
    if fit.why_unresolved:
        said.append(
            f"NOT resolved ({fit.why_unresolved}): {FEW_DRAWS}. Check them; if they are right, "
            "train a network with this prior by the workflow, and name it: --model FILE"
        )
    said += [f"remark: {each}" for each in record.remarks]
    if record.verdict:
        names = [each.name for each in record.limits if each.verdict == record.verdict]
        said.append(f"{record.verdict.upper()}: {', '.join(names)}")
    return [*map(Remark, said)]


def how_it_fits(p_value: float, misfit: bool) -> str:
    """Return how a record fits a family, in words that the family's name follows."""
    return "OUT OF" if misfit else "at the edge of" if p_value < _EDGE else "fits"


def _fit(fit: Fit) -> str:
    said = f"{how_it_fits(fit.p_value, fit.misfit)} the family {fit.family} ({in_p(fit.p_value)})"
    if not fit.misfit:
        return said
    where = differs_in_words(fit.parts)
    return (
        f"{said}{'; ' * bool(where)}{where}. So nothing is inferred, and what is measured stands. "
        "Look at --plot; is a unit, endurance.format or the named motion wrong? If the record is "
        "right, train a family with wider ranges than those of config/any.yaml"
    )


def differs_in_words(parts: Mapping[str, float | None]) -> str:
    """Say in which parts of a motion a record differs from a family; nothing where in none."""
    far = {name: each for name, each in parts.items() if each is not None and each > 1.0}
    where = ", ".join(f"{name}, {in_digits(each, 2)} times" for name, each in far.items())
    return f"it differs more than 99 % of its drives do in: {where}" if where else ""


def _together(motion: str, found: Together) -> Section:
    """What several records have in common: their spread, beside the width of one."""
    rows: list = []
    for title, some in zip(("", "inferred"), _both(found), strict=True):
        if title and any(each.told for each in some.values()):
            rows.append(title)
        for name, each in some.items():
            if not title or each.told:
                rows.append((name, *_shared(each)))
                said = (f"{n} without: {reason}" for reason, n in each.reasons.items())
                rows += [Remark(each, " " * 4) for each in said]
    for name, counts in (found.limits or {}).items():
        said = ", ".join(f"{counts[each]} {each}" for each in VERDICTS[::-1] if counts[each])
        rows.append(f"  limit {name}: {said}")
    head = ("", "median", "lowest to highest", "sd", "95 % of one", "", "")
    title = f"{found.records} records of {motion}"
    return Section(title, [Table(head, rows, form=_SHARED)])


def _shared(each: Spread) -> tuple[str, ...]:
    """Spread of a parameter or quantity over records, and how many of them tell it."""
    numbers = ["-", "", "", ""]
    if each.told:
        sd = "" if each.sd is None else in_digits(each.sd, 2)
        span, half = _interval([each.lowest, each.highest]), in_digits(each.half_interval_95, 2)
        numbers = [_number(each.median), span, sd, f"±{half}"]
    return *numbers, _unit(each.unit), f"{each.told} of {each.of}" if each.reasons else ""


def _number(value: float) -> str:
    return in_digits(value, 4)


def _interval(ends: Sequence[float]) -> str:
    """Ends of an interval, with as many digits as set them apart."""
    texts = ([in_digits(end, digits) for end in ends] for digits in range(4, 8))
    return " to ".join(next((each for each in texts if each[0] != each[1]), map(_number, ends)))
