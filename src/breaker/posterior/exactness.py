"""Corrected posteriors of many records, and the judgement of a network against them.

Each record has a random generator of its own, so that its result does not depend on the other
records.
"""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import xarray as xr
from tqdm import tqdm

from breaker.model import Contact, Model, generator
from breaker.posterior.corrections import correct
from breaker.posterior.laplace import approximate, surprise
from breaker.posterior.predictive import predictive_p_value, summaries
from breaker.posterior.tables import ABSENT
from breaker.posterior.weights import importance

if TYPE_CHECKING:  # corrections need a model alone: torch is not loaded for them
    from breaker.posterior.estimator import Posterior

__all__ = ["correct_operations", "correct_validation", "judge"]

_SURPRISING = 4.0  # sd of a contact's time about what its record leads to expect


def correct_validation(
    model: Model, data: xr.Dataset, settings: Mapping, *, seed: int
) -> xr.Dataset:
    """Correct the draws of simulated records.

    Args:
        data: What ``predictive.validate`` returns.
        settings: The section ``correction`` of the configuration.

    Returns:
        ``data`` with corrected ``draws`` and, over ``curve``, how each came about: ``resolved``,
        ``why_unresolved``, ``rounds`` of adaptation, ``effective_size``, ``efficiency`` and
        ``pareto_k`` of the last weights, ``faulty_weights``, and ``log_evidence`` with its
        standard error ``log_evidence_se``.
    """
    n = data.sizes["curve"]
    records = _Records([model] * n, data.measured.values, data.draws.values, np.arange(n))
    values, found = _correct(records, settings, seed)
    by_curve = {name: ("curve", each) for name, each in found.items()}
    return data.assign(by_curve | {"draws": (data.draws.dims, values)})


def correct_operations(
    model: Model, inferred: xr.Dataset, settings: Mapping, *, seed: int, misfit_p_value: float
) -> xr.Dataset:
    """Correct the draws of measured operations.

    No real drive is the model, and networks have seen no other. Nor do they know what is known
    beside a record. So the correction starts at the mode of the posterior, and from the network's
    draws only where that does not reach it.

    Args:
        inferred: What ``predictive.infer`` returns; operations without a posterior stay so.
        settings: The section ``correction`` of the configuration.
        misfit_p_value: Posterior predictive p-value below which a record counts as misfit.

    Returns:
        ``inferred`` with all that follows from the draws, and what ``correct_validation`` adds.
    """
    models = models_of(model, inferred)
    records = _Records(
        models,
        inferred.travel.values.astype(np.float64),
        inferred.draws.values.astype(np.float64),
        inferred.operation.values,
    )
    values, found = _correct(records, settings, seed, from_mode=True)
    p_value = p_values(model, inferred.travel.values, values)
    by_operation = {name: ("operation", each) for name, each in found.items()}
    by_operation |= judged_contacts(models, inferred, values)
    return inferred.assign(by_operation | summaries(model, values, p_value, misfit_p_value))


def models_of(model: Model, operations: xr.Dataset) -> list[Model]:
    """Return the model of each operation: one that knows when the contact switched, if it is known.

    Args:
        operations: Dataset over ``operation``, where known with ``contact_time`` and ``contact_sd``
            as of ``records.read_curves``.
    """
    n = operations.sizes["operation"]
    if "contact_time" not in operations:
        return [model] * n
    known = zip(operations.contact_time.values, operations.contact_sd.values, strict=True)
    return [
        model
        if np.isnan(time)
        else model.conditioned_on(model.facts, Contact(float(time), float(sd)))
        for time, sd in known
    ]


