"""Validation: are posteriors calibrated and informative? Functions of arrays and datasets.

Paper, Sec. 5 to 7: the prior predictive check (Fig. 3), z-score and contraction (Fig. 5), recovery
of the truth (Fig. 6), pairs (Fig. 7) and shares of curves inside predicted bands (Figs. 8 and 9).
Calibration by ranks (Fig. 4) is in ``calibration``. This module does not load torch or numba.

Shapes: ``n`` simulations, ``d`` draws, ``q`` outputs, ``t`` samples.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import ArrayLike

from breaker.model.parameters import NAMES, ONSET, is_logarithmic
from breaker.model.quantities import metadata_names
from breaker.paper.calibration import checked_draws, coverage, judge_draws, judge_ranks, ranks

INTERVALS = {"interval_50": (0.25, 0.75), "interval_95": (0.025, 0.975)}
"""Central intervals of a posterior, and their bounds as quantiles."""

REGIONS = (0.9, 0.5)
"""Shares of the draws that the regions of :func:`regions` contain, the widest first."""

KNOWLEDGE = (
    (0.8, "known from this motion"),
    (0.5, "partly known"),
    (-np.inf, "the prior decides"),
)
"""Least mean contraction of the exact posterior, and its meaning in words for an output. Below 0.5
the posterior keeps over 71 % of the prior's width, from 0.8 on less than 45 %."""


# ---- draws of one posterior ----------------------------------------------------------------------


def intervals(draws: np.ndarray) -> dict[str, xr.DataArray]:
    """Return ``median``, ``interval_50`` and ``interval_95`` of draws ``(o, d, q)``, with names.

    Example:
        >>> intervals(np.arange(101.0)[None, :, None])["interval_50"].values.tolist()
        [[[25.0, 75.0]]]
    """
    median, *bounds = np.quantile(draws, [0.5, *sum(INTERVALS.values(), ())], axis=1)
    pairs = zip(INTERVALS, bounds[::2], bounds[1::2], strict=True)
    about = {"dims": ("operation", "output", "bound"), "coords": {"bound": ["lower", "upper"]}}
    named = {"median": xr.DataArray(median, dims=about["dims"][:2])}
    return named | {name: xr.DataArray(np.stack(ends, -1), **about) for name, *ends in pairs}


def share_inside(
    values: np.ndarray, lower: np.ndarray, upper: np.ndarray, *, where: np.ndarray | bool = True
) -> np.ndarray:
    """Return the share of values inside their band along the last axis, ``(..., t) -> (...)``.

    Args:
        values: Measured curves; missing samples, NaN, do not count.
        lower, upper: Bounds, same shape.
        where: Samples that count, such as the main motion; the share is NaN if none count.
    """
    values = np.asarray(values)
    inside, counts = (values >= lower) & (values <= upper), ~np.isnan(values) & where
    with np.errstate(invalid="ignore"):
        return (inside & counts).sum(axis=-1) / counts.sum(axis=-1)


def correlation(draws: ArrayLike, *, log: ArrayLike) -> np.ndarray:
    """Return the correlation ``(q, q)`` of draws ``(d, q)``, in logarithms where ``log`` (q,)."""
    return np.corrcoef(_scaled(np.asarray(draws, dtype=np.float64), log), rowvar=False)


def regions(draws: ArrayLike) -> dict[tuple[int, int], tuple[np.ndarray, ...]]:
    """Return where a Gaussian kernel density of draws ``(d, q)`` is highest, for pairs of outputs.

    Returns:
        By the columns ``(i, j)`` of a pair, ``i < j``: values of both, ``(g,)`` each, the density
        on this grid, ``(g of j, g of i)``, and the levels above which 90 % and 50 % of the draws
        lie, ``(2,)``, rising. A pair whose draws lie on a line is left out.
    """
    from scipy.stats import gaussian_kde  # slow to import

    draws = np.asarray(draws, dtype=np.float64)
    low, high = draws.min(axis=0), draws.max(axis=0)
    room = 0.1 * (high - low)
    grids = np.linspace(low - room, high + room, 48)  # a finer grid is not visible in a panel
    densities = {}
    for i, j in zip(*np.triu_indices(draws.shape[1], 1), strict=True):
        pair = draws[:, [i, j]].T
        if not np.ptp(pair, axis=1).all() or abs(np.corrcoef(pair)[0, 1]) > 1.0 - 1e-9:
            continue
        kernel = gaussian_kde(pair)
        x, y = np.meshgrid(grids[:, i], grids[:, j])
        density = kernel([x.ravel(), y.ravel()]).reshape(x.shape)
        levels = np.quantile(kernel(pair), 1.0 - np.array(REGIONS))
        densities[int(i), int(j)] = grids[:, i], grids[:, j], density, levels
    return densities


