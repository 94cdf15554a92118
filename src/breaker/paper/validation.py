"""Is a posterior unbiased, and how much does it know? Arrays in, arrays out.

z-score and contraction, recovery of the truth, and summaries of curves (paper, Sec. 5 and 6). Its
calibration by ranks is in ``calibration``.

Shapes: ``n`` simulations, ``d`` draws, ``q`` outputs, ``t`` samples.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import ArrayLike

from breaker.common.numerals import in_digits, in_p
from breaker.model.parameters import NAMES, ONSET, PARAMETERS, is_logarithmic
from breaker.model.quantities import metadata_names
from breaker.paper.calibration import checked_draws, coverage, judge_draws, judge_ranks, ranks

REGIONS = (0.9, 0.5)
"""Shares of the draws that the regions of :func:`regions` hold, the widest first."""

_GRID, _ON_A_LINE = 48, 1e-9  # values of a density, and how far a correlation is below 1


_INTERVALS = {"interval_50": (0.25, 0.75), "interval_95": (0.025, 0.975)}

_OF_RESULT = ("p_value", "misfit", "outside_prior", "outside_support", "accepted", "reason")
_OF_RECORD = ("file", "remarks", "missing", "masked", "far_onset", "family")
_MEASURED = ("contact_time", "contact_sd", "latch_time")  # where any operation has them


def quantiles(draws: np.ndarray, *, axis: int) -> dict[str, np.ndarray]:
    """Return median and central intervals of draws, without the axis of the draws.

    Returns:
        ``median (...)``, ``interval_50`` and ``interval_95``, ``(..., 2)``: lower and upper bound.

    Example:
        >>> quantiles(np.arange(101.0), axis=0)["interval_50"].tolist()
        [25.0, 75.0]
    """
    levels = np.quantile(draws, [0.5, *sum(_INTERVALS.values(), ())], axis=axis)
    bounds = np.moveaxis(levels[1:], 0, -1)
    pairs = {name: bounds[..., 2 * i : 2 * i + 2] for i, name in enumerate(_INTERVALS)}
    return {"median": levels[0], **pairs}


def intervals(draws: np.ndarray) -> dict[str, xr.DataArray]:
    """Return ``median``, ``interval_50`` and ``interval_95`` of draws ``(o, d, q)``, with names."""
    bounds = {"dims": ("operation", "output", "bound"), "coords": {"bound": ["lower", "upper"]}}
    median, *pairs = quantiles(draws, axis=1).items()
    named = {"median": xr.DataArray(median[1], dims=("operation", "output"))}
    return named | {name: xr.DataArray(each, **bounds) for name, each in pairs}


def share_inside(
    values: np.ndarray, lower: np.ndarray, upper: np.ndarray, *, where: np.ndarray | bool = True
) -> np.ndarray:
    """Return the share of the last axis on which values lie in their band, ``(..., t) -> (...)``.

    Args:
        values: Measured curves; NaN where a sample is missing, which does not count.
        lower: Lower bound, same shape.
        upper: Upper bound, same shape.
        where: Samples that count, such as those of the main motion; all of them by default.

    Returns:
        The shares; NaN where no sample counts.
    """
    values = np.asarray(values)
    inside, counts = (values >= lower) & (values <= upper), ~np.isnan(values) & where
    with np.errstate(invalid="ignore"):
        return (inside & counts).sum(axis=-1) / counts.sum(axis=-1)


def table(result: xr.Dataset) -> pd.DataFrame:
    """Return one tidy row for each operation and output of what ``infer`` returns."""
    units = dict(zip(result.output.values, result.output_unit.values, strict=True))
    frame = result["median"].to_dataframe(name="median")[["median"]]
    for name in _INTERVALS:
        for bound in ("lower", "upper"):
            values = result[name].sel(bound=bound, drop=True)
            frame[f"{name}_{bound}"] = values.to_series()
    frame = frame.reset_index()
    frame.insert(2, "unit", frame.output.map(units))
    measured = (name for name in _MEASURED if name in result and result[name].notnull().any())
    columns = [
        *(n for n in (*_OF_RESULT, *_OF_RECORD) if n in result),
        *measured,
        *metadata_names(result),
    ]
    return frame.merge(result[columns].to_dataframe()[columns].reset_index(), on="operation")


def summary(judged: xr.Dataset, corrected: xr.Dataset) -> pd.DataFrame:
    """Sum up what ``judge`` and ``correct_validation`` return, in one row.

    The gap's standard error is that of a mean over curves. Curves whose evidence is not resolved
    have no gap, and those with faulty weights no efficiency: they are left out of these numbers
    (an infinite gap is not), and ``gap_curves`` and ``faulty_curves`` say how many there are.
    """
    gap = judged["gap"].values[judged.resolved.values & ~np.isnan(judged["gap"].values)]
    sound = judged.isel(curve=judged.faulty_weights.values == 0)
    efficiency = sound.efficiency.values if sound.sizes["curve"] else np.array([np.nan])
    numbers = {
        "motion": judged.attrs["motion"],
        "judged_curves": judged.sizes["curve"],
        "faulty_curves": judged.sizes["curve"] - sound.sizes["curve"],
        "efficiency_median": np.median(efficiency),
        "efficiency_10_percent": np.quantile(efficiency, 0.1),
        "efficiency_lowest": efficiency.min(),
        "pareto_k_below_0.7": np.mean(judged.pareto_k.values < 0.7),
        "gap_curves": gap.size,
        "gap_nats": gap.mean() if gap.size else np.nan,
        "gap_se": gap.std(ddof=1) / np.sqrt(gap.size) if gap.size > 1 else np.nan,
        "divergence_nats": sound.divergence.values.mean() if sound.sizes["curve"] else np.nan,
        "c2st_median": np.median(sound.c2st.values) if sound.sizes["curve"] else np.nan,
        "truth_log_density": judged.truth_log_density.values.mean(),
        "corrected_curves": corrected.sizes["curve"],
        "resolved": corrected.resolved.values.mean(),
        "corrected_efficiency_median": np.nanmedian(corrected.efficiency.fillna(0.0).values),
        "rounds_mean": corrected.rounds.values.mean(),
    }
    return pd.DataFrame({name: [value] for name, value in numbers.items()})


@dataclass(frozen=True)
class Scores:
    """Bias, width and information of posteriors, per curve and summarised.

    Attributes:
        z: (posterior mean - truth) / posterior sd, ``(n, q)``.
        contraction: 1 - posterior variance / prior variance, ``(n, q)``. Never clipped: negative
            where a posterior is wider than the prior.
        z_mean: Mean z-score, ``(q,)``; 0 for an exact posterior.
        z_sd: Standard deviation of the z-score, ``(q,)``; 1 for an exact posterior on average
            over the prior (exactly for a Gaussian one), with standard error 1/sqrt(2 n).
        mean_contraction: Mean contraction, ``(q,)``.
    """

    z: np.ndarray
    contraction: np.ndarray
    z_mean: np.ndarray
    z_sd: np.ndarray
    mean_contraction: np.ndarray


def scores(
    draws: ArrayLike, truth: ArrayLike, *, prior_sd: ArrayLike | None, log: ArrayLike
) -> Scores:
    """Return z-score and contraction of each curve (paper, Sec. 6, Fig. 5).

    Both are taken in log parameters where ``log`` says so, in plain units elsewhere (the onset).

    Args:
        draws: Posterior draws, ``(n, d, q)``, physical units.
        truth: Values that made the data, ``(n, q)``.
        prior_sd: Prior standard deviation ``(q,)`` in the same scale as the score: the log-sd of
            a parameter, the sd in ms of the onset. Conditioning the prior on a positive wipe
            lowers the log-sds by less than half a percent at the default and is left out. That
            of the truths if None.
        log: Which outputs are taken in logarithms, ``(q,)`` of bool.

    Raises:
        ValueError: If shapes do not fit, a value is not finite, a value to take the logarithm
            of is not positive, or a posterior has no width.
    """
    draws, truth = checked_draws(draws, truth)
    spread = _scaled(truth, log).std(axis=0, ddof=1) if prior_sd is None else prior_sd
    known = contraction(draws, prior_sd=spread, log=log)
    draws, truth = _scaled(draws, log), _scaled(truth, log)
    z = (draws.mean(axis=1) - truth) / draws.std(axis=1, ddof=1)
    return Scores(z, known, z.mean(axis=0), z.std(axis=0, ddof=1), known.mean(axis=0))


def contraction(draws: np.ndarray, *, prior_sd: ArrayLike, log: ArrayLike) -> np.ndarray:
    """Return 1 - posterior variance / prior variance of draws ``(n, d, q)``, ``(n, q)``.

    Args and errors are those of :func:`scores`.
    """
    sd = _scaled(draws, log).std(axis=1, ddof=1)
    if none := np.count_nonzero(np.ptp(draws, axis=1) == 0.0):  # rounding leaves them an sd
        raise ValueError(f"{none} posteriors have no width")
    return 1.0 - (sd / np.asarray(prior_sd, dtype=np.float64)) ** 2


@dataclass(frozen=True)
class Recovery:
    """Posterior summaries beside the truth, in physical units.

    Attributes:
        truth: Values that made the data, ``(n, q)``.
        median: Posterior median, ``(n, q)``.
        interval_50: Central 50 % interval, ``(n, q, 2)``.
        interval_95: Central 95 % interval, ``(n, q, 2)``.
        covered_50, covered_95: Share of the true values inside these intervals, ``(q,)``, by ranks.
        correlation: Pearson correlation of the medians with the truth, ``(q,)``.
    """

    truth: np.ndarray
    median: np.ndarray
    interval_50: np.ndarray
    interval_95: np.ndarray
    covered_50: np.ndarray
    covered_95: np.ndarray
    correlation: np.ndarray


def recovery(draws: ArrayLike, truth: ArrayLike) -> Recovery:
    """Summarise draws ``(n, d, q)`` beside their truth ``(n, q)`` (paper, Sec. 6, Fig. 6).

    Raises:
        ValueError: If shapes do not fit or a value is not finite.
    """
    draws, truth = checked_draws(draws, truth)
    found = quantiles(draws, axis=1)
    columns = zip(found["median"].T, truth.T, strict=True)
    pearson = np.array([np.corrcoef(guess, actual)[0, 1] for guess, actual in columns])
    half, most = coverage(ranks(draws, truth), draws.shape[1], levels=(0.5, 0.95))
    return Recovery(truth, **found, covered_50=half, covered_95=most, correlation=pearson)


def correlation(draws: ArrayLike, *, log: ArrayLike) -> np.ndarray:
    """Return the correlation ``(q, q)`` of draws ``(d, q)``, of logarithms by ``log (q,)``."""
    return np.corrcoef(_scaled(np.asarray(draws, dtype=np.float64), log), rowvar=False)


def regions(draws: ArrayLike) -> dict[tuple[int, int], tuple[np.ndarray, ...]]:
    """Return where the density of draws is highest, of each pair of outputs.

    A Gaussian kernel estimates the density. A pair whose draws lie on a line has none.

    Args:
        draws: Draws, ``(d, q)``, physical units.

    Returns:
        By the columns ``(i, j)`` of a pair, ``i < j``: values of both, ``(g,)`` each, the density
        there, ``(g of j, g of i)``, and the levels above which 90 % and 50 % of the draws lie,
        ``(2,)``, rising.
    """
    from scipy.stats import gaussian_kde  # which takes long to import

    draws = np.asarray(draws, dtype=np.float64)
    low, high = draws.min(axis=0), draws.max(axis=0)
    room = 0.1 * (high - low)
    grids = np.linspace(low - room, high + room, _GRID)
    found = {}
    for i, j in zip(*np.triu_indices(draws.shape[1], 1), strict=True):
        pair = draws[:, [i, j]].T
        if not np.ptp(pair, axis=1).all() or abs(np.corrcoef(pair)[0, 1]) > 1.0 - _ON_A_LINE:
            continue
        kernel = gaussian_kde(pair)
        x, y = np.meshgrid(grids[:, i], grids[:, j])
        density = kernel([x.ravel(), y.ravel()]).reshape(x.shape)
        levels = np.quantile(kernel(pair), 1.0 - np.array(REGIONS))
        found[int(i), int(j)] = grids[:, i], grids[:, j], density, levels
    return found


@dataclass(frozen=True)
class PriorCheck:
    """Comparison of measured curves with curves of the prior.

    Attributes:
        median, lower, upper: Pointwise 95 % band of the prior's curves, ``(t,)``.
        inside: Share of the samples of each measured curve inside the band, ``(o,)``.
        least: Share inside that 95 % of the prior's own curves reach. Samples of one curve
            leave the band together, so that this share is well below 0.95.
    """

    median: np.ndarray
    lower: np.ndarray
    upper: np.ndarray
    inside: np.ndarray
    least: float


def prior_check(curves: ArrayLike, measured: ArrayLike) -> PriorCheck:
    """Hold measured curves ``(o, t)`` against curves ``(n, t)`` of the prior (paper, Fig. 3).

    Missing samples of measured curves, NaN, do not count.
    """
    median, lower, upper = np.quantile(curves, [0.5, 0.025, 0.975], axis=0)
    least = float(np.quantile(share_inside(curves, lower, upper), 0.05))
    return PriorCheck(median, lower, upper, share_inside(measured, lower, upper), least)


def _scaled(values: np.ndarray, log: ArrayLike) -> np.ndarray:
    """Take the logarithm of the columns (last axis) that ``log`` names."""
    log = np.asarray(log, dtype=bool)
    if not np.all(values[..., log] > 0):
        raise ValueError("values to take the logarithm of must be positive")
    scaled = values.copy()
    scaled[..., log] = np.log(values[..., log])
    return scaled


# ---- what came out, in one line for the title of its figure --------------------------------------


def recovery_words(found: Recovery) -> str:
    """State how many of the true values intervals contain, over all outputs.

    >>> draws = [[[1], [2], [3], [4], [5]], [[2], [4], [6], [8], [10]]]
    >>> recovery_words(recovery(draws, [[3.1], [8.1]]))
    '95 % intervals contain 100 % of the true values, 50 % intervals 100 %'
    """
    ends = (_from_to(found.covered_95), _from_to(found.covered_50))
    return "95 % intervals contain {} of the true values, 50 % intervals {}".format(*ends)


def _from_to(shares: np.ndarray) -> str:
    low, high = percent(shares.min()), percent(shares.max())
    return high if low == high else f"{low.removesuffix(' %')} to {high}"


def contraction_words(
    scores: Scores, symbols: Sequence[str], limit: np.ndarray | None = None
) -> str:
    """State what is known best and least, how far from the limit, and the z-scores.

    Args:
        scores: From ``diagnostics.scores``.
        symbols: Names of the ``q`` outputs.
        limit: Mean contraction of the exact posterior, linearised, ``(q,)``, if known.
    """
    mean = scores.mean_contraction
    best, least = mean.argmax(), mean.argmin()
    told = f"best known: {symbols[best]} ({mean[best]:.2f})"
    if least != best:
        told += f", least: {symbols[least]} ({mean[least]:.2f})"
    if limit is not None:
        short = (np.asarray(limit) - mean).max()
        told += f"; {f'at most {in_digits(short, 1)}' if short > 0 else 'not'} below the limit"
    return f"{told}; z-score sd {scores.z_sd.min():.2f} to {scores.z_sd.max():.2f}"


def pairs_words(
    draws: np.ndarray, truth: np.ndarray, correlation: np.ndarray, symbols: Sequence[str]
) -> str:
    """State for one record how many true values intervals contain, and what is known as a pair.

    >>> import numpy as np
    >>> draws = np.linspace([0.0, 1.0], [1.0, 0.0], 101)
    >>> pairs_words(draws, np.array([0.5, 2.0]), np.corrcoef(draws, rowvar=False), ["a", "b"])
    '95 % intervals contain 1 of 2 true values; closest pair: a and b (−1.00)'

    Args:
        draws: Draws of the posterior, ``(d, q)``.
        truth: Values that made the record, ``(q,)``.
        correlation: Of the draws, ``(q, q)``.
        symbols: Names of the ``q`` outputs.
    """
    low, high = np.quantile(draws, [0.025, 0.975], axis=0)
    inside = int(((truth >= low) & (truth <= high)).sum())
    told = f"95 % intervals contain {inside} of {len(truth)} true values"
    if len(truth) < 2:
        return told
    i, j = np.unravel_index(np.argmax(np.abs(np.triu(correlation, 1))), correlation.shape)
    value = f"{correlation[i, j]:+.2f}".replace("-", "−")
    return f"{told}; closest pair: {symbols[i]} and {symbols[j]} ({value})"


# ---- amortised against exact ----


KNOWLEDGE = (
    (0.8, "known from this motion"),
    (0.5, "partly known"),
    (-np.inf, "the prior decides"),
)
"""Least mean contraction of the exact posterior, and what it means for an output. Below 0.5 more
than half of the prior's variance, and 71 % of its width, stay; from 0.8 on less than 45 %."""

