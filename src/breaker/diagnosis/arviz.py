"""Posterior draws and records as a tree of datasets, in the conventions of ArviZ."""

from collections.abc import Sequence

import numpy as np
import xarray as xr

from breaker import __version__
from breaker.common.randomness import generator
from breaker.diagnosis.estimate import Estimate, Given
from breaker.diagnosis.words import say
from breaker.family.shape import SHAPE_TIMES
from breaker.model.parameters import PARAMETERS
from breaker.model.quantities import ABOUT, AFTER_RELEASE
from breaker.records.files import printable


def tree(estimates: Sequence[Estimate], given: Given, *, seed: int) -> xr.DataTree:
    """Return the estimates with posterior draws as a tree that ArviZ accepts.

    Returns:
        Groups over ``record``, with ``chain`` (one) and ``draw``: ``posterior``, the parameters and
        the time of contact touch or separation, nan in records of the other motion; ``prior``, at
        the size that a record shows where none is given; ``observed_data``, the travel ``way`` over
        the stroke at ``time``, in durations after 10 % of it, nan without a sample, with
        ``stroke`` and ``duration``; ``sample_stats``. Both motions of an operation may have the
        same draws: see ``motions``.

    Raises:
        ValueError: If no record has draws.
    """
    drawn = [e for e in estimates if e.draws is not None]
    if not drawn:
        raise ValueError(say("tree-empty"))
    n, rng = len(drawn[0].draws.theta), generator(seed, "prior draws")
    records = [e.record for e in drawn]
    motions, shapes = [r.motion for r in records], [r.shape for r in records]
    names = {k: ("record", [getattr(r.operation, k) for r in records]) for k in ABOUT}
    names |= {"record": np.arange(len(drawn)), "motion": ("record", motions)}
    names["operation"] = "record", [r.operation.number for r in records]
    names["file"] = "record", [printable(r.operation.file) for r in records]
    posterior = _parameters([e.draws.theta for e in drawn])
    for motion, name in AFTER_RELEASE.items():
        if motion in motions:
            other = np.full(n, np.nan)
            times = [e.inferred(name) if e.record.motion == motion else other for e in drawn]
            posterior[name] = _variable(times, "ms")
    observed = {
        "way": (("record", "time"), [np.where(s.present, s.way, np.nan) for s in shapes]),
        "stroke": ("record", [s.stroke for s in shapes], {"unit": "mm"}),
        "duration": ("record", [s.duration for s in shapes], {"unit": "ms"}),
    }
    statistics = {
        "p_value": ("record", [e.match.p_value for e in drawn]),
        "effective_size": ("record", [e.effective_size for e in drawn]),
        "motions": ("record", [" ".join(e.motions) for e in drawn]),
    }
    prior = _parameters([given.sample_prior(e, n, rng) for e in drawn])
    draws = names | {"chain": [0], "draw": np.arange(n)}
    groups = {
        "posterior": xr.Dataset(posterior, draws),
        "prior": xr.Dataset(prior, draws),
        "observed_data": xr.Dataset(observed, names | {"time": SHAPE_TIMES}),
        "sample_stats": xr.Dataset(statistics, names),
    }
    about = {"inference_library": "breaker", "inference_library_version": __version__}
    return xr.DataTree.from_dict({k: group.assign_attrs(about) for k, group in groups.items()})


def _parameters(draws: Sequence[np.ndarray]) -> dict[str, tuple]:
    """Return a variable for each parameter, from draws ``(draw, p)`` of each record."""
    pairs = enumerate(PARAMETERS)
    return {e.name: _variable([theta[:, k] for theta in draws], e.unit) for k, e in pairs}


def _variable(columns: Sequence[np.ndarray], unit: str) -> tuple:
    """Return draws ``(draw,)`` of each record as a variable."""
    return ("chain", "draw", "record"), np.stack(columns, axis=1)[None], {"unit": unit}
