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

from breaker.paper.validation.calibration import family_p_value
from breaker.paper.validation.diagnostics import correlation, prior_check
from breaker.paper.validation.operation_blocks import blocks_of, held, moved, truth_in_blocks
from breaker.quantities.parameters import PARAMETERS

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