# ---- posteriors of simulated records, whose truth is known ---------------------------------------


def scores(
    draws: ArrayLike, truth: ArrayLike, *, prior_sd: ArrayLike | None, log: ArrayLike
) -> tuple[np.ndarray, np.ndarray]:
    """Return z-score and contraction of posteriors, ``(n, q)`` each (paper, Fig. 5).

    The z-score is (posterior mean - truth) / posterior sd. Over the prior, z-scores of an exact
    posterior have mean 0 and sd 1, the sd with a standard error of 1/sqrt(2 n). Contraction is
    1 - posterior variance / prior variance, negative for a posterior wider than the prior.

    Args:
        draws: Posterior draws, ``(n, d, q)``.
        truth: True values, ``(n, q)``.
        prior_sd: Prior standard deviation ``(q,)`` in the scale of the score; the sd of the true
            values if None. It ignores the condition of the prior, which lowers the default's sd by
            less than 0.5 %.
        log: Outputs to take in logarithms, ``(q,)`` of bool.

    Raises:
        ValueError: If shapes do not fit, a value is not finite, a value to take the logarithm
            of is not positive, or a posterior has no width.
    """
    draws, truth = checked_draws(draws, truth)
    spread = _scaled(truth, log).std(axis=0, ddof=1) if prior_sd is None else prior_sd
    known = contraction(draws, prior_sd=spread, log=log)
    draws, truth = _scaled(draws, log), _scaled(truth, log)
    return (draws.mean(axis=1) - truth) / draws.std(axis=1, ddof=1), known


def contraction(draws: np.ndarray, *, prior_sd: ArrayLike, log: ArrayLike) -> np.ndarray:
    """Return 1 - posterior variance / prior variance, ``(n, q)``; arguments as for ``scores``."""
    sd = _scaled(draws, log).std(axis=1, ddof=1)
    if none := np.count_nonzero(np.ptp(draws, axis=1) == 0.0):  # their sd is rounding error
        raise ValueError(f"{none} posteriors have no width")
    return 1.0 - (sd / np.asarray(prior_sd, dtype=np.float64)) ** 2


@dataclass(frozen=True)
class Recovery:
    """Posterior summaries, in physical units.

    Attributes:
        median: Posterior medians, ``(n, q)``.
        interval_95: Central intervals, ``(n, q, 2)``.
        covered_50, covered_95: Shares of true values inside the intervals, ``(q,)``, by ranks.
        correlation: Pearson correlation of the medians with the truth, ``(q,)``.
    """

    median: np.ndarray
    interval_95: np.ndarray
    covered_50: np.ndarray
    covered_95: np.ndarray
    correlation: np.ndarray


def recovery(draws: ArrayLike, truth: ArrayLike) -> Recovery:
    """Summarise draws ``(n, d, q)`` and their truth ``(n, q)`` (paper, Sec. 6, Fig. 6)."""
    draws, truth = checked_draws(draws, truth)
    named = {name: item.values for name, item in intervals(draws).items()}
    columns = zip(named["median"].T, truth.T, strict=True)
    pearson = np.array([np.corrcoef(guess, actual)[0, 1] for guess, actual in columns])
    covered = coverage(ranks(draws, truth), draws.shape[1], levels=(0.5, 0.95))
    return Recovery(named["median"], named["interval_95"], *covered, pearson)


def _scaled(values: np.ndarray, log: ArrayLike) -> np.ndarray:
    """Take the logarithm of the columns (last axis) that ``log`` names."""
    log = np.asarray(log, dtype=bool)
    if not np.all(values[..., log] > 0):
        raise ValueError("values to take the logarithm of must be positive")
    scaled = values.copy()
    scaled[..., log] = np.log(values[..., log])
    return scaled


def scale_of(data: xr.Dataset) -> dict[str, np.ndarray | None]:
    """Return the scale in which a validation is judged, ``prior_sd`` and ``log``. A family's
    outputs, except times, are judged by their logarithm and the sd of the true values.
    """
    if "logarithmic" in data:
        return {"prior_sd": data.prior_sd.values, "log": data.logarithmic.values}
    return {"prior_sd": None, "log": is_logarithmic(data.output.values)}