_BOUNDS = ("lower", "upper")
_SYMBOLS = {each.name: each.symbol for each in (*PARAMETERS, ONSET)}


def compare(
    amortised: np.ndarray, corrected: np.ndarray, truth: np.ndarray, names: Sequence[str]
) -> xr.Dataset:
    """Bring draws ``(d, q)`` of two posteriors, and the truth ``(q,)``, to the corrected scale.

    Zero is the median of the corrected posterior, one its standard deviation, in logarithms of
    the parameters and in plain ms of the onset.

    Returns:
        ``median (posterior, output)``, ``interval_50`` and ``interval_95``
        ``(posterior, output, bound)``, central, and ``truth (output)``.
    """
    log = is_logarithmic(names)
    values = [np.array(each, dtype=np.float64) for each in (amortised, corrected, [truth])]
    for each in values:
        each[:, log] = np.log(each[:, log])
    centre, sd = np.median(values[1], axis=0), values[1].std(axis=0, ddof=1)
    scaled = [(each - centre) / sd for each in values]
    found = [quantiles(each, axis=0) for each in scaled[:2]]
    dims = {"median": ("posterior", "output")}
    bands = {
        name: (dims.get(name, ("posterior", "output", "bound")), np.stack([f[name] for f in found]))
        for name in found[0]
    }
    return xr.Dataset(
        {**bands, "truth": ("output", scaled[2][0])},
        {"posterior": ["amortised", "corrected"], "output": list(names), "bound": list(_BOUNDS)},
    )