def judged_contacts(
    models: Sequence[Model], operations: xr.Dataset, values: np.ndarray
) -> dict[str, tuple]:
    """Hold the contact's time of each operation against its record.

    Args:
        operations: Dataset with their ``travel``, and ``remarks`` where there are any.
        values: Their draws, ``(n, d, q)``; nan where there are none.

    Returns:
        Nothing if no such time is known. Else ``contact_surprise``, see ``laplace.surprise``, and
        ``remarks`` with one more where it is large.
    """
    found, said = np.full(len(models), np.nan), np.full(len(models), "", dtype=object)
    if "remarks" in operations:
        said = operations.remarks.values.astype(object)
    for i, model in enumerate(models):
        if model.contact is None or not np.isfinite(values[i]).all():
            continue
        found[i] = surprise(model, operations.travel.values[i].astype(np.float64))
        if abs(found[i]) > _SURPRISING:
            remark = (
                f"the contact's time is {found[i]:+.1f} sd from what the curve leads to expect: is "
                "it of this record, and in its time?"
            )
            said[i] = "; ".join(filter(None, (said[i], remark)))
    if np.isnan(found).all():
        return {}
    return {
        "contact_surprise": ("operation", found),
        "remarks": ("operation", said.astype(str)),
    }


def p_values(model: Model, measured: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Return the predictive p-values of records ``(n, t)`` with draws ``(n, d, q)``, ``(n,)``.

    NaN where a record has no draws.
    """
    found = np.full(len(values), np.nan)
    for i in np.flatnonzero(np.isfinite(values).all(axis=(1, 2))):
        found[i] = predictive_p_value(model, measured[i], values[i])
    return found


class _Records(NamedTuple):
    """Records to correct.

    Attributes:
        models: Joint model of each record.
        measured: Records, ``(n, t)``, mm.
        draws: The network's, ``(n, d, q)``, nan where there are none; those stay without.
        keys: What each record's generator is named by, ``(n,)``.
    """

    models: Sequence[Model]
    measured: np.ndarray
    draws: np.ndarray
    keys: np.ndarray


def _correct(
    records: _Records, settings: Mapping, seed: int, *, from_mode: bool = False
) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Correct records one by one, each with a random generator of its own.

    Args:
        records: The records.
        settings: The section ``correction`` of the configuration.
        seed: Seed of the configuration.
        from_mode: Whether to start at the mode of the posterior, and from the network's draws only
            where that fails.

    Returns:
        Draws, ``(n, d, q)``, and for each name in ``ABSENT`` an array ``(n,)``.
    """
    models, measured, draws, keys = records
    rows = [dict(ABSENT) for _ in keys]
    values = np.full(draws.shape, np.nan)
    present = np.flatnonzero(np.isfinite(draws).all(axis=(1, 2)))
    for i in tqdm(present, desc="correcting", mininterval=5, unit="record"):
        model, start = models[i], draws[i]
        rng = generator(seed, "correction", model.motion, int(keys[i]))
        try:
            about = approximate(model, measured[i], len(start), rng) if from_mode else start
            found = correct(model, measured[i], about, settings, rng)
            if from_mode and not found.resolved:
                again = correct(model, measured[i], start, settings, rng)
                found = max(found, again, key=lambda one: (one.resolved, one.importance.size))
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
    return values, {name: np.array([row[name] for row in rows]) for name in ABSENT}


def judge(posterior: "Posterior", data: xr.Dataset, corrected: xr.Dataset) -> xr.Dataset:
    """Judge a network's draws by its own density against the exact posterior.

    Args:
        data: What ``predictive.validate`` returns: its draws, as many curves as are to be judged.
        corrected: What ``correct_validation`` made of the same curves; gives the evidence.

    Returns:
        Dataset over ``curve``: ``efficiency`` and ``pareto_k`` of the importance weights of the
        network's draws, ``faulty_weights``, ``divergence`` (KL of the exact posterior from the
        network's, by these weights), ``gap`` (``log p - log q`` at the true values, whose mean
        over curves is the mean divergence, whatever the weights), both nats, ``c2st``, how well the
        best classifier tells the two apart, ``log_evidence`` by the network's draws, ``truth_log_density``, the network's log density of the truth per
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
                "c2st": weights.c2st,
                "log_evidence": weights.log_evidence,
                "truth_log_density": log_density[-1],
                "gap": log_joint[-1] - corrected.log_evidence.values[i] - log_density[-1],
            }
        )
    judged = {name: ("curve", np.array([row[name] for row in rows])) for name in rows[0]}
    resolved = ("curve", corrected.resolved.values[: len(rows)])
    return xr.Dataset(judged | {"resolved": resolved}, attrs={"motion": model.motion})