def parameters_of(data: xr.Dataset) -> xr.Dataset:
    """Return a validation without the times of the drive's contact, which have no symbol."""
    if "logarithmic" in data:  # not a family: all outputs are parameters, with any names
        return data
    return data.isel(output=np.isin(data.output.values, [*NAMES, ONSET.name]))


def with_width(data: xr.Dataset) -> xr.Dataset:
    """Return a validation without curves whose draws are all equal (some unresolved records), as
    these have no sd and no score; return all curves if all are such.
    """
    wide = (np.ptp(data.draws.values, axis=1) > 0.0).all(axis=1)
    return data.isel(curve=wide) if wide.any() else data


# ---- prior predictive check ----------------------------------------------------------------------


@dataclass(frozen=True)
class PriorCheck:
    """Comparison of measured curves with curves of the prior.

    Attributes:
        median, lower, upper: Pointwise 95 % band of the prior's curves, ``(t,)``.
        inside: Share of the samples of each measured curve inside the band, ``(o,)``.
        least: Share inside that 95 % of the prior's curves reach. It is well below 0.95, because
            samples of one curve leave the band together.
    """

    median: np.ndarray
    lower: np.ndarray
    upper: np.ndarray
    inside: np.ndarray
    least: float


def prior_check(curves: ArrayLike, measured: ArrayLike) -> PriorCheck:
    """Compare measured curves ``(o, t)`` with curves ``(n, t)`` of the prior (paper, Fig. 3).

    Missing samples of measured curves, NaN, do not count.
    """
    median, lower, upper = np.quantile(curves, [0.5, 0.025, 0.975], axis=0)
    least = float(np.quantile(share_inside(curves, lower, upper), 0.05))
    return PriorCheck(median, lower, upper, share_inside(measured, lower, upper), least)


# ---- contraction against its limit ---------------------------------------------------------------


def reached(contractions: Mapping[str, np.ndarray], names: Sequence[str]) -> xr.Dataset:
    """Compare the contraction of posteriors with the limit of the exact posterior.

    Args:
        contractions: Contraction ``(n, q)`` of each source, any ``n``: ``limit``, the exact
            posterior, linearised, at draws from the prior; ``amortised`` and ``corrected``
            posteriors of simulated curves.

    Returns:
        ``mean``, ``lower`` and ``upper`` ``(source, output)``: mean, 5 % and 95 % over curves;
        ``curves (source)``; ``known (output)``, words of ``KNOWLEDGE`` for the limit's mean.
        Outputs are sorted by this mean, the highest first.
    """
    sources, dims = list(contractions.values()), ("source", "output")
    data = xr.Dataset(
        {
            "mean": (dims, np.stack([np.mean(values, axis=0) for values in sources])),
            "lower": (dims, np.stack([np.quantile(values, 0.05, axis=0) for values in sources])),
            "upper": (dims, np.stack([np.quantile(values, 0.95, axis=0) for values in sources])),
            "curves": ("source", [len(values) for values in sources]),
        },
        {"source": list(contractions), "output": list(names)},
    )
    limit = data["mean"].sel(source="limit").values
    known = [next(words for least, words in KNOWLEDGE if value >= least) for value in limit]
    return data.assign(known=("output", known)).isel(output=np.argsort(-limit, kind="stable"))


# ---- tables --------------------------------------------------------------------------------------


def quality(
    data: xr.Dataset, reader: xr.Dataset | None, limit: np.ndarray, **scale: ArrayLike | None
) -> pd.DataFrame:
    """Judge a validation, with one row per output.

    Args:
        data: Result of ``inference.validate``.
        reader: The same for records that were written to files and read; None if not available.
        limit: Mean contraction of an exact posterior, ``(q,)``.
        scale: Arguments ``prior_sd`` and ``log`` of ``scores``.

    Returns:
        Columns ``calibration_p`` (uniform ranks) and ``calibrated``, whether the output is inside
        its band (see ``judge_ranks``), both also with ``_reader`` for records from files (missing
        without ``reader``), ``z_mean``, ``z_sd``, ``contraction``, ``contraction_limit``, their
        difference ``shortfall``, and ``coverage_50``, ``coverage_95``.
    """
    draws, truth = data.draws.values, data.truth.values
    judged = judge_draws(draws, truth)
    files = None if reader is None else judge_draws(reader.draws.values, reader.truth.values)
    wide = with_width(data)
    z, known = scores(wide.draws.values, wide.truth.values, **scale)
    covered = coverage(ranks(draws, truth), data.sizes["draw"], levels=(0.5, 0.95))
    return pd.DataFrame(
        {
            "output": data.output.values,
            "calibration_p": judged.p_values,
            "calibration_p_reader": np.nan if files is None else files.p_values,
            "calibrated": ~judged.outside,
            "calibrated_reader": pd.NA if files is None else ~files.outside,
            "z_mean": z.mean(axis=0),
            "z_sd": z.std(axis=0, ddof=1),
            "contraction": known.mean(axis=0),
            "contraction_limit": limit,
            "shortfall": limit - known.mean(axis=0),
            "coverage_50": covered[0],
            "coverage_95": covered[1],
        }
    )


