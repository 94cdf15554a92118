"""Change points and remaining life held against the truth of simulated lives."""

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from matplotlib.ticker import LogLocator, NullFormatter

from breaker.figures import style

__all__ = ["prognostics"]

# Marker and colour, method by method; the first one is the model.
_METHODS = (
    ("o", style.MODEL),
    ("s", style.AMORTISED),
    ("^", "#4E9A9A"),
    ("D", "#A0569B"),
    ("v", "#8A8A8A"),
    ("P", "#B5A300"),
    ("X", "#5B7FB8"),
)
_IDEAL = (("s", style.AMORTISED), ("^", style.REFERENCE))  # marker and colour of the observers
_FOUND = 3.0  # percent of life within which a change counts as found,
_SHARE = 90.0  # percent of the lives in which it is to be,
_CLEAR = 5.0  # from this ratio on
_COVERAGE = (85.0, 95.0)  # percent, where the coverage of 90 % intervals is to be
_NOMINAL = 90.0
_MISSED = (130.0, 400.0)  # strip of the missed ones on the axis of the delay
_TARGET = {"color": "#009E73", "alpha": 0.15, "lw": 0}


@style.styled
def prognostics(scores: xr.Dataset) -> Figure:
    """Draw how early changes are found, and how good intervals of the remaining life are.

    Args:
        scores: ``ratio (life)``: slope change over its standard error; ``delay (life, method)``:
            share of life from change to alarm, nan where missed; ``found (bin, method)``: share of
            lives found within 3 % of life, with ``bin_lower`` and ``bin_upper`` ``(bin)`` of the
            ratio; ``coverage (fraction)`` of 90 % intervals and ``coverage_interval (fraction,
            bound)``, their median ``width (fraction)`` over the truth, ``ideal_coverage`` and
            ``ideal_width (observer, fraction)`` of ideal observers, ``alpha_lambda (fraction)``
            accuracy; coordinates ``method``, the model first, ``observer``, two of them, and
            ``fraction`` of the life after the change.

    Raises:
        ValueError: If there are more methods than markers.
    """
    methods = [str(name) for name in scores["method"].values]
    if len(methods) > len(_METHODS):
        raise ValueError(f"there are markers for {len(_METHODS)} methods, not {len(methods)}")
    figure = style.new_figure(13.6, 10.2)
    grid = figure.add_gridspec(4, 2, width_ratios=(1.25, 1.0))
    _delays(figure.add_subplot(grid[:2, 0]), scores)
    _found(figure.add_subplot(grid[:2, 1]), scores)
    _coverage(figure.add_subplot(grid[2:, 0]), scores)
    accuracy, width = (figure.add_subplot(grid[i, 1]) for i in (2, 3))
    _over_life(accuracy, scores, 100 * scores["alpha_lambda"], "α-λ accuracy (%)")
    accuracy.set(ylim=(0.0, 104.0), xlabel="")
    accuracy.set_title("(d) remaining life: accuracy and width", loc="left")
    accuracy.tick_params(labelbottom=False)
    _over_life(width, scores, scores["width"], "interval / truth, median")
    _observers(width, scores["fraction"], scores["ideal_width"])
    width.set_ylim(bottom=0.0)
    lives = scores.sizes["life"]
    words = "Prognostics: changes and remaining life against the truth"
    figure.suptitle(f"{words}\n{lives} simulated lives")
    observers = [str(name) for name in scores["observer"].values]
    style.legend_below(figure, _handles(methods, observers), columns=4)
    return figure


def _delays(axis: Axes, scores: xr.Dataset) -> None:
    """Draw the delay of each life over its ratio; missed ones in a strip, a line each method."""
    ratio = scores["ratio"].values
    strip = np.geomspace(*_MISSED, scores.sizes["method"] + 2)[1:-1][::-1]
    for i, (marker, mark) in enumerate(_METHODS[: scores.sizes["method"]]):
        delay = 100 * scores["delay"].isel(method=i).values
        shown = np.where(np.isnan(delay), strip[i], delay)
        over = 2.3 if i == 0 else 2.0
        axis.plot(ratio, shown, marker, color=mark, ms=4, mew=0, alpha=0.5, zorder=over)
        # The median in each bin; a missed change is later than all.
        late = np.where(np.isnan(delay), np.inf, delay)
        at, medians = [], []
        for low, high in zip(scores["bin_lower"].values, scores["bin_upper"].values, strict=True):
            inside = (ratio >= low) & (ratio < high)
            if inside.any():
                at.append(np.exp(np.log(ratio[inside]).mean()))
                medians.append(np.quantile(late[inside], 0.5, method="higher"))
        shown = np.where(np.isinf(medians), strip[i], medians)
        axis.plot(at, shown, marker, color=mark, ls="-", lw=1.6, ms=9, mec="white", zorder=3)
    axis.axhspan(*_MISSED, color=style.PRIOR, alpha=0.2, lw=0, zorder=0.5)
    axis.axhline(_FOUND, color=style.REFERENCE, lw=0.9, ls="--")
    axis.set_xscale("log")
    axis.set_yscale("symlog", linthresh=1.0, linscale=0.6)
    middle = np.sqrt(_MISSED[0] * _MISSED[1])
    axis.set_yticks([0, 1, 3, 10, 30, 100, middle], ["0", "1", "3", "10", "30", "100", "missed"])
    axis.set_ylim(-0.15, _MISSED[1])
    axis.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axis.xaxis.set_major_formatter("{x:g}")
    axis.xaxis.set_minor_formatter(NullFormatter())
    axis.set(xlabel="slope change / its standard error", ylabel="delay (% of life)")
    axis.set_title("(a) how long until a change is found", loc="left")


