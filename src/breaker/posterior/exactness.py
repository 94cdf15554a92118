"""Corrected posteriors of many records, and the judgement of a network against them.

Each record is by itself, with a generator of its own, so that its result does not depend on which
others are beside it.
"""

from collections.abc import Mapping
from typing import Protocol

import numpy as np
import pandas as pd
import xarray as xr
from tqdm import tqdm

from breaker.model import Model, generator
from breaker.posterior.corrections import correct
from breaker.posterior.predictive import predictive_p_value, summaries, table
from breaker.posterior.weights import importance

__all__ = [
    "Density",
    "beside",
    "choose",
    "correct_operations",
    "correct_validation",
    "judge",
    "summary",
    "table_of_both",
]

# How the correction of a record came about, and what stands where there was none.
_ABSENT = {
    "resolved": False,
    "why_unresolved": "",
    "rounds": 0,
    "effective_size": np.nan,
    "efficiency": np.nan,
    "pareto_k": np.nan,
    "faulty_weights": 0,
    "log_evidence": np.nan,
    "log_evidence_se": np.nan,
}

# What ``inference.summaries`` makes of draws: there is one for each posterior.
_FROM_DRAWS = (
    "draws",
    "median",
    "interval_50",
    "interval_95",
    "p_value",
    "misfit",
    "outside_support",
)


class Density(Protocol):
    """A posterior with a density of its own; ``estimator.Posterior`` is one."""

    model: Model

    def log_prob(self, values: np.ndarray, measured: np.ndarray) -> np.ndarray:
        """Log density in physical units, ``(o, d, q), (o, t) -> (o, d)``."""


def correct_validation(
    model: Model, data: xr.Dataset, settings: Mapping, *, seed: int
) -> xr.Dataset:
    """Correct the draws of simulated records.

    Args:
        model: Joint model.
        data: What ``inference.validate`` returns.
        settings: The section ``correction`` of the configuration.
        seed: Seed of the correction.

    Returns:
        ``data`` with corrected ``draws`` and, over ``curve``, how each came about: ``resolved``,
        ``why_unresolved``, ``rounds`` of adaptation, ``effective_size``, ``efficiency`` and
        ``pareto_k`` of the last weights, ``faulty_weights``, and ``log_evidence`` with its
        standard error ``log_evidence_se``.
    """
    n = data.sizes["curve"]
    values, found = _correct(
        model, data.measured.values, data.draws.values, np.arange(n), settings, seed
    )
    by_curve = {name: ("curve", each) for name, each in found.items()}
    return data.assign(by_curve | {"draws": (data.draws.dims, values)})


def correct_operations(
    model: Model, inferred: xr.Dataset, settings: Mapping, *, seed: int, misfit_p_value: float
) -> xr.Dataset:
    """Correct the draws of measured operations.

    Args:
        model: Joint model.
        inferred: What ``inference.infer`` returns; operations without a posterior stay so.
        settings: The section ``correction`` of the configuration.
        seed: Seed of the correction.
        misfit_p_value: Posterior predictive p-value below which a record counts as misfit.

    Returns:
        ``inferred`` with all that follows from the draws, and what ``correct_validation`` adds.
    """
    values, found = _correct(
        model,
        inferred.travel.values.astype(np.float64),
        inferred.draws.values.astype(np.float64),
        inferred.operation.values,
        settings,
        seed,
    )
    p_value = np.full(len(values), np.nan)
    for i in np.flatnonzero(np.isfinite(values).all(axis=(1, 2))):
        p_value[i] = predictive_p_value(model, inferred.travel.values[i], values[i])
    by_operation = {name: ("operation", each) for name, each in found.items()}
    return inferred.assign(by_operation | summaries(model, values, p_value, misfit_p_value))


def beside(amortised: xr.Dataset, corrected: xr.Dataset) -> xr.Dataset:
    """Put what ``infer`` and ``correct_operations`` return into one dataset.

    What follows from the draws gets a dimension ``posterior``, "amortised" and "corrected"; the
    rest is shared, and how the correction came about is that of the corrected one.
    """
    drawn = [name for name in _FROM_DRAWS if name in amortised]
    both = xr.concat(
        [amortised[drawn], corrected[drawn]],
        dim=xr.DataArray(["amortised", "corrected"], dims="posterior", name="posterior"),
        join="exact",
    )
    shared = corrected.drop_vars(drawn)
    return shared.assign({name: both[name] for name in drawn}).assign_coords(
        posterior=both.posterior
    )


def choose(result: xr.Dataset, posterior: str) -> xr.Dataset:
    """Take one posterior, "amortised" or "corrected", of what ``beside`` returns."""
    chosen = result.sel(posterior=posterior)
    return chosen if posterior == "corrected" else chosen.drop_vars(list(_ABSENT))


def table_of_both(result: xr.Dataset) -> pd.DataFrame:
    """Return one tidy row for each operation, output and posterior of what ``beside`` returns."""
    parts = []
    for posterior in result.posterior.values:
        rows = table(choose(result, posterior))
        rows.insert(1, "posterior", posterior)
        parts.append(rows)
    return pd.concat(parts).sort_values("operation", kind="stable", ignore_index=True)


