"""From records to posteriors: draws, intervals, and checks of the model against each record.

Used alike for simulated records (validation) and for a whole endurance test.
"""

from typing import TYPE_CHECKING

import numpy as np
import xarray as xr
from scipy.special import chdtrc
from tqdm import tqdm

from breaker.common.randomness import generator
from breaker.model.parameters import NAMES
from breaker.paper.bank import simulate
from breaker.paper.joint_model import Model
from breaker.paper.validation import intervals, share_inside

if TYPE_CHECKING:  # predictions need a model alone: torch is not loaded for them
    from breaker.paper.posterior import Posterior

# ---- amortised ----


_FAR_ONSET = 4.0  # prior sd
_SHARE = {"closing": 0.75, "opening": 0.85}  # of the way between the rest positions


def _noise(posterior: "Posterior", seed: int, purpose: str, keys: np.ndarray, draws: int):
    """Start points of the draws, ``(o, d, q)``: one generator a record, whatever the chunks."""
    shape = (draws, len(posterior.outputs))
    return np.stack(
        [generator(seed, purpose, posterior.motion, int(k)).standard_normal(shape) for k in keys]
    )


def validate(posterior: "Posterior", n: int, draws: int, seed: int) -> xr.Dataset:
    """Infer records simulated from the prior, whose truth is known.

    Args:
        n: Number of records.
        draws: Draws for each.
        seed: Seed of the records and of the draws.

    Returns:
        Dataset with dims ``curve``, ``draw``, ``output``, ``time``: ``draws`` and ``truth`` in
        physical units, ``measured`` (mm).
    """
    from breaker.paper.training import truth as truth_of  # loads torch

    sensor, motion = posterior.sensor, posterior.motion
    rng = generator(seed, "validation records", motion)
    bank = simulate(posterior.model, n, rng)
    values = truth_of(bank, posterior)
    measured = sensor.corrupt(bank.travel.values.astype(np.float64), rng)
    return sample_records(posterior, measured, values, draws, seed)


def sample_records(
    posterior: "Posterior", measured: np.ndarray, truth: np.ndarray, draws: int, seed: int
) -> xr.Dataset:
    """Infer records ``(n, t)`` with a known truth ``(n, q)``; returns what ``validate`` does."""
    noise = _noise(posterior, seed, "validation draws", np.arange(len(measured)), draws)
    blocks = [
        posterior.sample(measured[i : i + 1], noise[i : i + 1])
        for i in tqdm(
            range(len(measured)), desc=f"validating {posterior.motion}", mininterval=5, unit="curve"
        )
    ]
    return xr.Dataset(
        {
            "draws": (("curve", "draw", "output"), np.concatenate(blocks)),
            "truth": (("curve", "output"), truth),
            "measured": (("curve", "time"), measured, {"unit": "mm"}),
        },
        coords=coordinates(posterior.model),
        attrs={"motion": posterior.motion, "seed": seed, "solver_steps": posterior.steps},
    )


def coordinates(model: Model) -> dict:
    """Return the coordinates ``output``, ``output_unit`` and ``time`` of a result."""
    return {
        "output": ("output", model.names),
        "output_unit": ("output", [output.unit for output in model.outputs]),
        "time": ("time", model.sensor.times, {"unit": "ms"}),
    }


def predictive_p_value(model: Model, record: np.ndarray, values: np.ndarray) -> float:
    """Return the posterior predictive p-value of a record, from draws ``(d, q)``.

    The discrepancy is the squared Mahalanobis distance of the record from the exact curve of a
    draw, with the zero integrated. That of a replicate follows a chi-square with t degrees of
    freedom, t the samples that are not missing (NaN), so its tail needs no simulation. A small
    value means that the model cannot produce such a record.
    """
    discrepancy = model.sensor.chi_square(record, model.curves(values))
    return float(chdtrc(np.isfinite(record).sum(), discrepancy).mean())


