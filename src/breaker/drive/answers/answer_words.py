"""An answer in words, for a terminal of 100 columns."""

from collections.abc import Mapping, Sequence

from breaker.common.numerals import in_digits, in_p
from breaker.drive.answers.limit_verdicts import VERDICTS
from breaker.drive.answers.number_sources import place_lines
from breaker.reading.files.safe_text import wrapped

_ROW = "  {:<14} {:>8}  {:<20} {:<7} {}"
_CELLS, _CELL = 3, 31  # of a line of a short block, and letters of each
_EDGE = 0.02  # p-value, below which a record is at the edge of a family
_THERE = 0.9  # probability from which on a mechanism is there; from 1 less it on it is not
_PRIOR = 0.8  # share of the prior's variance, from which on a record says hardly anything
_LIMIT = "  {:<20} {:<9} {:>8}  {:<20} {}"


def in_words(document: Mapping) -> str:
    """Return a document of ``answer_document.document`` as text: a block for each record.

    The blocks are short where there are several files.
    """
    records = document["records"]
    files = {each["file"] for each in records}
    block = _short if len(files) > 1 else _long
    head = _drive(document) if any(each["accepted"] for each in records) else []
    if head and block is _short:
        head.append(
            "± is half of a 95 % interval, * by the model's touch or parting; --json, --output and "
            "--draws have all numbers"
        )
    parts = ["\n".join(head)] if head else []
    for file in dict.fromkeys(each["file"] for each in records):
        there = [each for each in records if each["file"] == file]
        blocks = [block(each) if each["accepted"] else _rejected(each, there) for each in there]
        parts += map("\n".join, blocks)
    parts += ["\n".join(_together(motion, each)) for motion, each in document["together"].items()]
    parts += ["\n".join(_mean(each)) for each in document["means"]]
    return "\n\n".join(parts)


def _mean(found: Mapping) -> list[str]:
    """What the means of several records tell of a pole."""
    of = " and ".join(f"{n} {motion}{'s' * (n > 1)}" for motion, n in found["records"].items())
    about = ", ".join(str(found[name]) for name in ("breaker", "phase") if found.get(name))
    lines = [f"inferred from the mean of {of}{' of ' * bool(about)}{about}"]
    if found["resolved"]:
        for name, each in found["parameters"].items():
            told = f"{each['meaning']}{_of_prior(each)}"
            lines += _row(name, each, each.get("reason") or told)
        lines += _mechanisms(found)
    said = [f"remark: {each}" for each in found["remarks"]]
    said += [] if found["resolved"] else ["NOT resolved: too few draws are left"]
    return [*lines, *(line for each in said for line in wrapped(each))]


def _drive(document: Mapping) -> list[str]:
    said = [f"WARNING: {each}" for each in document["warnings"]] + document["drive"]["words"]
    return [line for each in said for line in wrapped(each, "", "  ")]


def _rejected(record: Mapping, of_file: Sequence[Mapping]) -> list[str]:
    """A block that says why. Of which motion only where the file has another one."""
    title = _title(record) if len(of_file) > 1 else record["file"]
    return [title, *wrapped(f"rejected: {record['reason']}")]


def _long(record: Mapping) -> list[str]:
    """A block with everything that is known of a record, what is measured first."""
    lines = [_title(record), _ROW.format("", "value", "95 % interval", "", "").rstrip()]
    measured, inferred = _both(record)
    for name, each in measured.items():
        lines += _row(name, each, each["source"] or each["reason"])
    together = " of both motions together" if len(record["fit"]["motions"]) > 1 else ""
    if record["fit"]["resolved"]:
        lines.append(f"inferred{together}")
        for name, each in inferred.items():
            lines += _row(name, each, each.get("reason") or f"{each['meaning']}{_of_prior(each)}")
        lines += _mechanisms(record)
    lines += limit_lines(record.get("limits", []))
    return [*lines, *place_lines(record), *_ending(record)]


def present(found: Mapping) -> dict[str, Mapping]:
    """Return the mechanisms beside the model that a drive has for sure, by name."""
    every = found["mechanisms"].items()
    return {name: each for name, each in every if each["probability"] >= _THERE}


