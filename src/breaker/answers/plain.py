"""An answer as one document of plain values: what is printed, and with ``--json`` written.

docs/usage.md explains its keys. A number that is not known is None.
"""

from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr

from breaker.answers.judgement import VERDICTS
from breaker.files import known_about
from breaker.mechanism import ONSET, PARAMETERS

__all__ = ["document", "plainly"]

_MEANINGS = {each.name: each.meaning for each in (*PARAMETERS, ONSET)}
_FIT = (
    *("prior_p_value", "far_from_prior"),
    *("p_value", "misfit", "far_onset", "missing", "masked", "noise", "outside_prior"),
    *("completed", "resolved", "why_unresolved", "effective_size", "pareto_k"),
    *("contact_time", "contact_sd", "contact_surprise", "latch_time"),
)
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
    together = {motion: _together(answer) for motion, answer in answers.items()}
    return {
        "drive": dict(drive),
        "settings": dict(settings),
        "records": [record for answer in answers.values() for record in _records(answer)],
        "together": {motion: each for motion, each in together.items() if each},
    }


def _records(answer: xr.Dataset) -> list[dict]:
    """One entry for each record; what it lacks is left out."""
    # Plain lists first: to take one record out of a dataset takes as long as to infer it.
    about = ("file", "operation", *known_about(answer))
    fit = [name for name in _FIT if name in answer]
    columns = {name: plainly(answer[name].values) for name in (*about, *fit)}
    parts = {"model_error": _errors(answer), "parameters": _parameters(answer)}
    parts["quantities"] = _quantities(answer)
    if "limit" in answer.coords:
        parts["limits"] = _limits(answer)
    records = []
    for i, accepted in enumerate(answer.accepted.values.tolist()):
        record = {name: columns[name][i] for name in about}
        record |= {
            "motion": answer.attrs["motion"],
            "accepted": accepted,
            "reason": str(answer.reason.values[i]) or None,
            "remarks": list(filter(None, str(answer.remarks.values[i]).split("; "))),
        }
        if accepted:
            record["fit"] = {name: columns[name][i] for name in fit}
            record |= {name: each[i] for name, each in parts.items()}
        if accepted and "limits" in parts:
            verdicts = [each["verdict"] for each in record["limits"]]
            record["verdict"] = max(verdicts, key=VERDICTS.index)
        records.append(record)
    return records


def _named(
    names: Sequence[str], about: Mapping[str, Sequence], arrays: Mapping[str, np.ndarray]
) -> list[dict]:
    """For each record what is known of each name, from arrays ``(operation, name, ...)``.

    Args:
        names: Of parameters, quantities or parts of the motion.
        about: What is the same in all records, by key, one for each name.
        arrays: What is not.
    """
    plain = {key: plainly(values) for key, values in arrays.items()}
    count = len(next(iter(plain.values())))
    return [
        {
            name: {key: values[k] for key, values in about.items()}
            | {key: values[i][k] for key, values in plain.items()}
            for k, name in enumerate(names)
        }
        for i in range(count)
    ]


def _parameters(answer: xr.Dataset) -> list[dict]:
    names = answer.output.values.tolist()
    about = {
        "unit": answer.output_unit.values.tolist(),
        "meaning": [_MEANINGS[name] for name in names],
    }
    names_of = ("median", "interval_50", "interval_95", "prior_sds")
    arrays = {name: answer[name].values for name in names_of}
    return _named(names, about, arrays)


def _quantities(answer: xr.Dataset) -> list[dict]:
    about = {name: answer[f"quantity_{name}"].values.tolist() for name in ("unit", "meaning")}
    arrays = {
        "median": answer.quantity_median.values,
        "interval_95": answer.quantity_interval.values,
        "undefined": answer.quantity_undefined.values,
    }
    arrays |= {n: answer[n].values for n in ("measured", "measured_sd") if n in answer}
    return _named(answer["quantity"].values.tolist(), about, arrays)


def _errors(answer: xr.Dataset) -> list[dict]:
    error, family = answer.model_error, answer.family_error
    names = answer["part"].values.tolist()
    arrays = {
        "median": error.sel(quantile=0.5).values,
        "interval_90": error.sel(quantile=[0.05, 0.95]).values,
        "family_median": family.sel(quantile=0.5).values,
        "family_99": family.sel(quantile=0.99).values,
        "share_of_residual": answer.explained.values,
    }
    return _named(names, {"unit": ["mm"] * len(names)}, arrays)


def _limits(answer: xr.Dataset) -> list[list[dict]]:
    names, words = answer.limit.values.tolist(), answer.limit_words.values.tolist()
    probabilities, verdicts = plainly(answer.exceeded.values), answer.limit_verdict.values.tolist()
    keys = ("name", "words", "probability", "verdict")
    return [
        [dict(zip(keys, each, strict=True)) for each in zip(names, words, *row, strict=True)]
        for row in zip(probabilities, verdicts, strict=True)
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
        "median": plainly(np.median(medians)),
        "lowest": plainly(medians.min()),
        "highest": plainly(medians.max()),
        "sd": plainly(medians.std(ddof=1)),
        "half_interval_95": plainly(np.median(half)),
    }


def plainly(value: object) -> object:
    """A number, flag, text or array of them as JSON has it, numbers to six digits."""
    if isinstance(value, np.ndarray):
        value = value.tolist()
    if isinstance(value, list):
        return [plainly(each) for each in value]
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, float):
        return float(f"{value:.6g}") if np.isfinite(value) else None
    return value