def examples(judged: xr.Dataset, amortised: xr.Dataset, corrected: xr.Dataset) -> xr.Dataset:
    """Compare the curves of the lowest, the median and the highest efficiency.

    Those without an efficiency, or without corrected draws of some width, cannot be compared and
    are passed over.

    Args:
        judged: What ``exact_judge.judge`` returns; its curves are the first of the other two.
        amortised: What ``amortised.validate`` returns.
        corrected: What ``exact_judge.correct_validation`` made of it.

    Returns:
        What :func:`compare` returns along ``example``, with ``place`` ("lowest", "median" or
        "highest"), ``curve`` (counted from 0), ``efficiency``, ``pareto_k`` and ``resolved`` of
        each. Where fewer than three can be compared, ``example`` is that short, down to none.
    """
    n = judged.sizes["curve"]
    dims = ("curve", "draw", "output")
    own, exact = (
        each.draws.transpose(*dims).values[:n].astype(np.float64) for each in (amortised, corrected)
    )
    truth = amortised.truth.transpose("curve", "output").values
    efficiency = judged.efficiency.values
    with_width = np.isfinite(exact).all(axis=(1, 2)) & (np.ptp(exact, axis=1) > 0).all(axis=1)
    usable = np.flatnonzero(np.isfinite(efficiency) & with_width)
    if not usable.size:
        return xr.Dataset(coords={"example": np.arange(0)})
    usable = usable[np.argsort(efficiency[usable], kind="stable")]
    last = usable.size - 1
    places = {0: "lowest", last: "highest"}
    if usable.size != 2:  # a single one is its own median
        places[last // 2] = "median"
    chosen = {int(usable[at]): places[at] for at in sorted(places)}
    names = [str(name) for name in amortised.output.values]
    each = [compare(own[i], exact[i], truth[i], names) for i in chosen]
    return xr.concat(each, "example").assign(
        place=("example", list(chosen.values())),
        curve=("example", list(chosen)),
        **{
            name: ("example", judged[name].values[list(chosen)])
            for name in ("efficiency", "pareto_k", "resolved")
        },
    )


def percent(share: float) -> str:
    """Write a share in per cent, small ones with two digits."""
    if not np.isfinite(share):
        return "not known"
    return f"{100 * share:.0f} %" if share >= 0.1 else f"{in_digits(100 * share, 2)} %"


def exactness_words(row: Mapping[str, float]) -> str:
    """Describe a row of ``posterior_tables.summary`` in one line."""
    resolved, curves = round(row["resolved"] * row["corrected_curves"]), row["corrected_curves"]
    return (
        f"median efficiency {percent(row['efficiency_median'])}, "
        f"gap {plus_minus(row['gap_nats'], row['gap_se'])}, "
        f"{resolved} of {curves} curves resolved"
    )


def plus_minus(mean: float, error: float) -> str:
    """Write a mean of nats and its standard error."""
    if not np.isfinite(mean):
        return "not known" if np.isnan(mean) else "infinite"
    return f"{mean:.2f} nats (one curve)" if np.isnan(error) else f"{mean:.2f} ± {error:.2f} nats"


def reached(contractions: Mapping[str, np.ndarray], names: Sequence[str]) -> xr.Dataset:
    """Put the contraction that posteriors reach beside the limit of the exact one.

    Args:
        contractions: Contraction ``(n, q)`` of each source, any ``n``: ``limit``, the exact
            posterior, linearised, at draws from the prior; ``amortised`` and ``corrected``
            posteriors of simulated curves.

    Returns:
        ``mean``, ``lower`` and ``upper`` ``(source, output)``: mean, 5 % and 95 % over curves;
        ``curves (source)``; ``known (output)``, in words, by the limit's mean. The outputs are
        sorted by that mean, the highest first.
    """
    each = list(contractions.values())
    mean = np.stack([np.mean(values, axis=0) for values in each])
    ends = np.stack([np.quantile(values, (0.05, 0.95), axis=0) for values in each])
    dims = ("source", "output")
    data = xr.Dataset(
        {
            "mean": (dims, mean),
            "lower": (dims, ends[:, 0]),
            "upper": (dims, ends[:, 1]),
            "curves": ("source", [len(values) for values in each]),
        },
        {"source": list(contractions), "output": list(names)},
    )
    limit = data["mean"].sel(source="limit").values
    known = [next(words for least, words in KNOWLEDGE if value >= least) for value in limit]
    return data.assign(known=("output", known)).isel(output=np.argsort(-limit, kind="stable"))


def identifiability_words(data: xr.Dataset) -> str:
    """Name the outputs that the prior decides, and those partly known, by the limit's mean."""
    means = zip(data.output.values, data["mean"].sel(source="limit").values, strict=True)
    partly, prior = [], []
    for name, mean in means:
        if mean < KNOWLEDGE[0][0]:
            (partly if mean >= KNOWLEDGE[1][0] else prior).append(_SYMBOLS[str(name)])
    words = f"over the prior: the prior decides {_list(prior) if prior else 'nothing'}"
    return words + (f"; {_list(partly)} partly known" if partly else "")


def _list(symbols: Sequence[str]) -> str:
    return " and ".join(filter(None, [", ".join(symbols[:-1]), symbols[-1]]))


# ---- quality tables ----


_FAMILY_LEVEL = 0.01
_SAME = 1e-12  # variance of what does not vary


def quality(
    data: xr.Dataset,
    reader: xr.Dataset | None,
    limit: np.ndarray,
    *,
    prior_sd: np.ndarray,
    log: np.ndarray,
) -> pd.DataFrame:
    """Judge a validation: one row an output.

    Args:
        data: What ``amortised.validate`` returns.
        reader: The same from records that went through files, if there is one.
        limit: Mean contraction of an exact posterior, ``(q,)``.
        prior_sd: Prior sd of each output, ``(q,)``, in the scale of the next argument.
        log: Which outputs are judged by their logarithm, ``(q,)``.

    Returns:
        Columns ``calibration_p`` (uniform ranks) and ``calibrated``, whether the output is inside
        its band (see ``judge_ranks``), both again with ``_reader`` for records through files
        (missing without), ``z_mean``, ``z_sd``, ``contraction``, ``contraction_limit`` and their
        ``shortfall``, and ``coverage_50``, ``coverage_95``.
    """
    draws, truth = data.draws.values, data.truth.values
    judged = judge_draws(draws, truth)
    files = None if reader is None else judge_draws(reader.draws.values, reader.truth.values)
    wide = with_width(data)
    found = scores(wide.draws.values, wide.truth.values, prior_sd=prior_sd, log=log)
    covered = coverage(ranks(draws, truth), data.sizes["draw"], levels=(0.5, 0.95))
    return pd.DataFrame(
        {
            "output": data.output.values,
            "calibration_p": judged.p_values,
            "calibration_p_reader": np.nan if files is None else files.p_values,
            "calibrated": ~judged.outside,
            "calibrated_reader": pd.NA if files is None else ~files.outside,
            "z_mean": found.z_mean,
            "z_sd": found.z_sd,
            "contraction": found.mean_contraction,
            "contraction_limit": limit,
            "shortfall": limit - found.mean_contraction,
            "coverage_50": covered[0],
            "coverage_95": covered[1],
        }
    )


def family_quality(data: xr.Dataset, *, log: bool) -> pd.DataFrame:
    """Judge a network of a family on held-out drives: one row an output.

    Args:
        data: What ``training_rows.sample_rows`` returns.
        log: Whether parameters are judged by their logarithms.

    Returns:
        Columns ``output``, ``calibration_p`` and ``calibrated``, all outputs together at 99 %,
        ``coverage_90``, ``contraction`` (1 - mean square error of the posterior mean over the
        variance of the truth, nan where that does not vary), ``rms_error`` and ``half_width``, the
        median half width of 90 % intervals; both in the scale that an output is judged in.
    """
    draws, truth = data.draws.values, data.truth.values
    logs = log & np.isin(data.output.values, NAMES)
    draws, truth = (np.where(logs, np.log(np.where(logs, a, 1.0)), a) for a in (draws, truth))
    found = ranks(draws, truth)
    judged = judge_ranks(found, data.sizes["draw"], alpha=_FAMILY_LEVEL)
    error = draws.mean(axis=1) - truth
    low, high = np.quantile(draws, [0.05, 0.95], axis=1)
    spread = truth.var(axis=0)
    varies = spread > _SAME
    return pd.DataFrame(
        {
            "output": data.output.values,
            "calibration_p": judged.p_values,
            "calibrated": ~judged.outside,
            "coverage_90": coverage(found, data.sizes["draw"], levels=[0.9])[0],
            "contraction": 1.0 - np.square(error).mean(axis=0) / np.where(varies, spread, np.nan),
            "rms_error": np.sqrt(np.square(error).mean(axis=0)),
            "half_width": np.median(high - low, axis=0) / 2.0,
        }
    )


def scale_of(data: xr.Dataset) -> dict[str, np.ndarray | None]:
    """Return the scale in which the outputs of a validation are judged: ``prior_sd`` and ``log``.

    A validation of a family has none: all but times are judged by their logarithm, and the spread
    of the true values counts.
    """
    if "logarithmic" in data:
        return {"prior_sd": data.prior_sd.values, "log": data.logarithmic.values}
    return {"prior_sd": None, "log": is_logarithmic(data.output.values)}


def parameters_of(data: xr.Dataset) -> xr.Dataset:
    """Return a validation without the times of the drive's own contact, which has no symbol."""
    if "logarithmic" in data:  # not of a family: all are parameters, whatever their names
        return data
    return data.isel(output=np.isin(data.output.values, [*NAMES, ONSET.name]))


def with_width(data: xr.Dataset) -> xr.Dataset:
    """Return a validation without curves whose draws are all the same one; all if each is so.

    Such a posterior is of a record that was not resolved: it has a place, but neither sd nor score.
    """
    wide = (np.ptp(data.draws.values, axis=1) > 0.0).all(axis=1)
    return data.isel(curve=wide) if wide.any() else data


def quality_words(table: pd.DataFrame) -> str:
    """Describe a table of :func:`quality` in one line."""
    worst = table.loc[table.shortfall.idxmax()]
    files = ""
    if not table.calibration_p_reader.isna().any():
        files = f"; through files {_calibrated(table, '_reader')}"
    return (
        f"{_calibrated(table)}{files}; "
        f"z-score sd {table.z_sd.min():.3f} to {table.z_sd.max():.3f}; "
        f"largest shortfall of contraction {worst.shortfall:.3f} ({worst.output})"
    )


def _calibrated(table: pd.DataFrame, which: str = "") -> str:
    outside = table.output[~table[f"calibrated{which}"].astype(bool)]
    smallest = f"smallest {in_p(table[f'calibration_p{which}'].min())} of {len(table)}"
    if outside.empty:
        return f"calibrated ({smallest})"
    return f"NOT calibrated: {', '.join(outside)} ({smallest})"