def _correct(
    model: Model,
    measured: np.ndarray,
    draws: np.ndarray,
    keys: np.ndarray,
    settings: Mapping,
    seed: int,
) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Correct records one by one; those without draws stay without.

    Args:
        measured: Records, ``(n, t)``, mm.
        draws: The network's, ``(n, d, q)``, nan where there are none.
        keys: What each record's generator is named by, ``(n,)``.

    Returns:
        Draws, ``(n, d, q)``, and for each name in ``_ABSENT`` an array ``(n,)``.
    """
    values = np.full(draws.shape, np.nan)
    rows = [dict(_ABSENT) for _ in keys]
    present = np.flatnonzero(np.isfinite(draws).all(axis=(1, 2)))
    for i in tqdm(present, desc=f"correcting {model.motion}", mininterval=5, unit="record"):
        rng = generator(seed, "correction", model.motion, int(keys[i]))
        found = correct(model, measured[i], draws[i], settings, rng)
        values[i], weights = found.draws, found.importance
        rows[i] = {
            "resolved": found.resolved,
            "why_unresolved": found.reason,
            "rounds": found.rounds,
            "effective_size": weights.size,
            "efficiency": weights.efficiency,
            "pareto_k": weights.pareto_k,
            "faulty_weights": weights.faulty,
            "log_evidence": weights.log_evidence,
            "log_evidence_se": weights.log_evidence_se,
        }
    return values, {name: np.array([row[name] for row in rows]) for name in _ABSENT}


def judge(posterior: Density, data: xr.Dataset, corrected: xr.Dataset) -> xr.Dataset:
    """Judge a network's draws by its own density against the exact posterior.

    Args:
        posterior: The network.
        data: What ``inference.validate`` returns: its draws, as many curves as are to be judged.
        corrected: What ``correct_validation`` made of the same curves; gives the evidence.

    Returns:
        Dataset over ``curve``: ``efficiency`` and ``pareto_k`` of the importance weights of the
        network's draws, ``faulty_weights``, ``divergence`` (KL of the exact posterior from the
        network's, by these weights), ``gap`` (``log p - log q`` at the true values, whose mean
        over curves is the mean divergence, whatever the weights), both nats, ``log_evidence`` by
        the network's draws, ``truth_log_density``, the network's log density of the truth per
        unit of standardised outputs, and ``resolved``, whether the evidence can be relied on.

    Raises:
        ValueError: If the corrected curves are others.
    """
    model, rows = posterior.model, []
    n = data.sizes["curve"]
    if not np.array_equal(corrected.truth.values[:n], data.truth.values):
        raise ValueError("the corrected curves are not those to be judged: validate both anew")
    progress = tqdm(range(n), desc=f"judging {model.motion}", mininterval=5, unit="curve")
    for i in progress:
        record = data.measured.values[i]
        # The truth goes along as one more point.
        values = np.concatenate([data.draws.values[i], data.truth.values[i : i + 1]])
        log_density = posterior.log_prob(values[None], record[None])[0] - model.log_scaling(values)
        log_joint = model.log_joint(model.standardise(values), record)
        weights = importance(log_joint[:-1], log_density[:-1])
        rows.append(
            {
                "efficiency": weights.efficiency,
                "pareto_k": weights.pareto_k,
                "faulty_weights": weights.faulty,
                "divergence": weights.gap,
                "log_evidence": weights.log_evidence,
                "truth_log_density": log_density[-1],
                "gap": log_joint[-1] - corrected.log_evidence.values[i] - log_density[-1],
            }
        )
    judged = {name: ("curve", np.array([row[name] for row in rows])) for name in rows[0]}
    resolved = ("curve", corrected.resolved.values[: len(rows)])
    return xr.Dataset(judged | {"resolved": resolved}, attrs={"motion": model.motion})


def summary(judged: xr.Dataset, corrected: xr.Dataset) -> pd.DataFrame:
    """Sum up what ``judge`` and ``correct_validation`` return, in one row.

    The gap's standard error is that of a mean over curves. Curves whose evidence is not resolved
    have no gap, and those with faulty weights no efficiency: they are left out of these numbers
    (an infinite gap is not), and ``gap_curves`` and ``faulty_curves`` say how many there are.
    """
    gap = judged["gap"].values[judged.resolved.values & ~np.isnan(judged["gap"].values)]
    sound = judged.isel(curve=judged.faulty_weights.values == 0)
    efficiency = sound.efficiency.values if sound.sizes["curve"] else np.array([np.nan])
    numbers = {
        "motion": judged.attrs["motion"],
        "judged_curves": judged.sizes["curve"],
        "faulty_curves": judged.sizes["curve"] - sound.sizes["curve"],
        "efficiency_median": np.median(efficiency),
        "efficiency_10_percent": np.quantile(efficiency, 0.1),
        "efficiency_lowest": efficiency.min(),
        "pareto_k_below_0.7": np.mean(judged.pareto_k.values < 0.7),
        "gap_curves": gap.size,
        "gap_nats": gap.mean() if gap.size else np.nan,
        "gap_se": gap.std(ddof=1) / np.sqrt(gap.size) if gap.size > 1 else np.nan,
        "divergence_nats": sound.divergence.values.mean() if sound.sizes["curve"] else np.nan,
        "truth_log_density": judged.truth_log_density.values.mean(),
        "corrected_curves": corrected.sizes["curve"],
        "resolved": corrected.resolved.values.mean(),
        "corrected_efficiency_median": np.nanmedian(corrected.efficiency.fillna(0.0).values),
        "rounds_mean": corrected.rounds.values.mean(),
    }
    return pd.DataFrame({name: [value] for name, value in numbers.items()})
