"""Inference: posteriors of simulated and measured records, and predictions from them.

Paper, the inference phase of Fig. 2: ``validate`` infers simulated records (Sec. 6), ``infer``
records of an endurance test (Sec. 7), and ``predict`` computes the posterior predictive checks of
both (Figs. 8 and 9).
"""

from typing import TYPE_CHECKING

import numpy as np
import xarray as xr
from scipy.special import chdtrc
from tqdm import tqdm

from breaker.common.randomness import generator
from breaker.paper.bank import simulate, truth
from breaker.paper.joint_model import Model
from breaker.paper.validation import intervals, share_inside

if TYPE_CHECKING:  # predictions need only a model, and do not load torch
    from breaker.paper.posterior import Posterior

# Share of the travel in the main motion: about to the touch, and to the stop.
_MAIN_PART = {"closing": 0.75, "opening": 0.85}


def _noise(posterior: "Posterior", seed: int, purpose: str, keys: np.ndarray, draws: int):
    """Return start points of the draws, ``(o, d, q)``; each record has its own generator."""
    shape = (draws, len(posterior.outputs))
    return np.stack(
        [generator(seed, purpose, posterior.motion, int(k)).standard_normal(shape) for k in keys]
    )


def validate(posterior: "Posterior", n: int, draws: int, seed: int) -> xr.Dataset:
    """Infer ``n`` records simulated from the prior; return the result of ``sample_records``."""
    model = posterior.model
    rng = generator(seed, "validation records", model.motion)
    bank = simulate(model, n, rng)
    measured = model.sensor.corrupt(bank.travel.values.astype(np.float64), rng)
    return sample_records(posterior, measured, truth(bank, model), draws, seed)


def sample_records(
    posterior: "Posterior", measured: np.ndarray, truth: np.ndarray, draws: int, seed: int
) -> xr.Dataset:
    """Infer records ``(n, t)`` with a known truth ``(n, q)``.

    Returns:
        Dataset with dims ``curve``, ``draw``, ``output``, ``time``: ``draws`` and ``truth`` in
        physical units, ``measured`` (mm); and the scale in which outputs are judged: ``prior_sd``,
        for logarithms where ``logarithmic``.
    """
    model = posterior.model
    noise = _noise(posterior, seed, "validation draws", np.arange(len(measured)), draws)
    progress = tqdm(
        range(len(measured)), desc=f"validating {model.motion}", mininterval=5, unit="curve"
    )
    samples = [posterior.sample(measured[i : i + 1], noise[i : i + 1]) for i in progress]
    return xr.Dataset(
        {
            "draws": (("curve", "draw", "output"), np.concatenate(samples)),
            "truth": (("curve", "output"), truth),
            "measured": (("curve", "time"), measured, {"unit": "mm"}),
            "prior_sd": ("output", model.sds),
            "logarithmic": ("output", model.logarithmic),
        },
        coords=_coordinates(model),
        attrs={"motion": model.motion, "seed": seed, "solver_steps": posterior.solver_steps.item()},
    )


def _coordinates(model: Model) -> dict:
    """Return the coordinates ``output``, ``output_unit`` and ``time`` of a result."""
    return {
        "output": ("output", model.names),
        "output_unit": ("output", [output.unit for output in model.outputs]),
        "time": ("time", model.sensor.times, {"unit": "ms"}),
    }


def infer(
    posterior: "Posterior", curves: xr.Dataset, *, draws: int, seed: int, misfit_p_value: float
) -> xr.Dataset:
    """Infer measured operations.

    Args:
        curves: ``travel (operation, time)``, ``accepted``, ``reason`` and ``file (operation)``.
            Operations without a posterior stay in the result, with missing values and a reason.
        draws: Draws for each operation.
        misfit_p_value: Posterior predictive p-value below which a record is a misfit.

    Returns:
        ``curves`` with ``draws`` (operation, draw, output), ``median``, ``interval_50`` and
        ``interval_95`` (operation, output, bound), ``p_value``, ``distance`` from the bank, and
        the flags ``misfit`` and ``outside_prior`` (distance above 1).
    """
    model, motion = posterior.model, posterior.motion
    operations, measured = curves.operation.values, curves.travel.values.astype(np.float64)
    values = np.full((len(operations), draws, len(model.names)), np.nan)
    p_value, distance = np.full((2, len(operations)), np.nan)
    reasons = curves.reason.values.astype(object)
    accepted = np.flatnonzero(curves.accepted.values)
    for i in tqdm(accepted, desc=f"inferring {motion}", mininterval=5, unit="operation"):
        # One record at a time, because sums over more rows may round in another order.
        record = measured[i : i + 1]
        noise = _noise(posterior, seed, "draws", operations[[i]], draws)
        rng = generator(seed, "predictive curves", motion, int(operations[i]))
        try:
            distance[i] = posterior.distance(record)[0]
            sampled = posterior.sample(record, noise)[0]
            p_value[i] = predictive_p_value(model, record[0], sampled, rng)
        except (ArithmeticError, RuntimeError, ValueError) as error:
            # The record is so unlike the bank that inference fails; go on with the next one.
            reasons[i] = f"{curves.file.values[i]}: no posterior: {error}"
            continue
        values[i] = sampled
    columns = {
        "distance": distance,
        "outside_prior": distance > 1.0,
        "reason": reasons.astype(str),
        "accepted": reasons == "",
        "p_value": p_value,
        "misfit": p_value < misfit_p_value,
    }
    columns = {name: ("operation", column) for name, column in columns.items()}
    columns |= {"draws": (("operation", "draw", "output"), values.astype(np.float32))}
    return curves.assign(intervals(values) | columns).assign_coords(_coordinates(model))