def _mechanisms(found: Mapping) -> list[str]:
    """What the drive has beside the model for sure, and what it may have or has not."""
    there, perhaps, absent = present(found), [], []
    for name, each in found["mechanisms"].items():
        if name not in there and each["probability"] > 1.0 - _THERE:
            perhaps.append(f"{name} {100.0 * each['probability']:.0f} %")
        elif name not in there:
            absent.append(name)
    lines = ["mechanisms beside the model"] if found["mechanisms"] else []
    lines += [line for n, each in there.items() for line in _row(n, each, each["meaning"])]
    for title, names in (("perhaps", perhaps), ("not there", absent)):
        lines += wrapped(f"{title}: {', '.join(names)}") if names else []
    return lines


def _of_prior(each: Mapping) -> str:
    """How much of an interval is the prior, as a share of its variance; "" where it is not told."""
    share = each.get("prior_share")
    if share is None:
        return ""
    return "; nearly all prior" if is_prior(each) else f"; {100.0 * share:.0f} % prior"


def is_prior(each: Mapping) -> bool:
    """Whether a record says hardly anything of a parameter, so that its interval is the prior's."""
    return (each.get("prior_share") or 0.0) >= _PRIOR


def _both(found: Mapping) -> tuple[dict, dict]:
    """What is measured of a record, or of several, or is not shown; and what is inferred."""
    drawn = {n: each for n, each in found["quantities"].items() if each["source"] == "inferred"}
    others = {n: each for n, each in found["quantities"].items() if n not in drawn}
    alone = {n: each for n, each in others.items() if not starred(each)}
    return alone | others, found["parameters"] | drawn


def _short(record: Mapping) -> list[str]:
    """A block of a few lines, what is measured first."""
    lines = [_title(record)]
    for title, some in zip(("", "inferred"), _both(record), strict=True):
        known = {n: each for n, each in some.items() if each["median"] is not None}
        cells = [
            f"{n} {_number(e['median'])}{'*' * (not title and starred(e))} ±{_half(e)}"
            for n, e in known.items()
        ]
        if cells and title:
            lines.append(f"  {title}:")
        for begin in range(0, len(cells), _CELLS):
            row = "".join(f"{cell:<{_CELL}} " for cell in cells[begin : begin + _CELLS])
            lines.append(f"  {row}".rstrip())
        missing = {n: each["reason"] for n, each in some.items() if each.get("reason")}
        lines += [line for n, each in missing.items() for line in wrapped(f"no {n}: {each}")]
    return [*lines, *limit_lines(record.get("limits", [])), *_ending(record)]


def starred(each: Mapping) -> bool:
    """Whether the model has a part in a quantity."""
    return each["source"] not in ("measured", None)


def _half(each: Mapping) -> str:
    low, high = each["interval_95"]
    return in_digits((high - low) / 2.0, 2)


def limit_lines(limits: Sequence[Mapping]) -> list[str]:
    """Return the table of verdicts: a line for each limit, or for each quantity of it."""
    lines = [_LIMIT.format("limit", "verdict", "value", "95 % interval", "passes").rstrip()]
    for limit in limits:
        first = limit["name"], limit["verdict"]
        for part in limit["parts"]:
            numbers = "-", ""
            if part["value"] is not None:
                numbers = _number(part["value"]), _interval(part["interval_95"])
            passes = f"{part['quantity']} {bounds_in_words(part)} {_unit(part)}"
            lines.append(_LIMIT.format(*first, *numbers, passes).rstrip())
            first = "", ""
        several = f"fails where {limit['words']}" if len(limit["parts"]) > 1 else ""
        said = filter(None, (limit["reason"], several))
        lines += [line for each in said for line in wrapped(each, " " * 23, " " * 23)]
    return lines if limits else []


def bounds_in_words(part: Mapping) -> str:
    """Which values of a quantity pass."""
    low, high = (None if each is None else _number(each) for each in part["bounds"])
    return f"{low} to {high}" if low and high else f"up to {high}" if high else f"from {low}"


def _title(record: Mapping) -> str:
    about = [f"operation {record['operation']}"] if "phase" in record or "date" in record else []
    about += [str(record[name]) for name in ("breaker", "phase", "date") if record.get(name)]
    part = [f"{name} {record[name]:.0f}" for name in ("from", "to") if name in record]
    about += [f"{' '.join(part)} ms"] if part else []
    return ", ".join([f"{record['file']}: {record['motion']}", *about])


def _row(name: str, each: Mapping, last: str) -> list[str]:
    numbers = "-", ""
    if each["median"] is not None:
        numbers = _number(each["median"]), _interval(each["interval_95"])
    line = _ROW.format(name, *numbers, _unit(each), "")
    return [each.rstrip() for each in wrapped(last, line, " " * len(line))]