def _found(axis: Axes, scores: xr.Dataset) -> None:
    count, methods = scores.sizes["bin"], scores.sizes["method"]
    place = np.arange(count)
    lower, upper = scores["bin_lower"].values, scores["bin_upper"].values
    shifts = 0.13 * (np.arange(methods) - (methods - 1) / 2)
    for i, (marker, mark) in enumerate(_METHODS[:methods]):
        share = 100 * scores["found"].isel(method=i).values
        axis.vlines(place + shifts[i], 0.0, share, color=mark, lw=1.6, alpha=0.5)
        axis.plot(place + shifts[i], share, marker, color=mark, ms=8, mec="white", clip_on=False)
    for i in np.flatnonzero(lower >= _CLEAR):
        axis.axhspan(_SHARE, 100.0, xmin=i / count, xmax=(i + 1) / count, **_TARGET, zorder=0.5)
    labels = [_bin(*ends) for ends in zip(lower, upper, strict=True)]
    axis.set_xticks(place, labels)
    axis.set(xlim=(-0.5, count - 0.5), ylim=(-4.0, 103.0), ylabel="lives (%)")
    axis.set_xlabel("slope change / its standard error")
    axis.grid(axis="x", visible=False)
    axis.set_title(f"(b) found within {_FOUND:g} % of life", loc="left")


def _bin(lower: float, upper: float) -> str:
    if not np.isfinite(upper):
        return f"from {lower:g}"
    return f"below {upper:g}" if lower <= 0 else f"{lower:g} to {upper:g}"


def _coverage(axis: Axes, scores: xr.Dataset) -> None:
    at, covered = 100 * scores["fraction"].values, 100 * scores["coverage"].values
    low, high = (100 * scores["coverage_interval"].sel(bound=b).values for b in ("lower", "upper"))
    axis.axhspan(*_COVERAGE, **_TARGET)
    axis.axhline(_NOMINAL, color=style.REFERENCE, lw=0.9, ls="--")
    axis.vlines(at, low, high, color=style.CORRECTED, lw=2, alpha=0.6)
    axis.plot(at, covered, "o-", color=style.CORRECTED, ms=8, mec="white")
    _observers(axis, scores["fraction"], 100 * scores["ideal_coverage"])
    lowest = min(np.nanmin(low, initial=75.0), 100 * float(scores["ideal_coverage"].min()))
    axis.set(xlim=(0, 100), ylim=(lowest - 3.0, 101.0), ylabel="truth inside (%)")
    axis.set_xlabel("way from change to failure (%)")
    axis.set_title("(c) remaining life: coverage of the 90 % interval", loc="left")


def _over_life(axis: Axes, scores: xr.Dataset, values: xr.DataArray, words: str) -> None:
    axis.plot(100 * scores["fraction"], values, "o-", color=style.CORRECTED, ms=8, mec="white")
    axis.set(xlim=(0, 100), xlabel="way from change to failure (%)", ylabel=words)


def _observers(axis: Axes, fraction: xr.DataArray, values: xr.DataArray) -> None:
    """Draw what ideal observers reach, ``(observer, fraction)``, beside the model."""
    for (marker, mark), each in zip(_IDEAL, values.values, strict=True):
        axis.plot(100 * fraction, each, marker, color=mark, mfc="none", ms=7, ls=":", lw=1.0)


def _handles(methods: list[str], observers: list[str]) -> list:
    look = {"lw": 1.6, "ms": 8, "mec": "white"}
    handles = [
        style.line_key(name, mark, marker=marker, **look)
        for name, (marker, mark) in zip(methods, _METHODS, strict=False)
    ]
    handles += [
        Patch(**_TARGET, label="target"),
        style.line_key(f"{_FOUND:g} % of life; nominal coverage", ls="--", lw=0.9),
        style.line_key("remaining life", style.CORRECTED, marker="o", ms=8, mec="white"),
    ]
    look = {"ls": ":", "ms": 7, "mfc": "none", "lw": 1.0}
    for name, (marker, mark) in zip(observers, _IDEAL, strict=True):
        handles.append(style.line_key(f"of {name}", mark, marker=marker, **look))
    return handles
