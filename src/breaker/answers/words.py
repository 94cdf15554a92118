"""An answer in words, for a terminal of 100 columns."""

from collections.abc import Mapping, Sequence
from textwrap import wrap

from breaker.answers.judgement import VERDICTS

__all__ = ["in_words"]

_WIDTH = 98
_ROW = "  {:<14} {:>8}  {:<20} {:<7} {}"
_CELLS = 3  # of a line of a short block
_SAID = {
    "healthy": "healthy: no limit is exceeded",
    "in doubt": "in doubt: {} may be exceeded",
    "not healthy": "NOT healthy: {} exceeded",
    "unknown": "unknown",
}


def in_words(document: Mapping) -> str:
    """Return a document of ``answers.document`` as text: a block for each record.

    The blocks are short where there are several files.
    """
    records = document["records"]
    files = {each["file"] for each in records}
    block = _short if len(files) > 1 else _long
    head = _drive(document) if any(each["accepted"] for each in records) else []
    if head and block is _short:
        head.append("± is half of a 95 % interval; --json, --output and --draws have all numbers")
    parts = ["\n".join(head)] if head else []
    for file in dict.fromkeys(each["file"] for each in records):
        there = [each for each in records if each["file"] == file]
        blocks = [block(each) if each["accepted"] else _rejected(each, there) for each in there]
        parts += map("\n".join, blocks)
    parts += ["\n".join(_together(motion, each)) for motion, each in document["together"].items()]
    return "\n\n".join(parts)


def _drive(document: Mapping) -> list[str]:
    scale = document["settings"]["discrepancy"]
    error = (
        "the model is taken for right (endurance.discrepancy is 0)"
        if not scale
        else f"the model may be wrong as it is of drives of the family, times {scale:g}"
        if scale != 1
        else "the model may be wrong as it is of drives of the family"
    )
    said = [
        *document["drive"]["words"],
        f"{error}; intervals allow for it" if scale else error,
        "times, speeds and ways are those of the model, without stops; measured is what the record "
        "itself shows, which limits of a catalogue are about",
    ]
    return [line for each in said for line in _lines(each, "", "  ")]


def _rejected(record: Mapping, of_file: Sequence[Mapping]) -> list[str]:
    """A block that says why. Of which motion only where the file has another one."""
    title = _title(record) if len(of_file) > 1 else record["file"]
    return [title, *_lines(f"rejected: {record['reason']}")]


def _long(record: Mapping) -> list[str]:
    """A block with everything that is known of a record."""
    lines = [_title(record)]
    lines.append(_ROW.format("", "median", "95 % interval", "", "").rstrip())
    for name, each in record["parameters"].items():
        lines.append(_row(name, each, each["meaning"]))
    for name, each in record["quantities"].items():
        lines.append(_row(name, each, _measured(each)))
    lines += _errors(record["model_error"])
    if record.get("limits"):
        lines.append(_ROW.format("limit", "exceeded", "", "", "").rstrip())
        for each in record["limits"]:
            number = "" if each["probability"] is None else f"{100 * each['probability']:.0f} %"
            lines.append(f"  {each['name']:<14} {number:>9}  {each['words']}: {each['verdict']}")
    return [*lines, *_ending(record)]


def _short(record: Mapping) -> list[str]:
    """A block of a few lines."""
    lines = [_title(record)]
    cells = [
        f"{name} {_number(each['median'])} ±{_half(each['interval_95']):.2g}"
        for name, each in (record["parameters"] | record["quantities"]).items()
        if each["median"] is not None and name != "onset"
    ]
    width = (_WIDTH - 2) // _CELLS
    for begin in range(0, len(cells), _CELLS):
        row = "".join(f"{cell:<{width - 1}} " for cell in cells[begin : begin + _CELLS])
        lines.append(f"  {row}".rstrip())
    measured = [
        f"{name} {_number(each['measured'])}"
        for name, each in record["quantities"].items()
        if each.get("measured") is not None
    ]
    if measured:
        lines += _lines(f"measured: {', '.join(measured)}")
    return [*lines, *_ending(record)]


def _title(record: Mapping) -> str:
    about = [f"operation {record['operation']}"] if "phase" in record or "date" in record else []
    about += [str(record[name]) for name in ("breaker", "phase", "date") if record.get(name)]
    return ", ".join([f"{record['file']}: {record['motion']}", *about])


def _row(name: str, each: Mapping, last: str) -> str:
    unit = "" if each["unit"] == "1" else each["unit"]
    if each["median"] is None:
        if each.get("undefined") is None:
            return _ROW.format(name, "-", "not the model's", unit, last).rstrip()
        return _ROW.format(name, "-", "does not exist", unit, last).rstrip()
    interval = _interval(each["interval_95"])
    return _ROW.format(name, _number(each["median"]), interval, unit, last).rstrip()


def _measured(each: Mapping) -> str:
    if each.get("measured") is None:
        return ""
    sd = each["measured_sd"]
    return f"measured {_number(each['measured'])}" + (f" ± {sd:.2g}" if sd else "")


