"""The numbers of a run that texts state, rounded as they are written.

A flat table with one name for each number, such as ``closing.contraction.gamma_a`` for 0.96. The
README and the pages in ``docs`` take their numbers from the table of the default run.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import combinations

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import ArrayLike

from breaker.model.parameters import NAMES, PARAMETERS
from breaker.paper.calibration import family_p_value
from breaker.paper.validation import correlation, prior_check

_NAMES = [each.name for each in PARAMETERS]


@dataclass(frozen=True)
class MotionResults:
    """Results of one motion.

    Attributes:
        quality: Table of the quality, both posteriors.
        exactness: Table of the exactness, one row.
        prior: Curves of the prior, ``travel (curve, time)``.
        validation: Posteriors of simulated records.
        operations: Posteriors of the endurance test by the paper's network, ``draws (operation,
            draw, output)``, and their records, ``travel (operation, time)``.
        family: The same by the families, without records.
        predictive: Predicted records at a few stages, with ``share_inside (stage)``.
        truth: True parameters of the stand-in, ``value (operation, parameter)``, and the largest
            ``difference (operation)`` of its curves from the model's, mm; None for real records.
    """

    quality: pd.DataFrame
    exactness: pd.DataFrame
    prior: xr.Dataset
    validation: xr.Dataset
    operations: xr.Dataset
    family: xr.Dataset
    predictive: xr.Dataset
    truth: xr.Dataset | None = None


def numbers_of_motion(results: MotionResults) -> dict[str, str]:
    """Return the numbers of one motion by name, without the motion."""
    found = _of_quality(results.quality) | _of_exactness(results.exactness.iloc[0])
    draws = results.validation.draws.sel(output=_NAMES).values
    found |= _of_correlations(draws)
    operations = results.operations
    used = _accepted(operations)
    found["operations"] = _count(operations.sizes["operation"])
    check = prior_check(results.prior.travel.values, used.travel.values)
    found["prior_inside"] = _percent(check.inside.mean())
    found["misfit"] = _percent(used.misfit.mean())
    found["family_misfit"] = _percent(_accepted(results.family).misfit.mean())
    found |= _ends("inside", results.predictive.share_inside, _percent)
    if results.truth is not None:
        found |= _of_stand_in(results.truth, blocks_of(operations), blocks_of(results.family))
    return found


def _accepted(operations: xr.Dataset) -> xr.Dataset:
    """Those whose records were accepted; of the others nothing is known that could misfit."""
    return operations.isel(operation=np.flatnonzero(operations.accepted.values))


def numbers_of_all(quality: pd.DataFrame) -> dict[str, str]:
    """Return the numbers of all motions together, from their tables of the quality.

    Args:
        quality: Tables of the quality of all motions, one below the other.
    """
    found = {}
    for posterior, rows in quality.groupby("posterior"):
        found |= _ends(f"{posterior}.z_sd", rows.z_sd, _two)
        found |= _ends(f"{posterior}.coverage_95", rows.coverage_95, _percent)
    network = quality[quality.posterior == "amortised"]
    found["shortfall"] = _two(network.shortfall.max())
    return found


def numbers_of_life(
    life: xr.Dataset, limits: pd.DataFrame, decisions: pd.DataFrame, failures: Mapping[str, float]
) -> dict[str, str]:
    """Return when a life changed, when each limit was exceeded, and when a service was planned.

    Args:
        life: Over ``change``, ``noticed`` and ``certainty``.
        limits: Table of limits, with ``limit`` and ``certain``.
        decisions: Table of decisions, with ``operation``, ``state`` and ``service_by``.
        failures: True operation at which each limit is first exceeded; empty for real records.
    """
    noticed = life.noticed.values[life.certainty.values >= 0.0]
    found = {"changes": _count(noticed.size)}
    found |= {f"change_{i}": _count(each) for i, each in enumerate(noticed, start=1)}
    for name, operation in failures.items():
        if operation == operation:
            found[f"{name}.failure"] = _count(operation)
    for row in limits.drop_duplicates("limit").itertuples():
        if row.certain == row.certain:
            found[f"{row.limit}.exceeded"] = _count(row.certain)
    planned = decisions[decisions.state.isin(["plan", "now"]) & decisions.service_by.notna()]
    if len(planned):
        found["first_plan"] = _count(planned.operation.iloc[0])
        found["service_moves"] = _count((planned.service_by.diff().fillna(0) != 0).sum())
    return found


def _of_quality(quality: pd.DataFrame) -> dict[str, str]:
    """Contraction and calibration, output by output; the corrected posterior's by its name."""
    found = {}
    for posterior, rows in quality.set_index("output").groupby("posterior"):
        prefix = "" if posterior == "amortised" else f"{posterior}."
        found |= {f"{prefix}contraction.{name}": _two(x) for name, x in rows.contraction.items()}
        found |= _ends(f"{prefix}z_sd", rows.z_sd, _two)
        found |= _ends(f"{prefix}coverage_95", rows.coverage_95, _percent)
        found[f"{prefix}calibration_p"] = _p(family_p_value(rows.calibration_p))
    network = quality[quality.posterior == "amortised"].set_index("output")
    found["shortfall"] = _two(network.shortfall.max())
    through_files = network.calibration_p_reader
    found["calibration_p_files"] = _p(family_p_value(through_files))
    return found | {f"calibration_p_files.{name}": _p(x) for name, x in through_files.items()}


def _of_exactness(row: pd.Series) -> dict[str, str]:
    """How far the network is from the exact posterior, and how many records were resolved."""
    return {
        "judged_curves": _count(row.judged_curves),
        "efficiency_median": _percent(row.efficiency_median),
        "efficiency_lowest": _percent(row.efficiency_lowest),
        "gap": _two(row.gap_nats),
        "gap_se": _two(row.gap_se),
        "c2st": _two(row.c2st_median),
        "curves": _count(row.corrected_curves),
        "curves_resolved": _count(row.resolved * row.corrected_curves),
    }


