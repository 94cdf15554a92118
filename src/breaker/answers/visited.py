"""The comparison of two visits as one document of plain values, and in words.

docs/visits.md explains its keys. A number that is not known is None.
"""

from collections.abc import Mapping, Sequence
from textwrap import wrap

import numpy as np
import xarray as xr

from breaker.answers.changed import OF_STROKE, VERDICT_WORDS
from breaker.answers.plain import plainly
from breaker.posterior import Compared, prior_beyond

__all__ = ["measured_changes", "visits_document", "visits_in_words"]

_WIDTH = 98
_ROW = "  {:<26} {:>8} {:>8} {:>8}  {:<15} {:>5} {:>6}  {}"
_MEASURED = ("measured", "measured_sd")
_NORMAL = 1.645  # sds of half a 90 % interval
_UNLIKE = 0.1  # share of the stroke, beyond any wear of the family of drives


def measured_changes(curves: Mapping[str, xr.Dataset], today: Mapping[str, np.ndarray]) -> dict:
    """Return what the records themselves show, by motion and quantity.

    The mean of a visit; its variance is that of the readings or, where larger, of the scatter of
    two records or more.

    Args:
        curves: Accepted records of each motion: see ``records.read_curves``.
        today: Which of them are of the second visit, ``(operation,)`` of bool.
    """
    found = {}
    for motion, each in curves.items():
        rows = {}
        for name in each["quantity"].values.tolist() if "measured" in each else ():
            values, sds = (each[key].sel(quantity=name).values for key in _MEASURED)
            both = [_mean(values[when], sds[when]) for when in (~today[motion], today[motion])]
            if all(both):
                rows[name] = _apart(*both)
        for name, row in rows.items():
            of = rows.get("stroke") if name in OF_STROKE else row
            if of and of["before"]:
                ends = row["difference"] + _NORMAL * row["sd"] * np.array([-1.0, 0.0, 1.0])
                row["change"] = plainly(100.0 * ends / abs(of["before"]))
        found[motion] = rows
    return found


def _mean(values: np.ndarray, sds: np.ndarray) -> tuple[float, float] | None:
    """Mean of readings that are there, and its variance; None if there is none."""
    there = np.isfinite(values)
    count = int(there.sum())
    if not count:
        return None
    known = np.nan_to_num(np.square(sds[there])).sum() / count**2
    scatter = values[there].var(ddof=1) / count if count > 1 else 0.0
    return float(values[there].mean()), float(max(known, scatter))


def _apart(before: tuple[float, float], today: tuple[float, float]) -> dict:
    """A change from mean and variance of both visits."""
    difference, sd = today[0] - before[0], float(np.sqrt(before[1] + today[1]))
    found = {"before": before[0], "today": today[0], "difference": difference, "sd": sd}
    return {key: plainly(value) for key, value in found.items()}


def visits_document(
    parts: Sequence[tuple[Compared, xr.Dataset]],
    curves: Mapping[str, xr.Dataset],
    today: Mapping[str, np.ndarray],
    rejected: Sequence[Mapping],
    drive: Mapping,
    settings: Mapping,
) -> dict:
    """Return a comparison as a document.

    Args:
        parts: Each comparison, and its ``changes``.
        curves, today: As of ``measured_changes``.
        rejected: ``file``, ``visit`` and ``reason`` of records that were not used.
        drive: What is known of the drive as a whole, with a list ``words``.
        settings: What it was made with: ``share``, ``misfit_p_value``, ``seed``, ``discrepancy``.
    """
    measured = measured_changes(curves, today)
    comparisons = [_comparison(*part, measured, settings) for part in parts]
    return {
        "headline": _headline(comparisons, settings["share"]),
        "trust": [*_unlike(measured), *(each["trust"] for each in comparisons)],
        "drive": dict(drive),
        "settings": dict(settings) | {"prior_beyond": plainly(prior_beyond(settings["share"]))},
        "records": {
            motion: {"before": int((~when).sum()), "today": int(when.sum())}
            for motion, when in today.items()
        },
        "measured": measured,
        "rejected": [dict(each) for each in rejected],
        "comparisons": comparisons,
    }


def _comparison(found: Compared, data: xr.Dataset, measured: Mapping, settings: Mapping) -> dict:
    rows = []
    for name in range(data.sizes["name"]):
        row = {key: plainly(each.values[name]) for key, each in data.data_vars.items()}
        row = {"name": str(data["name"].values[name])} | row
        of = [row["motion"]] if row["motion"] else found.motions
        beside = [measured[m][row["name"]] for m in of if row["name"] in measured[m]]
        rows.append(row | {"measured": beside[0] if beside else None})
    misfit = not found.p_value >= settings["misfit_p_value"]
    about = {
        "motions": list(found.motions),
        "resolved": found.resolved,
        "why_unresolved": found.reason,
        "effective_size": plainly(found.importance.size),
        "pareto_k": plainly(found.importance.pareto_k),
        "p_value": plainly(found.p_value),
        "misfit": misfit,
        "agreement": plainly(found.agreement),
    }
    return about | {"trust": _trust(about), "changes": rows}


