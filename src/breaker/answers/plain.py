"""An answer as one document of plain values: what is printed, and with ``--json`` written.

docs/usage.md explains its keys. A number that is not known is None.
"""

from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr

from breaker.answers.judgement import VERDICTS
from breaker.files import known_about
from breaker.mechanism import ONSET, PARAMETERS

__all__ = ["document"]

_MEANINGS = {each.name: each.meaning for each in (*PARAMETERS, ONSET)}
_FEWEST = 2  # records that are summed up together


def document(
    answers: Mapping[str, xr.Dataset], drive: Mapping[str, object], settings: Mapping[str, object]
) -> dict:
    """Return answers as a document.

    Args:
        answers: By motion, with quantities and trust, and with limits where there are any.
        drive: What is known of the drive as a whole: goes into the document as it is.
        settings: What the answers were made with: the same.

    Returns:
        ``{"drive", "settings", "records", "together"}``: a list with one entry for each record, and
        what several records of a motion have in common.
    """
    records = [
        _record(answer.isel(operation=i))
        for answer in answers.values()
        for i in range(answer.sizes["operation"])
    ]
    together = {motion: _together(answer) for motion, answer in answers.items()}
    return {
        "drive": dict(drive),
        "settings": dict(settings),
        "records": records,
        "together": {motion: each for motion, each in together.items() if each},
    }


def _record(one: xr.Dataset) -> dict:
    """One record; what it lacks is left out."""
    known = known_about(one.expand_dims("operation"))
    found = {
        "file": str(one.file.item()),
        "motion": one.attrs["motion"],
        "operation": int(one.operation.item()),
        **{name: _plain(one[name].item()) for name in known},
        "accepted": bool(one.accepted.item()),
        "reason": str(one.reason.item()) or None,
        "remarks": list(filter(None, str(one.remarks.item()).split("; "))),
    }
    if not found["accepted"]:
        return found
    found |= {
        "parameters": _parameters(one),
        "quantities": _quantities(one),
        "model_error": _errors(one),
        "fit": {
            name: _plain(one[name].item())
            for name in (
                *("p_value", "misfit", "far_onset", "missing", "masked", "noise", "outside_prior"),
                *("completed", "resolved", "why_unresolved", "effective_size", "pareto_k"),
            )
            if name in one
        },
    }
    if "limit" in one.coords:
        found["limits"] = _limits(one)
        verdicts = [each["verdict"] for each in found["limits"]]
        found["verdict"] = max(verdicts, key=VERDICTS.index, default=None)
    return found


def _parameters(one: xr.Dataset) -> dict:
    return {
        name: {
            "unit": unit,
            "meaning": _MEANINGS[name],
            "median": _plain(one["median"].values[k]),
            "interval_50": _plain(one.interval_50.values[k]),
            "interval_95": _plain(one.interval_95.values[k]),
        }
        for k, (name, unit) in enumerate(
            zip(one.output.values.tolist(), one.output_unit.values.tolist(), strict=True)
        )
    }


def _quantities(one: xr.Dataset) -> dict:
    found = {}
    for k, name in enumerate(one["quantity"].values.tolist()):
        found[name] = {
            "unit": str(one.quantity_unit.values[k]),
            "meaning": str(one.quantity_meaning.values[k]),
            "median": _plain(one.quantity_median.values[k]),
            "interval_95": _plain(one.quantity_interval.values[k]),
            "undefined": _plain(one.quantity_undefined.values[k]),
        }
        if "measured" in one:
            found[name]["measured"] = _plain(one.measured.values[k])
            found[name]["measured_sd"] = _plain(one.measured_sd.values[k])
    return found


def _errors(one: xr.Dataset) -> dict:
    place = {float(level): i for i, level in enumerate(one["quantile"].values)}
    ends = [place[0.05], place[0.95]]
    return {
        phase: {
            "unit": "mm",
            "median": _plain(one.model_error.values[k, place[0.5]]),
            "interval_90": _plain(one.model_error.values[k, ends]),
            "family_median": _plain(one.family_error.values[k, place[0.5]]),
            "family_99": _plain(one.family_error.values[k, place[0.99]]),
            "share_of_residual": _plain(one.explained.values[k]),
        }
        for k, phase in enumerate(one["part"].values.tolist())
    }


def _limits(one: xr.Dataset) -> list[dict]:
    return [
        {"name": name, "words": words, "probability": _plain(probability), "verdict": verdict}
        for name, words, probability, verdict in zip(
            *(one[name].values.tolist() for name in ("limit", "limit_words")),
            *(one[name].values.tolist() for name in ("exceeded", "limit_verdict")),
            strict=True,
        )
    ]


def _together(answer: xr.Dataset) -> dict:
    """What the inferred records of a motion have in common; nothing of fewer than two."""
    there = answer.isel(operation=np.isfinite(answer["median"].values).all(axis=1))
    if there.sizes["operation"] < _FEWEST:
        return {}
    groups = [
        ("parameters", "output", there["median"].values, there.interval_95.values),
        ("quantities", "quantity", there.quantity_median.values, there.quantity_interval.values),
    ]
    found: dict = {"records": there.sizes["operation"]}
    for group, dim, medians, intervals in groups:
        units = there[f"{dim}_unit"].values.tolist()
        found[group] = {
            name: {"unit": unit} | _spread(medians[:, k], intervals[:, k])
            for k, (name, unit) in enumerate(zip(there[dim].values.tolist(), units, strict=True))
        }
    if "limit" in there.coords:
        found["limits"] = {
            name: {
                verdict: int((there.limit_verdict.values[:, k] == verdict).sum())
                for verdict in VERDICTS
            }
            for k, name in enumerate(there.limit.values.tolist())
        }
    return found


def _spread(medians: np.ndarray, intervals: np.ndarray) -> dict:
    """Of medians ``(n,)`` and intervals ``(n, 2)``, as far as they are known."""
    known = np.isfinite(medians)
    if known.sum() < _FEWEST:
        return dict.fromkeys(("median", "lowest", "highest", "sd", "half_interval_95"))
    medians, half = medians[known], np.diff(intervals[known])[:, 0] / 2.0
    return {
        "median": _plain(np.median(medians)),
        "lowest": _plain(medians.min()),
        "highest": _plain(medians.max()),
        "sd": _plain(medians.std(ddof=1)),
        "half_interval_95": _plain(np.median(half)),
    }


def _plain(value: object) -> object:
    """A number, flag, text or list of them as JSON has it, numbers to six digits."""
    if isinstance(value, np.ndarray | Sequence) and not isinstance(value, str):
        return [_plain(each) for each in value]
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, float):
        return float(f"{value:.6g}") if np.isfinite(value) else None
    return value
