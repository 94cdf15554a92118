"""Amortised beside corrected posteriors, and what a motion determines: numbers and words.

*Amortised* are a network's own draws; *corrected* are those brought to the exact posterior. Arrays
and datasets in, datasets and words out, ready to be drawn.

Shapes: ``n`` curves, ``d`` draws, ``q`` outputs.
"""

from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr

from breaker.common.numerals import in_digits
from breaker.paper.posterior.posterior_tables import quantiles
from breaker.quantities.parameters import ONSET, PARAMETERS, is_logarithmic

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
