"""What follows from the posterior of each record: quantities, trust in the model, limits.

Each function takes an answer, the dataset over ``operation`` of one motion that
``posterior.infer_exactly`` returns, and adds to it. Records without a posterior have nan.
"""

from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr
from scipy.special import chdtrc

from breaker.decisions import MAY_BE, condition
from breaker.mechanism import (
    NAMES,
    SOURCES,
    SPEEDS,
    Limit,
    Quantity,
    Speed,
    evaluate,
    quantities_of,
)
from breaker.model import Model, generator
from breaker.posterior import quantiles
from breaker.wear import phases

__all__ = ["PHASES", "VERDICTS", "with_limits", "with_quantities", "with_trust"]

PHASES = ("early rise", "main motion", "end")
"""Phases of a motion, as ``wear.phases`` divides it."""

VERDICTS = ("unknown", "healthy", "in doubt", "not healthy")
"""Verdicts on a record, the worst last."""

_LEVELS = (0.05, 0.5, 0.95, 0.99)
_IMPROBABLE = 1e-3  # share of the prior's drives that lie farther out than one that it expects


def with_quantities(answer: xr.Dataset, speeds: Sequence[Speed] = SPEEDS) -> xr.Dataset:
    """Add the quantities of the motion that are no parameters, inferred from these.

    Args:
        answer: Of a motion.
        speeds: How speeds are defined.

    Returns:
        The answer with ``quantity_draws (operation, draw, quantity)``, ``quantity_median`` and
        ``quantity_interval (operation, quantity, bound)``, the central 95 %, of the draws in which
        it exists; ``quantity_undefined (operation, quantity)``, the share of those in which it does
        not; coordinates ``quantity``, ``quantity_unit`` and ``quantity_meaning``. Quantities that
        records alone show are there where any of the answer does, inferred as nan.

    Example:
        >>> draws = np.tile([2.0, 0.045, 0.040, 0.30, 0.12, 0.75, 10.0], (1, 4, 1))
        >>> dims = ("operation", "draw", "output")
        >>> answer = xr.Dataset({"draws": (dims, draws)}, attrs={"motion": "closing"})
        >>> found = with_quantities(answer).quantity_median.sel(quantity="touch_time")
        >>> found.round(2).values
        array([10.09])
    """
    motion = answer.attrs["motion"]
    known, of_model = _told(answer, motion, speeds), list(quantities_of(motion, speeds))
    names = list(known)
    modelled = np.isin(names, of_model)
    draws = answer.draws.values.astype(np.float64)
    values = np.full((*draws.shape[:2], len(names)), np.nan)
    for i in _inferred(answer):
        values[i][:, modelled] = evaluate(of_model, draws[i, :, : len(NAMES)], motion, speeds)
    medians = np.full((len(values), len(names)), np.nan)
    intervals = np.full((*medians.shape, 2), np.nan)
    for i, k in np.argwhere(np.isfinite(values).any(axis=1)):
        found = quantiles(values[i, np.isfinite(values[i, :, k]), k], axis=0)
        medians[i, k], intervals[i, k] = found["median"], found["interval_95"]
    undefined = np.full(medians.shape, np.nan)
    undefined[_inferred(answer)] = np.isnan(values[_inferred(answer)]).mean(axis=1)
    undefined[:, ~modelled] = np.nan
    by = ("operation", "quantity")
    answer = answer.sel(quantity=names) if "quantity" in answer.dims else answer
    return answer.assign(
        quantity_draws=(("operation", "draw", "quantity"), values),
        quantity_median=(by, medians),
        quantity_interval=((*by, "bound"), intervals),
        quantity_undefined=(by, undefined),
    ).assign_coords(
        quantity=names,
        quantity_unit=("quantity", [each.unit for each in known.values()]),
        quantity_meaning=("quantity", [each.meaning for each in known.values()]),
    )


def _told(answer: xr.Dataset, motion: str, speeds: Sequence[Speed]) -> dict[str, Quantity]:
    """Quantities of the model, and those that records alone show, where one of them does."""
    known = quantities_of(motion, speeds)
    if "measured" not in answer:
        return known
    shown = answer["quantity"].values[np.isfinite(answer.measured.values).any(axis=0)]
    every = quantities_of(motion, speeds, SOURCES)
    return {name: each for name, each in every.items() if name in known or name in shown}