def _of_correlations(draws: np.ndarray) -> dict[str, str]:
    """Median correlation of each pair of parameters within a posterior, of their logarithms."""
    log = np.ones(len(_NAMES), dtype=bool)
    median = np.median([correlation(each, log=log) for each in draws], axis=0)
    pairs = combinations(range(len(_NAMES)), 2)
    return {f"correlation.{_NAMES[i]}.{_NAMES[j]}": _two(median[i, j]) for i, j in pairs}


def _of_stand_in(truth: xr.Dataset, paper: xr.Dataset, family: xr.Dataset) -> dict[str, str]:
    """How far the model is from its curves; of its parameters, by network and by family, the share
    of blocks whose 90 % band holds the truth, and the change over the test, percent.
    """
    found = _ends("difference", truth.difference, _one)
    changes = {"true": moved(truth_in_blocks(paper, truth.value))}
    for by, blocks in (("paper", paper), ("family", family)):
        shares = zip(_NAMES, held(blocks, truth.value), strict=True)
        found |= {f"{by}_holds.{name}": _percent(share) for name, share in shares}
        changes[by] = moved(blocks["value"].sel(quantile=0.5).values)
    for by, percent in changes.items():
        named = zip(_NAMES, percent, strict=True)
        found |= {f"{by}_change.{name}": _one(value) for name, value in named}
    return found


def _ends(name: str, values: ArrayLike, write: Callable[[float], str]) -> dict[str, str]:
    """The lowest and the highest of some values."""
    return {f"{name}.lowest": write(np.min(values)), f"{name}.highest": write(np.max(values))}


def _count(value: float) -> str:
    return f"{round(float(value)):,}"


def _percent(share: float) -> str:
    return f"{100 * float(share):.0f}"


def _one(value: float) -> str:
    return f"{round(float(value), 1) + 0.0:.1f}"  # never -0.0


def _two(value: float) -> str:
    return f"{round(float(value), 2) + 0.0:.2f}"


def _p(value: float) -> str:
    """Write a probability with two digits, never as a power of ten."""
    return np.format_float_positional(float(value), precision=2, fractional=False, trim="-")


# ---- operation blocks ----


QUANTILES = (0.05, 0.5, 0.95)
_BLOCKS = 40  # at most, of about as many operations each


def blocks_of(inferred: xr.Dataset) -> xr.Dataset:
    """Sum up the posteriors of operations in blocks of a life.

    Args:
        inferred: Draws of the parameters, ``draws (operation, draw, output)``; nan where there is
            no posterior.

    Returns:
        Dataset over ``block``: ``value (block, parameter, quantile)``, the median over a block's
        operations of the quantiles of their posteriors, nan where none has one; ``first``, ``last``
        and ``operation``, numbers of the first and the last one and their middle; ``count``, how
        many there are, and ``answered``, how many of them have a posterior.
    """
    draws = inferred.draws.sel(output=list(NAMES)).transpose("operation", "draw", "output").values
    each = np.moveaxis(np.quantile(draws, QUANTILES, axis=1), 0, -1)
    there, numbers = np.isfinite(each).all(axis=(1, 2)), inferred.operation.values
    parts = np.array_split(np.arange(numbers.size), min(_BLOCKS, numbers.size))
    value = np.full((len(parts), *each.shape[1:]), np.nan)
    for k, part in enumerate(parts):
        if there[part].any():
            value[k] = np.median(each[part][there[part]], axis=0)
    first, last = (np.array([numbers[part[end]] for part in parts]) for end in (0, -1))
    return xr.Dataset(
        {
            "value": (("block", "parameter", "quantile"), value),
            "first": ("block", first),
            "last": ("block", last),
            "count": ("block", [part.size for part in parts]),
            "answered": ("block", [there[part].sum() for part in parts]),
        },
        {"parameter": list(NAMES), "quantile": list(QUANTILES)}
        | {"operation": ("block", (first + last) / 2)},
    )


def truth_in_blocks(blocks: xr.Dataset, truth: xr.DataArray) -> np.ndarray:
    """Return the mean true values ``(operation, parameter)`` in each block, ``(b, p)``."""
    values, numbers = truth.sel(parameter=list(NAMES)).values, truth.operation.values
    ends = zip(blocks["first"].values, blocks["last"].values, strict=True)
    return np.array([values[(numbers >= a) & (numbers <= b)].mean(axis=0) for a, b in ends])


def held(blocks: xr.Dataset, truth: xr.DataArray) -> np.ndarray:
    """Return the share of blocks with a posterior whose 90 % band holds the truth, ``(p,)``.

    Args:
        blocks: What ``blocks_of`` returns.
        truth: True values, ``(operation, parameter)``.

    Returns:
        The shares; nan where no block has a posterior.
    """
    low, _, high = np.moveaxis(blocks["value"].values, -1, 0)
    true = truth_in_blocks(blocks, truth)
    known = np.isfinite(low)
    inside = known & (low <= true) & (true <= high)
    with np.errstate(invalid="ignore"):
        return inside.sum(axis=0) / known.sum(axis=0)


def moved(values: np.ndarray) -> np.ndarray:
    """Return the change of values ``(b, p)`` from the first block to the last, percent, ``(p,)``.

    Of blocks that have one; nan where none has.
    """
    there = np.isfinite(values)
    first, last = there.argmax(axis=0), len(values) - 1 - there[::-1].argmax(axis=0)
    column = np.arange(values.shape[1])
    return 100.0 * (values[last, column] / values[first, column] - 1.0)