def predictive_p_value(
    model: Model, record: np.ndarray, values: np.ndarray, rng: np.random.Generator | None = None
) -> float:
    """Return the posterior predictive p-value of a record ``(t,)``, from draws ``(d, q)``.

    The discrepancy is the squared Mahalanobis distance of the record from the curve of a draw, with
    the zero integrated. The discrepancy of a replicate follows a chi-square distribution with one
    degree of freedom per sample, so the p-value needs no simulated replicates. A small p-value
    means that the model cannot produce such a record. Random curves of your own simulator, with
    the generator ``rng``, make it smaller.
    """
    discrepancy = model.sensor.chi_square(record, model.curves(values, rng))
    return float(chdtrc(np.isfinite(record).sum(), discrepancy).mean())


# ---- posterior predictive checks -----------------------------------------------------------------


def predict(model: Model, measured: np.ndarray, draws: np.ndarray, *, seed: int) -> xr.Dataset:
    """Predict records from the draws of their own posteriors (paper, Sec. 6, Fig. 8).

    Each draw has one replicate, with parameters, onset and zero of the draw and new noise.

    Args:
        measured: Records, ``(n, t)``, mm.
        draws: Draws of their posteriors, ``(n, d, q)``.

    Returns:
        Dataset with dims ``curve``, ``time``: ``measured``, and ``median``, ``lower`` and ``upper``
        end of the pointwise 95 % interval of the replicates, mm; and ``share_inside (curve)``, the
        share of samples inside the interval.
    """
    sensor, bands = model.sensor, []
    for i, (record, values) in enumerate(zip(measured, draws, strict=True)):
        rng = generator(seed, "predictive", model.motion, i)
        curves = model.curves(values.astype(np.float64), rng)
        shared = sensor.sample_shared(record, curves, rng)
        replicates = curves + shared + sensor.noise_sd * rng.standard_normal(curves.shape)
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
    """Predict the records at a few stages of an endurance test (paper, Sec. 7, Fig. 9).

    Args:
        inferred: Result of ``infer``, all operations.
        stages: Number of stages, evenly spread over the operations with draws, ends included.

    Returns:
        Dataset over ``stage``, ``time``: ``travel``, with ``median``, ``lower`` and ``upper`` end
        of its prediction; coordinate ``operation (stage)``; and over ``stage``:
        ``main_motion_end``, ms, ``share_inside``, the share of samples of the main motion inside
        the band, and ``p_value`` and the flag ``misfit`` of the entire record.

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
    ends = [times[inside].max(initial=0.0) for inside in main]  # the main motion begins at 0
    return (
        result.rename(curve="stage", measured="travel")
        .assign(
            share_inside=("stage", share_inside(*band, where=main)),
            main_motion_end=("stage", ends, {"unit": "ms"}),
            p_value=("stage", part.p_value.values),
            misfit=("stage", part.misfit.values),
        )
        .assign_coords(operation=("stage", part.operation.values))
    )


def main_motion(travel: np.ndarray, times: np.ndarray, motion: str) -> np.ndarray:
    """Return which samples of a curve belong to the main motion, ``(t,)`` of bool.

    The model describes this part of a record (paper, Sec. 7), not the rest of the stroke, where
    stops and dampers act. It lasts from time 0 until the drive has moved by a share of the travel
    between the rest positions: about to the touch when closing, to the stop when opening.

    Args:
        travel: A curve with little noise, ``(t,)``, mm.
        times: Times, ``(t,)``, ms, 0 at the start of motion.
    """
    # Rest positions are means: before time 0, and over the last twelfth of the record.
    before, after = max(1, np.searchsorted(times, 0.0)), max(1, times.size // 12)
    start, end = travel[:before].mean(), travel[-after:].mean()
    done = (travel - start) / (end - start) >= _MAIN_PART[motion]
    last = int(done.argmax()) if done.any() else len(travel)
    return (times >= 0) & (np.arange(len(travel)) < last)