def with_trust(answer: xr.Dataset, model: Model, *, seed: int) -> xr.Dataset:
    """Add how far the model can be wrong in each record, by phase of the motion.

    Returns:
        The answer with ``model_error`` and ``family_error (operation, part, quantile)``, mm: root
        mean square of what the model leaves out, of this record by its posterior, and of drives of
        the family with the same parameters; ``explained (operation, part)``, the share of the mean
        square of the residual from the bare model that it makes up; and ``left_out`` and
        ``residual (operation, time)``, mm, both of them at the posterior's mean. All are 0 where
        the model is taken for right, but the residual.

        How far each posterior lies from the prior, which has to hold the drive: ``prior_sds
        (operation, output)``, of each parameter's median, in its sds; ``prior_p_value
        (operation)``, the share of the prior's drives that are farther out than the medians;
        ``far_from_prior (operation)``, whether that is below 0.001, as where a unit is wrong.
    """
    o, t = answer.travel.shape
    error, family = np.zeros((2, o, len(PHASES), len(_LEVELS)))
    explained = np.zeros((o, len(PHASES)))
    left_out, residual = np.zeros((2, o, t))
    for each in (error, family, explained, left_out, residual):
        each[np.setdiff1d(np.arange(o), _inferred(answer))] = np.nan
    for i in _inferred(answer):
        record = answer.travel.values[i].astype(np.float64)
        values = answer.draws.values[i].astype(np.float64)
        curves = model.curves(values)
        bare = curves - model.shift(values)
        where = phases(bare.mean(axis=0), model.sensor.times, model.motion)
        rng = generator(seed, "trust", model.motion, int(answer.operation.values[i]))
        own, zero = _errors(model, record, values, curves, rng)
        residual[i] = record - bare.mean(axis=0) - zero
        left_out[i] = own.mean(axis=0)
        if model.sensor.discrepancy is None:
            continue
        usual = model.shift(values) + model.sensor.discrepancy.sample(values.shape[:1], rng)
        for k, part in enumerate(where):
            error[i, k] = np.quantile(_rms(own[:, part]), _LEVELS)
            family[i, k] = np.quantile(_rms(usual[:, part]), _LEVELS)
            rest = _rms(residual[i, part] - left_out[i, part])
            explained[i, k] = 1.0 - np.square(rest / _rms(residual[i, part]))
    by, p = ("operation", "part", "quantile"), len(NAMES)
    sds = np.full((o, len(model.names)), np.nan)
    sds[:, :p], square = model.prior.distances(np.median(answer.draws.values[..., :p], axis=1))
    improbable = chdtrc(p, square)
    return answer.assign(
        prior_sds=(("operation", "output"), sds),
        prior_p_value=("operation", improbable),
        far_from_prior=("operation", improbable < _IMPROBABLE),
        model_error=(by, error, {"unit": "mm"}),
        family_error=(by, family, {"unit": "mm"}),
        explained=(by[:2], explained),
        left_out=(("operation", "time"), left_out, {"unit": "mm"}),
        residual=(("operation", "time"), residual, {"unit": "mm"}),
    ).assign_coords(part=list(PHASES), quantile=list(_LEVELS))


def _errors(
    model: Model,
    record: np.ndarray,
    values: np.ndarray,
    curves: np.ndarray,
    rng: np.random.Generator,
) -> tuple[np.ndarray, float]:
    """Draws of what the model leaves out of a record, ``(d, t)``, and the mean of its zero, mm.

    One draw for each draw of the posterior, ``values (d, q)``; their ``curves`` have its mean.
    """
    plain, known = model.sensor.noise_and_zero, model.sensor.discrepancy
    left = record - curves
    deviation = np.zeros_like(curves)
    if known is not None:
        seen = plain.whiten(np.where(np.isnan(record), np.nan, known.factor))
        precision = np.eye(len(seen)) + seen @ seen.T
        mean = np.linalg.solve(precision, seen @ plain.whiten(left).T).T
        root = np.linalg.inv(np.linalg.cholesky(precision))
        weights = mean + rng.standard_normal(mean.shape) @ root
        deviation = weights @ known.factor
        left = left - deviation
    ratio = plain.noise_sd**2 / plain.zero_sd**2 if plain.zero_sd else np.inf
    there = np.isfinite(record)
    zero = left[:, there].sum(axis=1) / (there.sum() + ratio)
    return model.shift(values) + deviation, float(zero.mean())


def _rms(values: np.ndarray) -> np.ndarray:
    """Root mean square over the last axis, of what is there."""
    return np.sqrt(np.nanmean(np.square(values), axis=-1))


def with_limits(answer: xr.Dataset, limits: Sequence[Limit], alarm: Mapping) -> xr.Dataset:
    """Add how probably each limit is exceeded, and the verdict on each record.

    Args:
        answer: Of a motion.
        limits: Limits, of which those of the motion count.
        alarm: The section ``alarm`` of the configuration: from its ``raise`` on, a limit counts as
            exceeded.

    Returns:
        The answer with ``exceeded (operation, limit)``, the probability, and ``limit_verdict``, one
        of ``VERDICTS``: "in doubt" from 5 % on. Unresolved records are unknown.
    """
    motion = answer.attrs["motion"]
    # A network's own answer is not corrected, and so not resolved or unresolved.
    judged = answer if "resolved" in answer else answer.assign(resolved=answer.accepted)
    found = condition({motion: judged}, [each for each in limits if each.motion == motion])
    probability = found.probability.values
    verdict = np.select(
        [probability >= alarm["raise"], probability >= MAY_BE, probability >= 0.0],
        VERDICTS[:0:-1],
        VERDICTS[0],
    )
    by = ("operation", "limit")
    return answer.assign(
        exceeded=(by, probability), limit_verdict=(by, verdict.astype(str))
    ).assign_coords(limit=found.limit.values, limit_words=("limit", found.words.values))


def _inferred(answer: xr.Dataset) -> np.ndarray:
    """Places of the records that have a posterior."""
    return np.flatnonzero(np.isfinite(answer.draws.values).all(axis=(1, 2)))
