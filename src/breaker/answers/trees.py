"""Draws and records as a tree of datasets, in the conventions of ArviZ."""

from collections.abc import Mapping

import numpy as np
import xarray as xr

from breaker import __version__
from breaker.files import known_about
from breaker.model import Model, generator
from breaker.posterior import models_of, replicates

__all__ = ["tree"]

_STATISTICS = (
    *("p_value", "misfit", "far_onset", "resolved", "effective_size", "pareto_k", "log_evidence"),
    *("missing", "masked", "noise"),
)


def tree(
    answers: Mapping[str, xr.Dataset], models: Mapping[str, Model], *, seed: int
) -> xr.DataTree:
    """Return answers as a tree that ArviZ takes for its own.

    Args:
        answers: By motion, with quantities; records without a posterior are left out.
        models: Models of these motions.
        seed: Seed of predictions and of draws of the prior.

    Returns:
        Groups, with the dims ``chain`` (one), ``draw``, ``record`` and ``time``: ``posterior``, a
        variable for each parameter and quantity, which is nan in records of the other motion;
        ``posterior_predictive`` and ``observed_data`` with the ``travel``; ``sample_stats``, how
        each posterior came about; ``prior``, draws of the parameters. ``record`` counts, and its
        coordinates ``motion``, ``operation`` and ``file`` name what is counted.

    Raises:
        ValueError: If no record has a posterior.
    """
    inferred = {motion: _with_posterior(answer) for motion, answer in answers.items()}
    if not any(each.sizes["operation"] for each in inferred.values()):
        raise ValueError("no record has a posterior, so there are no draws to write")
    known = {name for each in inferred.values() for name in ("file", *known_about(each))}
    groups: dict[str, list[xr.Dataset]] = {}
    for motion, answer in inferred.items():
        names = {name: ("record", answer[name].values) for name in sorted(known)}
        names["operation"] = ("record", answer.operation.values)
        names["motion"] = ("record", np.full(answer.sizes["operation"], motion))
        for name, group in _groups(answer, models[motion], seed).items():
            part = (
                group.drop_vars("operation", errors="ignore")
                .rename(operation="record")
                .assign_coords(names)
            )
            groups.setdefault(name, []).append(part)
    joined = {
        name: xr.concat(parts, dim="record", join="outer", combine_attrs="override")
        for name, parts in groups.items()
    }
    for name, each in joined.items():
        joined[name] = each.assign_coords(record=np.arange(each.sizes["record"]))
    joined["prior"] = _prior(next(iter(models.values())), len(joined["posterior"].draw), seed)
    about = {"inference_library": "breaker", "inference_library_version": __version__}
    return xr.DataTree.from_dict({name: each.assign_attrs(about) for name, each in joined.items()})


def _with_posterior(answer: xr.Dataset) -> xr.Dataset:
    return answer.isel(operation=np.isfinite(answer.draws.values).all(axis=(1, 2)))


def _groups(answer: xr.Dataset, model: Model, seed: int) -> dict[str, xr.Dataset]:
    """Groups of the records of a motion, over ``operation``."""
    draws = answer.draws.values.astype(np.float64)
    travel = answer.travel.values.astype(np.float64)
    predicted = np.empty((1, draws.shape[1], *travel.shape))
    density = np.empty((1, draws.shape[1], len(travel)))
    for i, one in enumerate(models_of(model, answer)):
        rng = generator(seed, "replicates", model.motion, int(answer.operation.values[i]))
        predicted[0, :, i] = replicates(one, travel[i], draws[i], rng)
        density[0, :, i] = one.log_joint(one.standardise(draws[i]), travel[i])
    by, mm = ("chain", "draw", "operation"), {"unit": "mm"}
    coords = {"chain": [0], "draw": np.arange(draws.shape[1])}
    time = {"time": ("time", model.sensor.times, {"unit": "ms"})}
    inferred = {
        name: (by, values.T[None], {"unit": unit})
        for dim, all_values in (("output", draws), ("quantity", answer.quantity_draws.values))
        for name, unit, values in zip(
            answer[dim].values.tolist(),
            answer[f"{dim}_unit"].values.tolist(),
            np.moveaxis(all_values, -1, 0),
            strict=True,
        )
        if dim == "output" or _inferred(answer, name)
    }
    statistics = {
        name: ("operation", answer[name].values) for name in _STATISTICS if name in answer
    }
    return {
        "posterior": xr.Dataset(inferred, coords),
        "posterior_predictive": xr.Dataset(
            {"travel": ((*by, "time"), predicted, mm)}, coords | time
        ),
        "observed_data": xr.Dataset({"travel": (("operation", "time"), travel, mm)}, time),
        "sample_stats": xr.Dataset({"lp": (by, density)} | statistics, coords),
    }


def _inferred(answer: xr.Dataset, quantity: str) -> bool:
    """Say whether a quantity is the model's, and none of its parameters."""
    undefined = answer.quantity_undefined.sel(quantity=quantity).values
    return quantity not in answer.output.values and not np.isnan(undefined).all()


def _prior(model: Model, count: int, seed: int) -> xr.Dataset:
    """Draws of the prior, of the parameters and the onset."""
    rng = generator(seed, "prior draws")
    values = model.prior.sample(count, rng)
    onset = model.sensor.onset_sd * rng.standard_normal((count, 1))
    values = np.concatenate([values, onset], axis=1)[:, : len(model.outputs)]
    return xr.Dataset(
        {
            output.name: (("chain", "draw"), column[None], {"unit": output.unit})
            for output, column in zip(model.outputs, values.T, strict=True)
        },
        {"chain": [0], "draw": np.arange(count)},
    )
