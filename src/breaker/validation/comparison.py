"""Amortised beside corrected posteriors, and what a motion lets one know: numbers and words.

*Amortised* are a network's own draws; *corrected* are those brought to the exact posterior. Arrays
and datasets in, datasets and words out, ready to be drawn.

Shapes: ``n`` curves, ``d`` draws, ``q`` outputs.
"""

from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr

from breaker.mechanism import ONSET, PARAMETERS, is_logarithmic

__all__ = [
    "VERDICTS",
    "compare",
    "exactness_words",
    "examples",
    "identifiability_words",
    "percent",
    "plus_minus",
    "reached",
]

VERDICTS = (
    (0.8, "known from this motion"),
    (0.5, "partly known"),
    (-np.inf, "the prior keeps it"),
)
"""What is said of an output, and the least mean contraction of the exact limit for it. Below 0.5
more than half of the prior's variance, and 71 % of its width, stay; from 0.8 on less than 45 %."""

_LEVELS = (0.5, 0.25, 0.75, 0.025, 0.975)
_BOUNDS = ("lower", "upper")
_SYMBOLS = {each.name: each.symbol for each in (*PARAMETERS, ONSET)}


def compare(
    amortised: np.ndarray, corrected: np.ndarray, truth: np.ndarray, names: Sequence[str]
) -> xr.Dataset:
    """Bring two posteriors of one curve to one scale: the corrected one's.

    Zero is the median of the corrected posterior, one its standard deviation, in logarithms of
    the parameters and in plain ms of the onset.

    Args:
        amortised: Draws in physical units, ``(d, q)``.
        corrected: The same, of any number of draws.
        truth: Values that made the curve, ``(q,)``.
        names: Names of the outputs.

    Returns:
        ``median (posterior, output)``, ``interval_50`` and ``interval_95``
        ``(posterior, output, bound)``, central, and ``truth (output)``.

    Raises:
        ValueError: If shapes do not fit, a value is not finite or a parameter not positive, or
            the corrected posterior has no width.
    """
    log = is_logarithmic(names)
    values = [np.array(each, dtype=np.float64) for each in (amortised, corrected, [truth])]
    for each in values:
        if each.ndim != 2 or each.shape[1] != len(names):
            raise ValueError(f"draws must be (d, {len(names)}), got {each.shape}")
        if not np.all(np.isfinite(each)) or not np.all(each[:, log] > 0):
            raise ValueError("draws and truth must be finite, and parameters positive")
        each[:, log] = np.log(each[:, log])
    centre, sd = np.median(values[1], axis=0), values[1].std(axis=0, ddof=1)
    if not np.all(sd > 0):
        raise ValueError("the corrected posterior has no width, and gives no scale")
    scaled = [(each - centre) / sd for each in values]
    levels = np.stack([np.quantile(each, _LEVELS, axis=0) for each in scaled[:2]])
    dims, bands = ("posterior", "output"), np.moveaxis(levels, 1, -1)
    return xr.Dataset(
        {
            "median": (dims, bands[..., 0]),
            "interval_50": ((*dims, "bound"), bands[..., 1:3]),
            "interval_95": ((*dims, "bound"), bands[..., 3:]),
            "truth": ("output", scaled[2][0]),
        },
        {"posterior": ["amortised", "corrected"], "output": list(names), "bound": list(_BOUNDS)},
    )


def examples(judged: xr.Dataset, amortised: xr.Dataset, corrected: xr.Dataset) -> xr.Dataset:
    """Compare the curves of the lowest, the median and the highest efficiency.

    Those without an efficiency, or without corrected draws of some width, cannot be compared and
    are passed over.

    Args:
        judged: What ``exactness.judge`` returns; its curves are the first of the other two.
        amortised: What ``inference.validate`` returns.
        corrected: What ``exactness.correct_validation`` made of it.

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
    """Say a share in per cent, small ones to two digits."""
    if not np.isfinite(share):
        return "not known"
    return f"{100 * share:.0f} %" if share >= 0.1 else f"{100 * share:.2g} %"


def exactness_words(row: Mapping) -> str:
    """Say what a row of ``exactness.summary`` shows, in one line."""
    resolved, curves = round(row["resolved"] * row["corrected_curves"]), row["corrected_curves"]
    return (
        f"median efficiency {percent(row['efficiency_median'])}, "
        f"gap {plus_minus(row['gap_nats'], row['gap_se'])}, "
        f"{resolved} of {curves} curves resolved"
    )


def plus_minus(mean: float, error: float) -> str:
    """Say a mean of nats and its standard error."""
    if not np.isfinite(mean):
        return "not known" if np.isnan(mean) else "infinite"
    return f"{mean:.2f} nats (one curve)" if np.isnan(error) else f"{mean:.2f} ± {error:.2f} nats"


def reached(
    limit: np.ndarray, amortised: np.ndarray, corrected: np.ndarray, names: Sequence[str]
) -> xr.Dataset:
    """Put the contraction that posteriors reach beside the exact limit.

    Args:
        limit: Contraction of the exact posterior, linearised, at draws from the prior, ``(n, q)``.
        amortised: Contraction of the network's posteriors, ``(n, q)``; any other ``n``.
        corrected: Contraction of the corrected posteriors, ``(n, q)``; any other ``n``.
        names: Names of the outputs.

    Returns:
        ``mean``, ``lower`` and ``upper`` ``(source, output)``: mean, 5 % and 95 % over curves;
        ``curves (source)``; ``verdict (output)``, in words, by the limit's mean. Outputs are
        sorted, the one of which the curve says the most first.

    Raises:
        ValueError: If shapes do not fit or a value is not finite.
    """
    sources = {"limit": limit, "amortised": amortised, "corrected": corrected}
    for source, values in sources.items():
        if np.ndim(values) != 2 or np.shape(values)[1] != len(names):
            raise ValueError(f"{source} must be (n, {len(names)}), got {np.shape(values)}")
        if not np.all(np.isfinite(values)):
            raise ValueError(f"{source} must be finite")
    mean, (lower, upper) = (
        np.stack([np.mean(each, axis=0) for each in sources.values()]),
        np.stack([np.quantile(each, (0.05, 0.95), axis=0) for each in sources.values()], axis=1),
    )
    dims = ("source", "output")
    data = xr.Dataset(
        {
            "mean": (dims, mean),
            "lower": (dims, lower),
            "upper": (dims, upper),
            "curves": ("source", [len(each) for each in sources.values()]),
            "verdict": ("output", [_verdict(each) for each in mean[0]]),
        },
        {"source": list(sources), "output": list(names)},
    )
    return data.isel(output=np.argsort(-mean[0], kind="stable"))


def _verdict(contraction: float) -> str:
    return next(words for least, words in VERDICTS if contraction >= least)


def identifiability_words(data: xr.Dataset) -> str:
    """Say what :func:`reached` shows, in one line: what the prior keeps, what is partly known."""
    named = {words: [] for _, words in VERDICTS}
    for name, words in zip(data.output.values, data.verdict.values, strict=True):
        named[str(words)].append(_SYMBOLS[str(name)])
    _, partly, kept = named.values()
    words = f"the prior keeps {_list(kept)}" if kept else "the prior keeps nothing"
    return words + (f"; {_list(partly)} partly known" if partly else "")


def _list(symbols: Sequence[str]) -> str:
    return " and ".join(filter(None, [", ".join(symbols[:-1]), symbols[-1]]))