def _trust(about: Mapping) -> str:
    """How far a comparison can be trusted, in a sentence."""
    motions = " and ".join(about["motions"])
    said = [
        f"the records do NOT fit the model (p = {about['p_value']:.2g}): intervals are too narrow; "
        "look at single records with breaker infer --plot"
        if about["misfit"]
        else f"the records fit the model (p = {about['p_value']:.2g})"
    ]
    if about["resolved"]:
        said.append("exact posterior")
    else:
        said.append(
            f"NOT resolved ({about['why_unresolved']}): intervals are approximate; name more "
            "records of each visit"
        )
    if len(about["motions"]) == 1 and about["agreement"] < 1.0:
        said.append(
            f"closing and opening have different parameters (p = {about['agreement']:.2g}), so "
            "they are compared apart"
        )
    return f"{motions}: {'; '.join(said)}"


def _unlike(measured: Mapping) -> list[str]:
    """A warning where the stroke of both visits is hardly that of one drive."""
    for motion, rows in measured.items():
        if "stroke" not in rows:
            continue
        before, today = rows["stroke"]["before"], rows["stroke"]["today"]
        if abs(today / before - 1.0) > _UNLIKE:
            return [
                f"WARNING: the stroke of {motion} was {before:.4g} mm and is {today:.4g} mm today; "
                "no wear of one drive does that. Are both visits of the same drive and phase, and "
                "is endurance.format right for both?"
            ]
    return []


def _headline(comparisons: Sequence[Mapping], share: float) -> str:
    """Which parameters changed, which did not, which cannot be told; and what changed with them."""
    words: dict[str, list[str]] = {each: [] for each in VERDICT_WORDS}
    with_them = []
    for each in comparisons:
        of = f" of {each['motions'][0]}" if len(comparisons) > 1 else ""
        for row in each["changes"]:
            sure = row["verdict"] == VERDICT_WORDS[0]
            if row["kind"] == "parameter":
                name = f"{row['name']}{of}"
                words[row["verdict"]].append(f"{name} {_percent(row)}" if sure else name)
            elif sure:
                with_them.append(f"{_label(row)} {row['change'][1]:+.2g} %")
    sure, unsure, still = words.values()
    beyond = f"beyond {100 * share:g} %"
    said = [f"Changed: {', '.join(sure)}" if sure else f"No parameter changed for sure {beyond}"]
    if unsure:
        said.append(f"cannot be told: {', '.join(unsure)}")
    if still:
        said.append(f"not {beyond}: {', '.join(still) if unsure else 'all others'}")
    if with_them:
        said.append(f"times, speeds and ways: {', '.join(with_them)}")
    return "; ".join(said)


def _percent(row: Mapping) -> str:
    low, middle, high = row["change"]
    return f"{middle:+.2g} % ({low:+.2g} to {high:+.2g})"


def _label(row: Mapping) -> str:
    return f"{row['name']} ({row['motion']})" if row["name"] == "travel_time" else row["name"]


def visits_in_words(document: Mapping) -> str:
    """Return a document as text for a terminal of 100 columns."""
    share = document["settings"]["share"]
    counts = [
        f"{motion} {each['before']} before, {each['today']} today"
        for motion, each in document["records"].items()
    ]
    prior = document["settings"]["prior_beyond"]
    lines = [
        *_lines(document["headline"], ""),
        *(line for each in document["trust"] for line in _lines(each, "")),
        *_lines(f"records: {'; '.join(counts)}", ""),
        *(line for each in document["drive"]["words"] for line in _lines(each, "")),
        *(
            line
            for each in document["rejected"]
            for line in _lines(f"rejected: {each['file']}: {each['reason']}", "")
        ),
    ]
    for each in document["comparisons"]:
        lines += ["", " and ".join(each["motions"])]
        beyond = f"P>{100 * share:g} %"
        lines.append(
            _ROW.format(
                "", "before", "today", "change", "90 % interval", beyond, "P worse", ""
            ).rstrip()
        )
        lines += map(_in_words, each["changes"])
    lines += ["", *_lines(f"A priori P>{100 * share:g} % is {prior:.2f} of each parameter.", "")]
    return "\n".join(lines)


def _in_words(row: Mapping) -> str:
    if row["change"][1] is None:
        return _ROW.format(_label(row), "-", "-", "-", "does not exist", "", "", "").rstrip()
    low, middle, high = row["change"]
    numbers = (
        *(f"{row[when][1]:.4g}" for when in ("before", "today")),
        *(f"{middle:+.1f} %", f"{low:+.1f} to {high:+.1f}"),
        f"{row['beyond']:.2f}",
        "" if row["worse"] is None else f"{row['worse']:.2f}",
    )
    measured = row["measured"]
    last = f"{measured['difference']:+.2g} ±{measured['sd']:.1g}" if measured else ""
    unit = "" if row["unit"] == "1" else f" ({row['unit']})"
    return _ROW.format(_label(row) + unit, *numbers, last).rstrip()


def _lines(text: str, first: str = "  ") -> list[str]:
    look = {"initial_indent": first, "subsequent_indent": first + "  "}
    return wrap(text, _WIDTH, break_long_words=False, break_on_hyphens=False, **look)