def infer(
    posterior: "Posterior", curves: xr.Dataset, *, draws: int, seed: int, misfit_p_value: float
) -> xr.Dataset:
    """Infer measured operations.

    Args:
        curves: Measured curves in the layout of ``curve_reader.read_curves``; rejected ones stay in
            the result, as missing values with their reason, and so do those that the network does
            not answer for.
        draws: Draws for each operation.
        misfit_p_value: Posterior predictive p-value below which a record counts as misfit.

    Returns:
        ``curves`` with ``draws`` (operation, draw, output), ``median``, ``interval_50`` and
        ``interval_95`` (operation, output, bound), ``p_value``, the flags ``misfit``,
        ``outside_prior`` and ``far_onset`` (inferred beyond 4 prior sd), and ``outside_support``,
        the fraction of draws that the prior excludes.
    """
    o, q = curves.sizes["operation"], len(posterior.outputs)
    accepted = np.flatnonzero(curves.accepted.values)
    operations = curves.operation.values
    measured = curves.travel.values.astype(np.float64)
    values = np.full((o, draws, q), np.nan)
    p_value, distance = np.full((2, o), np.nan)
    progress = tqdm(accepted, desc=f"inferring {posterior.motion}", mininterval=5, unit="operation")
    reasons = curves.reason.values.astype(object)
    for i in progress:
        noise = _noise(posterior, seed, "draws", operations[i : i + 1], draws)
        try:
            # One by one, as the draws: sums over more rows may round in another order.
            distance[i] = posterior.distance(measured[i : i + 1])[0]
            found = posterior.sample(measured[i : i + 1], noise)[0]
            p_value[i] = predictive_p_value(posterior.model, measured[i], found)
        except (ArithmeticError, RuntimeError, ValueError) as error:
            # So unlike the bank that the network's answer is no posterior; the rest goes on.
            reasons[i] = f"{curves.file.values[i]}: no posterior: {error}"
            continue
        values[i] = found
    flags = {
        "distance": ("operation", distance),
        "outside_prior": ("operation", distance > 1.0),
        "reason": ("operation", reasons.astype(str)),
        "accepted": ("operation", reasons == ""),
    }
    found = summaries(posterior.model, values, p_value, misfit_p_value)
    return curves.assign(flags | found).assign_coords(coordinates(posterior.model))


def summaries(
    model: Model, values: np.ndarray, p_value: np.ndarray, misfit_p_value: float
) -> dict[str, xr.DataArray]:
    """Summarise the posteriors of operations.

    Args:
        values: Draws, ``(o, d, q)``, physical units; nan where there is no posterior.
        p_value: Posterior predictive p-values, ``(o,)``.
        misfit_p_value: The one below which a record counts as misfit.

    Returns:
        ``draws``, ``median``, ``interval_50``, ``interval_95``, ``p_value``, ``misfit``,
        ``far_onset`` and ``outside_support``, as ``infer`` returns them.
    """
    p = len(NAMES)
    outside = 1.0 - model.prior.supported(values[..., :p]).mean(axis=1)
    named = intervals(values)
    onset = np.abs(named["median"].values[:, p:]).sum(axis=1)  # of seven outputs there is none
    found = {
        "p_value": (("operation",), p_value),
        "misfit": (("operation",), p_value < misfit_p_value),
        "far_onset": (("operation",), onset > _FAR_ONSET * model.sensor.onset_sd),
        "outside_support": (("operation",), np.where(np.isnan(p_value), np.nan, outside)),
        "draws": (("operation", "draw", "output"), values.astype(np.float32)),
    }
    return named | {name: xr.DataArray(each, dims=dims) for name, (dims, each) in found.items()}