def family_quality(data: xr.Dataset, *, log: bool) -> pd.DataFrame:
    """Judge a network of a family on held-out drives, with one row per output.

    Args:
        data: Result of ``training_rows.sample_rows``.
        log: Whether to judge parameters by their logarithms.

    Returns:
        Columns ``output``, ``calibration_p`` and ``calibrated``, all outputs together at 99 %,
        ``coverage_90``, ``contraction`` (1 - mean square error of the posterior mean / variance of
        the true values, nan where this variance is 0), and in the scale of the judgement
        ``rms_error`` and ``half_width``, the median half width of 90 % intervals.
    """
    logs = log & np.isin(data.output.values, NAMES)
    draws, truth = (_scaled(data[name].values, logs) for name in ("draws", "truth"))
    rank, count = ranks(draws, truth), data.sizes["draw"]
    judged = judge_ranks(rank, count, alpha=0.01)
    square = np.square(draws.mean(axis=1) - truth).mean(axis=0)
    low, high = np.quantile(draws, [0.05, 0.95], axis=1)
    spread = truth.var(axis=0)
    spread[spread < 1e-12] = np.nan  # round-off of constant outputs
    return pd.DataFrame(
        {
            "output": data.output.values,
            "calibration_p": judged.p_values,
            "calibrated": ~judged.outside,
            "coverage_90": coverage(rank, count, levels=[0.9])[0],
            "contraction": 1.0 - square / spread,
            "rms_error": np.sqrt(square),
            "half_width": np.median(high - low, axis=0) / 2.0,
        }
    )


def summary(judged: xr.Dataset, corrected: xr.Dataset) -> pd.DataFrame:
    """Summarise the results of ``correction.judge`` and ``correct_validation`` in one row.

    Curves with unresolved evidence have no gap, and curves with faulty weights no efficiency. These
    numbers omit them. ``gap_curves`` counts curves with a gap, ``faulty_curves`` faulty ones.
    """
    curves, exact = judged.to_dataframe(), corrected[["efficiency", "rounds", "resolved"]]
    gap, exact = curves.gap[curves.resolved], exact.to_dataframe()
    numbers = {
        "motion": judged.attrs["motion"],
        "judged_curves": len(curves),
        "faulty_curves": (curves.faulty_weights > 0).sum(),
        "efficiency_median": curves.efficiency.median(),
        "efficiency_lowest": curves.efficiency.min(),
        "pareto_k_below_0.7": (curves.pareto_k < 0.7).mean(),
        "gap_curves": gap.count(),
        "gap_nats": gap.mean(),
        "gap_se": gap.sem(),
        "divergence_nats": curves.divergence.mean(),
        "c2st_median": curves.c2st.median(),
        "corrected_curves": len(exact),
        "resolved": exact.resolved.mean(),
        "corrected_efficiency_median": exact.efficiency.fillna(0.0).median(),
        "rounds_mean": exact.rounds.mean(),
    }
    return pd.DataFrame([numbers])


def table(result: xr.Dataset) -> pd.DataFrame:
    """Return one tidy row for each operation and output of the result of ``inference.infer``."""
    units = dict(zip(result.output.values, result.output_unit.values, strict=True))
    frame = result["median"].to_dataframe(name="median")[["median"]]
    for name in INTERVALS:
        for bound in ("lower", "upper"):
            frame[f"{name}_{bound}"] = result[name].sel(bound=bound, drop=True).to_series()
    frame = frame.reset_index()
    frame.insert(2, "unit", frame.output.map(units))
    fit = ("p_value", "misfit", "outside_prior", "accepted", "reason")
    record = ("file", "remarks", "missing", "masked", "family")
    measured = ("contact_time", "contact_sd", "reaction_time")  # only if any operation has them
    columns = [
        *(name for name in (*fit, *record) if name in result),
        *(name for name in measured if name in result and result[name].notnull().any()),
        *metadata_names(result),
    ]
    return frame.merge(result[columns].to_dataframe()[columns].reset_index(), on="operation")
