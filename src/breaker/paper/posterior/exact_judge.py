"""Exact posteriors of simulated records, and the judgement of a network against them.

Each record has a random generator of its own, so that its result does not depend on the other
records.
"""

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr
from tqdm import tqdm

from breaker.common.randomness import generator
from breaker.paper.model.joint_model import Model
from breaker.paper.posterior.exact_correction import correct
from breaker.paper.posterior.importance_weights import importance

if TYPE_CHECKING:  # corrections need a model alone: torch is not loaded for them
    from breaker.paper.posterior.estimator import Posterior

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


def correct_validation(
    model: Model, data: xr.Dataset, settings: Mapping, *, seed: int
) -> xr.Dataset:
    """Correct the draws of simulated records.

    Args:
        data: What ``amortised.validate`` returns.
        settings: The section ``correction`` of the configuration.

    Returns:
        ``data`` with corrected ``draws`` and, over ``curve``, how each came about: ``resolved``,
        ``why_unresolved``, ``rounds`` of adaptation, ``effective_size``, ``efficiency`` and
        ``pareto_k`` of the last weights, ``faulty_weights``, and ``log_evidence`` with its
        standard error ``log_evidence_se``.
    """
    rows = [dict(_ABSENT) for _ in range(data.sizes["curve"])]
    values = np.full(data.draws.shape, np.nan)
    records = zip(data.measured.values, data.draws.values, strict=True)
    progress = tqdm(records, "correcting", len(rows), mininterval=5, unit="curve")
    for i, (record, draws) in enumerate(progress):
        rng = generator(seed, "correction", model.motion, i)
        try:
            found = correct(model, record, draws, settings, rng)
        except (ArithmeticError, RuntimeError, ValueError) as error:
            # One strange record must not end the job of all others.
            rows[i]["why_unresolved"] = f"no exact posterior: {type(error).__name__}: {error}"
            continue
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
    by_curve = {name: ("curve", np.array([row[name] for row in rows])) for name in _ABSENT}
    return data.assign(by_curve | {"draws": (data.draws.dims, values)})


def judge(posterior: "Posterior", data: xr.Dataset, corrected: xr.Dataset) -> xr.Dataset:
    """Judge a network's draws by its own density against the exact posterior.

    Args:
        data: What ``amortised.validate`` returns: its draws, as many curves as are to be judged.
        corrected: What ``correct_validation`` made of the same curves; gives the evidence.

    Returns:
        Dataset over ``curve``: ``efficiency`` and ``pareto_k`` of the importance weights of the
        network's draws, ``faulty_weights``, ``divergence`` (KL of the exact posterior from the
        network's, by these weights), ``gap`` (``log p - log q`` at the true values, whose mean
        over curves is the mean divergence, whatever the weights), both nats, ``c2st``, how well the
        best classifier tells the two apart, ``log_evidence`` by the network's draws,
        ``truth_log_density``, the network's log density of the truth per unit of standardised
        outputs, and ``resolved``, whether the evidence can be relied on.

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
                "c2st": weights.c2st,
                "log_evidence": weights.log_evidence,
                "truth_log_density": log_density[-1],
                "gap": log_joint[-1] - corrected.log_evidence.values[i] - log_density[-1],
            }
        )
    judged = {name: ("curve", np.array([row[name] for row in rows])) for name in rows[0]}
    resolved = ("curve", corrected.resolved.values[: len(rows)])
    return xr.Dataset(judged | {"resolved": resolved}, attrs={"motion": model.motion})