def _errors(phases: Mapping[str, Mapping]) -> list[str]:
    """How far the model can be wrong, a line for each phase; none where it is taken for right."""
    if not any(each["family_99"] for each in phases.values()):
        return []
    lines = [_ROW.format("model error", "median", "90 % interval", "", "drives of the family")]
    for name, each in phases.items():
        usual = f"{each['family_median']:.2g} (99 %: {each['family_99']:.2g})"
        interval = " to ".join(f"{end:.2g}" for end in each["interval_90"])
        numbers = f"{each['median']:.2g}", interval, each["unit"]
        lines.append(_ROW.format(name, *numbers, usual))
    return lines


def _ending(record: Mapping) -> list[str]:
    """Whether the answer can be trusted, what is doubtful, and the verdict."""
    fit = record["fit"]
    said = [
        _fit(fit),
        *_far(record),
        *_doubts(fit),
        *(f"remark: {each}" for each in record["remarks"]),
    ]
    if fit.get("latch_time") is not None:
        said.append(
            f"latch time {_number(fit['latch_time'])} ms, from the trigger to the first motion"
        )
    if record.get("verdict"):
        names = [e["name"] for e in record["limits"] if e["verdict"] == record["verdict"]]
        said.append(_SAID[record["verdict"]].format(", ".join(names)))
    return [line for each in said for line in _lines(each)]


def _fit(fit: Mapping) -> str:
    if fit["p_value"] is None:
        return "no draw of its posterior could be compared with the record"
    found = "does NOT fit the model" if fit["misfit"] else "fits the model"
    if fit["far_from_prior"] and not fit["misfit"]:
        found = "does NOT fit the prior, though the model"
    exact = ", exact posterior" if fit.get("resolved") else ""
    return f"{found} (posterior predictive p = {fit['p_value']:.2g}){exact}"


def _far(record: Mapping) -> list[str]:
    """How far a drive lies from the prior that should expect it, with what to do."""
    fit = record["fit"]
    if not fit["far_from_prior"]:
        return []
    sds = {name: each["prior_sds"] or 0.0 for name, each in record["parameters"].items()}
    name = max(sds, key=lambda name: abs(sds[name]))
    return [
        f"FAR from the prior (p = {fit['prior_p_value']:.2g}): {name} is {sds[name]:+.1f} of its "
        "sds from its median. Check the unit of each median, or widen the prior: breaker fit-prior "
        "fits one"
    ]


def _doubts(fit: Mapping) -> list[str]:
    """What to know beside the intervals, with what to do."""
    doubts = []
    if fit.get("resolved") is False:
        why = f" ({fit['why_unresolved']})" if fit.get("why_unresolved") else ""
        doubts.append(
            f"NOT resolved{why}: the exact posterior was not reached, and these intervals are not "
            "its own. Start from a network trained for this drive: --model FILE"
        )
    if fit["misfit"]:
        doubts.append(
            "the intervals are too narrow for such a record: look at --plot, and set "
            "endurance.discrepancy to 2 or widen the family (rigs)"
        )
    if fit.get("outside_prior"):
        doubts.append("OUTSIDE what the prior can produce: the network does not know such a curve")
    if fit.get("completed") and "resolved" not in fit:
        doubts.append(
            f"approximate: {fit['missing']} samples are missing, which the network was given as "
            "drawn from the others; endurance.posterior: corrected is exact"
        )
    if fit["far_onset"]:
        doubts.append("the motion begins FAR from where it was read: beyond 4 sensor.onset_sd")
    return doubts


def _together(motion: str, found: Mapping) -> list[str]:
    """What several records have in common: their spread, beside the width of one."""
    form = "  {:<14} {:>9}  {:<22} {:>9} {:>12}  {}"
    lines = [
        f"{found['records']} records of {motion}",
        form.format("", "median", "lowest to highest", "sd", "95 % of one", "").rstrip(),
    ]
    for name, each in (found["parameters"] | found["quantities"]).items():
        if each["median"] is None:
            continue
        unit = "" if each["unit"] == "1" else each["unit"]
        span = _interval([each["lowest"], each["highest"]])
        numbers = _number(each["median"]), span, f"{each['sd']:.2g}"
        lines.append(form.format(name, *numbers, f"±{each['half_interval_95']:.2g}", unit).rstrip())
    for name, counts in found.get("limits", {}).items():
        said = ", ".join(f"{counts[each]} {each}" for each in VERDICTS[::-1] if counts[each])
        lines.append(f"  limit {name}: {said}")
    return lines


def _number(value: float) -> str:
    return f"{value:.4g}"


def _interval(ends: Sequence[float]) -> str:
    return f"{_number(ends[0])} to {_number(ends[1])}"


def _half(ends: Sequence[float]) -> float:
    return (ends[1] - ends[0]) / 2.0


def _lines(text: str, first: str = "  ", indent: str = "    ") -> list[str]:
    look = {"initial_indent": first, "subsequent_indent": indent}
    return wrap(text, _WIDTH, break_long_words=False, break_on_hyphens=False, **look)
