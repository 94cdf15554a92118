"""Draws and records as a tree of datasets, in the conventions of ArviZ."""

from collections.abc import Sequence

import numpy as np
import xarray as xr

from breaker import __version__
from breaker.common.randomness import generator
from breaker.diagnosis.estimate import Estimate, Given
from breaker.family.shape import SHAPE_TIMES
from breaker.model.parameters import PARAMETERS
from breaker.model.quantities import ABOUT, AFTER_RELEASE
from breaker.records.files import printable


def tree(answers: Sequence[Estimate], given: Given, *, seed: int) -> xr.DataTree:
    """Return answers as a tree that ArviZ takes for its own.

    Args:
        answers: What ``infer_drive`` returns; records without draws are left out.
        given: What was given beside them.
        seed: Seed of draws of the prior.

    Returns:
        Groups, with the dims ``chain`` (one), ``draw``, ``record`` and ``time``: ``posterior``, a
        variable for each parameter, and the time of touch or separation, nan in records of the
        other motion; ``prior``, without a given size at that which a record shows;
        ``observed_data``, the ``way`` over the stroke at ``time``, in durations after 10 % of it,
        nan without a sample, with ``stroke`` and ``duration``; ``sample_stats``, how each
        posterior came about.
        ``record`` counts; its coordinates ``motion``, ``operation`` and ``file`` name what is
        counted. Both motions of an operation may have the same draws, as ``motions`` says.

    Raises:
        ValueError: If no record has draws.
    """
    there = [answer for answer in answers if answer.draws is not None]
    if not there:
        raise ValueError("no record has a posterior, so there are no draws to write")
    rng, n = generator(seed, "prior draws"), len(there[0].draws.theta)
    posterior = _parameters([answer.draws.theta for answer in there]) | _switching(there)
    priors = _parameters([given.sample_prior(answer, n, rng) for answer in there])
    shapes = [answer.record.shape for answer in there]
    way = [np.where(each.present, each.way, np.nan) for each in shapes]
    observed = {
        "way": (("record", "time"), way, {"unit": "1"}),
        "stroke": ("record", [each.stroke for each in shapes], {"unit": "mm"}),
        "duration": ("record", [each.duration for each in shapes], {"unit": "ms"}),
    }
    statistics = {
        "p_value": [answer.match.p_value for answer in there],
        "effective_size": [answer.effective_size for answer in there],
        "motions": [" ".join(answer.motions) for answer in there],
    }
    names = _names(there)
    drawn = names | {"chain": [0], "draw": np.arange(n)}
    groups = {
        "posterior": xr.Dataset(posterior, drawn),
        "prior": xr.Dataset(priors, drawn),
        "observed_data": xr.Dataset(observed, names | {"time": SHAPE_TIMES}),
        "sample_stats": xr.Dataset({k: ("record", v) for k, v in statistics.items()}, names),
    }
    about = {"inference_library": "breaker", "inference_library_version": __version__}
    return xr.DataTree.from_dict({name: each.assign_attrs(about) for name, each in groups.items()})


def _parameters(draws: Sequence[np.ndarray]) -> dict[str, tuple]:
    """Variables of parameters, of draws ``(draw, p)`` of each record."""
    return {
        each.name: _variable([theta[:, k] for theta in draws], each.unit)
        for k, each in enumerate(PARAMETERS)
    }


def _switching(there: Sequence[Estimate]) -> dict[str, tuple]:
    """Variables of touch and separation times, as far as there are records of the motion."""
    motions = [answer.record.motion for answer in there]
    nothing = np.full(len(there[0].draws.theta), np.nan)
    return {
        name: _variable([a.after_release if a.record.motion == m else nothing for a in there], "ms")
        for m, name in AFTER_RELEASE.items()
        if m in motions
    }


def _variable(columns: Sequence[np.ndarray], unit: str) -> tuple:
    """Draws of each record as a variable."""
    return ("chain", "draw", "record"), np.stack(columns, axis=1)[None], {"unit": unit}


def _names(there: Sequence[Estimate]) -> dict:
    """Coordinates of the records."""
    operations = [answer.record.operation for answer in there]
    names = {name: ("record", [getattr(each, name) for each in operations]) for name in ABOUT}
    return names | {
        "record": np.arange(len(there)),
        "operation": ("record", [each.number for each in operations]),
        "file": ("record", [printable(each.file) for each in operations]),
        "motion": ("record", [answer.record.motion for answer in there]),
    }