def _unit(each: Mapping) -> str:
    return "" if each["unit"] == "1" else each["unit"]


def _ending(record: Mapping) -> list[str]:
    """Whether the answer can be trusted, what is doubtful, and the verdict."""
    fit = record["fit"]
    said = [_fit(fit)]
    if fit["far_from_prior"]:
        said.append(_far(record))
    if fit["why_unresolved"]:
        said.append(
            f"NOT resolved ({fit['why_unresolved']}): prior, facts or the contact's time leave "
            "hardly a draw of the network. Check them; if they are right, train a network with "
            "this prior by the workflow, and name it: --model FILE"
        )
    said += [f"remark: {each}" for each in record["remarks"]]
    if record.get("verdict"):
        names = [e["name"] for e in record["limits"] if e["verdict"] == record["verdict"]]
        said.append(f"{record['verdict'].upper()}: {', '.join(names)}")
    return [line for each in said for line in wrapped(each)]


def how_it_fits(p_value: float, misfit: bool) -> str:
    """Return how a record fits a family, in words that the family's name follows."""
    return "OUT OF" if misfit else "at the edge of" if p_value < _EDGE else "fits"


def _fit(fit: Mapping) -> str:
    family = f"the family {fit['family']} ({in_p(fit['p_value'])})"
    if not fit["misfit"]:
        return f"{how_it_fits(fit['p_value'], False)} {family}"
    where = differs_in_words(fit["parts"])
    where = where and f"; {where}"
    return (
        f"OUT OF {family}{where}. So nothing is inferred, and what is measured stands. Look at "
        "--plot; is a unit, endurance.format or the named motion wrong? If the record is right, "
        "train a family with wider ranges than those of config/any.yaml"
    )


def differs_in_words(parts: Mapping[str, float | None]) -> str:
    """Say in which parts of a motion a record differs from a family; nothing where in none."""
    far = {name: each for name, each in parts.items() if each is not None and each > 1.0}
    where = ", ".join(f"{name}, {in_digits(each, 2)} times" for name, each in far.items())
    return f"it differs more than 99 % of its drives do in: {where}" if where else ""


def _far(record: Mapping) -> str:
    """How far a drive lies from a given prior or size that should hold it, with what to do."""
    sds = {name: each["prior_sds"] for name, each in record["parameters"].items()}
    name = max(sds, key=lambda name: abs(sds[name]))
    return (
        f"FAR from the prior ({in_p(record['fit']['prior_p_value'])}): {name} is "
        f"{sds[name]:+.1f} of its sds from its median. Check the size and the unit of each median, "
        "or widen the prior: breaker fit-prior fits one"
    )


def _together(motion: str, found: Mapping) -> list[str]:
    """What several records have in common: their spread, beside the width of one."""
    form = "  {:<14} {:>9}  {:<22} {:>9} {:>12}  {:<7}{}"
    lines = [
        f"{found['records']} records of {motion}",
        form.format("", "median", "lowest to highest", "sd", "95 % of one", "", "").rstrip(),
    ]
    for title, some in zip(("", "inferred"), _both(found), strict=True):
        if title and any(each["told"] for each in some.values()):
            lines.append(title)
        for name, each in some.items():
            numbers = ["-", "", "", ""]
            if each["told"]:
                sd = "" if each["sd"] is None else in_digits(each["sd"], 2)
                half = f"±{in_digits(each['half_interval_95'], 2)}"
                span = _interval([each["lowest"], each["highest"]])
                numbers = [_number(each["median"]), span, sd, half]
            elif title:
                continue
            count = f"{each['told']} of {each['of']}" if each["reasons"] else ""
            lines.append(form.format(name, *numbers, _unit(each), count).rstrip())
            said = (f"{n} without: {reason}" for reason, n in each["reasons"].items())
            lines += [line for each in said for line in wrapped(each, " " * 4)]
    for name, counts in found.get("limits", {}).items():
        said = ", ".join(f"{counts[each]} {each}" for each in VERDICTS[::-1] if counts[each])
        lines.append(f"  limit {name}: {said}")
    return lines


def _number(value: float) -> str:
    return in_digits(value, 4)


def _interval(ends: Sequence[float]) -> str:
    """Ends of an interval, with as many digits as set them apart."""
    texts = ([in_digits(end, digits) for end in ends] for digits in range(4, 8))
    return " to ".join(next((each for each in texts if each[0] != each[1]), map(_number, ends)))
