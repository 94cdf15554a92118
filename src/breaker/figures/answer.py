"""What one call infers of a drive: records beside the family's nearest shapes, and parameters."""

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from breaker.drive.answers.picture_data import PictureCurve, Shown
from breaker.figures import style
from breaker.model.parameters import PARAMETERS
from breaker.model.quantities import EVENTS

_COLOURS = {"closing": style.CORRECTED, "opening": style.AMORTISED}
_BOTH = style.MODEL
_CORNER = {"closing": (0.97, 0.08, "bottom"), "opening": (0.97, 0.95, "top")}  # without a curve
_POINTS = 200  # of a density
_PRIOR = 1.0  # times the width of the posterior, to which the prior is shown on either side
_COLUMNS = 4
_LABELS = 0.9  # inches, left of a panel
_BAND = {"color": style.PRIOR, "alpha": 0.35, "lw": 0}


@style.styled
def answer(data: Shown) -> Figure:
    """Draw answers.

    Above the first record of each motion with the nearest shape of the family, and the inferred
    time of the touch or the parting; below it what that shape leaves of the record, beside what it
    leaves of the family's drives; at the foot the parameters of all operations beside the prior.
    """
    figure = style.new_figure(12.0, 11.0)
    above, below = figure.subfigures(2, 1, height_ratios=[1.35, 1.0])
    size = {"height_ratios": [2, 1], "sharex": "col", "squeeze": False}
    grid = above.subplots(2, len(data.curves), **size)
    for (motion, curve), (record, left) in zip(data.curves.items(), grid.T, strict=True):
        _record(record, curve, motion, figure.get_figwidth() / len(data.curves) - _LABELS)
        _left(left, curve)
    axes = below.subplots(-(-(len(PARAMETERS) + 1) // _COLUMNS), _COLUMNS).flat
    for k, (axis, each) in enumerate(zip(axes, PARAMETERS, strict=False)):
        told = data.posteriors.items()
        posteriors = {of: [d[:, k] for d in some if np.isfinite(d[0, k])] for of, some in told}
        _densities(axis, posteriors, data.prior[:, k])
        axis.set_title(style.literal(each.meaning), loc="left", fontsize=9)
        axis.set_xlabel(each.label)
    _densities(axes[len(PARAMETERS)], data.switching, None)
    events = ", ".join(EVENTS[motion] for motion in data.curves)
    axes[len(PARAMETERS)].set_title(f"{events} of the contact", loc="left", fontsize=9)
    axes[len(PARAMETERS)].set_xlabel("time after the release (ms)")
    style.title(figure, style.literal(data.title))
    style.legend_below(figure, _keys(data), columns=3)
    return figure


def _record(axis: Axes, data: PictureCurve, motion: str, width: float) -> None:
    """A record, the nearest shape, and when the contact switches; the panel is so many inches."""
    colour = _COLOURS[motion]
    if data.switching.size:
        low, middle, high = np.quantile(data.switching, [0.025, 0.5, 0.975])
        axis.axvspan(low, high, color=colour, alpha=0.25, lw=0)
        axis.axvline(middle, color=colour, lw=1.2)
        x, y, side = _CORNER[motion]
        said = f"{EVENTS[motion]} at {middle:.1f} ms\n95 %: {low:.1f} to {high:.1f} ms"
        look = {"color": colour, "ha": "right", "va": side, "transform": axis.transAxes}
        axis.text(x, y, said, **look)
    axis.plot(data.time, data.travel, "o", color=style.MEASURED, ms=2, mew=0)
    axis.plot(data.grid, data.nearest, color=style.WARNING, lw=1.0)
    axis.set_ylabel(style.TRAVEL)
    axis.margins(x=0)
    look = {"color": "black" if data.good else style.WARNING, "loc": "left"}
    title = f"{motion} in {style.file_name(data.file)}: {data.words}"
    axis.set_title(style.within(title, width), **look)


def _left(axis: Axes, data: PictureCurve) -> None:
    """What the nearest shape leaves of a record, and of the family's drives."""
    axis.fill_between(data.grid, -data.usual, data.usual, step="mid", **_BAND)
    axis.plot(data.grid, data.left, "o", color=style.MEASURED, ms=2, mew=0)
    axis.axhline(0.0, color=style.REFERENCE, lw=0.6)
    axis.set(xlabel="time after the first motion (ms)", ylabel="record minus\nshape (mm)")


def _densities(
    axis: Axes, posteriors: Mapping[str, Sequence[np.ndarray]], prior: np.ndarray | None
) -> None:
    """Densities of a parameter or time: of operations, and of the prior."""
    axis.set(yticks=[])
    every = [draws for some in posteriors.values() for draws in some]
    every = every or [each for each in [prior] if each is not None]
    if not every:
        axis.text(0.5, 0.5, "not inferred", ha="center", transform=axis.transAxes)
        return
    low, high = np.quantile(np.concatenate(every), [0.001, 0.999])
    left, right = low, high
    if prior is not None:
        ends = np.quantile(prior, [0.005, 0.995])
        left = max(min(ends[0], low), low - _PRIOR * (high - low))
        right = min(max(ends[1], high), high + _PRIOR * (high - low))
    at = np.linspace(left, right, _POINTS)
    if prior is not None:
        axis.fill_between(at, _density(prior, at), **_BAND)
    for of, some in posteriors.items():
        for i, draws in enumerate(some):
            look = {"lw": 1.8} if i == 0 else {"lw": 0.6, "alpha": 0.6}
            axis.plot(at, _density(draws, at), color=_COLOURS.get(of, _BOTH), **look)
    axis.set(xlim=(left, right), ylim=(0.0, None))


def _density(draws: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Return a density at points from draws, by Gaussian kernels of Scott's width.

    As ``scipy.stats.gaussian_kde``, which takes a third of a command to load.
    """
    width = draws.std(ddof=1) * draws.size**-0.2
    kernels = np.exp(-0.5 * np.square((at[:, None] - draws) / width))
    return kernels.mean(axis=1) / (width * np.sqrt(2.0 * np.pi))


def _keys(data: Shown) -> list:
    rest = {
        of: "s, the first thick" if len(some) > 1 else "" for of, some in data.posteriors.items()
    }
    return [
        style.dot_key("record", style.MEASURED, ms=4),
        style.line_key("nearest shape of the family", style.WARNING),
        style.band_key("99 % of the family's drives, rms; the prior", style.PRIOR, 0.35),
        *(
            style.line_key(f"posterior of {of}{rest[of]}", _COLOURS.get(of, _BOTH), lw=1.8)
            for of in data.posteriors
        ),
    ]