def predict(model: Model, measured: np.ndarray, draws: np.ndarray, *, seed: int) -> xr.Dataset:
    """Predict records from the draws of their own model.

    By replicates, one for each draw: they share the record's parameters, onset and zero, and have
    noise of their own.

    Args:
        measured: Records, ``(n, t)``, mm.
        draws: Draws of their posteriors, ``(n, d, q)``.

    Returns:
        Dataset with dims ``curve``, ``time``: ``measured``, and the ``median``, ``lower`` and
        ``upper`` end of the pointwise 95 % interval of the replicates, mm; and
        ``share_inside (curve)``, the share of the samples inside.
    """
    sensor, bands = model.sensor, []
    for i, (record, values) in enumerate(zip(measured, draws, strict=True)):
        rng = generator(seed, "predictive", model.motion, i)
        exact = model.curves(values.astype(np.float64))
        shared = sensor.sample_shared(record, exact, rng)
        replicates = exact + shared + sensor.noise_sd * rng.standard_normal(exact.shape)
        bands.append(np.quantile(replicates, [0.5, 0.025, 0.975], axis=0))
    median, lower, upper = np.moveaxis(np.array(bands), 1, 0)
    unit = {"unit": "mm"}
    return xr.Dataset(
        {
            "share_inside": ("curve", share_inside(measured, lower, upper)),
            "measured": (("curve", "time"), measured, unit),
            "median": (("curve", "time"), median, unit),
            "lower": (("curve", "time"), lower, unit),
            "upper": (("curve", "time"), upper, unit),
        },
        coords={"time": ("time", sensor.times, {"unit": "ms"})},
        attrs={"motion": model.motion, "noise_sd": sensor.noise_sd},
    )


def predict_stages(model: Model, inferred: xr.Dataset, *, stages: int, seed: int) -> xr.Dataset:
    """Predict the records at a few stages of an endurance test from their own posteriors.

    Args:
        inferred: What ``infer`` returns, all operations.
        stages: Number of stages, evenly spread over the operations with draws, ends included.

    Returns:
        Dataset over ``stage``, ``time``: ``travel`` and the ``median``, ``lower`` and ``upper``
        end of its prediction; coordinate ``operation (stage)``; and over ``stage``:
        ``main_motion_end``, ms, ``share_inside``, the share of samples of the main motion, as far
        as they are not missing, inside the band, ``p_value`` and the flag ``misfit`` of the whole
        record.

    Raises:
        ValueError: If no operation has draws.
    """
    known = np.flatnonzero(np.isfinite(inferred.draws.values).all(axis=(1, 2)))
    if known.size == 0:
        raise ValueError("no operation has a posterior, so nothing can be predicted")
    chosen = known[np.unique(np.linspace(0, known.size - 1, stages).astype(int))]
    part = inferred.isel(operation=chosen).load()
    result = predict(model, part.travel.values, part.draws.values, seed=seed)
    times, medians = model.sensor.times, result["median"].values
    main = np.stack([main_motion(median, times, model.motion) for median in medians])
    band = (result.measured.values, result.lower.values, result.upper.values)
    share = share_inside(*band, where=main)
    ends = [times[inside].max(initial=0.0) for inside in main]  # it begins at 0
    return (
        result.rename(curve="stage", measured="travel")
        .assign(
            share_inside=("stage", share),
            main_motion_end=("stage", ends, {"unit": "ms"}),
            p_value=("stage", part.p_value.values),
            misfit=("stage", part.misfit.values),
        )
        .assign_coords(operation=("stage", part.operation.values))
    )


def main_motion(travel: np.ndarray, times: np.ndarray, motion: str) -> np.ndarray:
    """Return which samples of a curve belong to the main motion, ``(t,)`` of bool.

    The model describes this part of a record (paper, Sec. 7), not the rest of the stroke, where
    stops and dampers act. It lasts from time 0 to where the drive has done its share of the way
    between its rest positions: about up to the touch when closing, up to the stop when opening.

    Args:
        travel: A curve with little noise, ``(t,)``, mm.
        times: Times, ``(t,)``, ms, 0 at the first motion.
        motion: "closing" or "opening".
    """
    # Rests are means: before time 0, and over the last twelfth.
    before, after = max(1, np.searchsorted(times, 0.0)), max(1, times.size // 12)
    start, end = travel[:before].mean(), travel[-after:].mean()
    done = (travel - start) / (end - start) >= _SHARE[motion]
    last = int(done.argmax()) if done.any() else len(travel)
    return (times >= 0) & (np.arange(len(travel)) < last)
