"""Prior, posterior and truth of one simulated case, pair by pair (paper, Fig. 7)."""

from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from breaker.figures import style
from breaker.paper.validation import REGIONS, pairs_words

_CONTOURS = {"colors": style.MODEL, "linewidths": (0.9, 1.5)}  # of the widest region first


@style.styled
def pairs(
    case: xr.Dataset,
    prior: np.ndarray,
    *,
    motion: str,
    correlation: np.ndarray,
    regions: Mapping[tuple[int, int], tuple[np.ndarray, ...]],
    of: str = style.MODELLED,
) -> Figure:
    """Draw regions pair by pair below the diagonal, marginals on it, correlations above it.

    Args:
        case: Draws of the posterior, ``draws (draw, output)``, and the values that made the curve,
            ``truth (output)``, physical units.
        prior: Draws of the prior, ``(m, q)``, of the same outputs.
        correlation: Correlation of the posterior draws, ``(q, q)``, from
            ``diagnostics.correlation``.
        regions: Where these draws are densest, from ``diagnostics.regions``.
        of: Which drives the record is of.
    """
    posterior, truth, names = (case[name].values for name in ("draws", "truth", "output"))
    q = len(names)
    figure = style.new_figure(1.6 * q + 0.6, 1.5 * q + 1.0)
    grid = figure.subplots(q, q, sharex="col", squeeze=False)
    for row in range(q):
        for column in range(q):
            axis = grid[row, column]
            if row == column:
                _marginal(axis, prior[:, row], posterior[:, row], truth[row], names[row])
            elif row > column:
                chosen = [column, row]
                _scatter(axis, prior[:, chosen], posterior[:, chosen], truth[chosen])
                if (column, row) in regions:
                    axis.contour(*regions[column, row], **_CONTOURS)
            else:
                _coefficient(axis, correlation[row, column])
    _frame(grid, np.concatenate([prior, posterior, truth[None]]), names)
    outcome = pairs_words(posterior, truth, correlation, style.symbols(names))
    text = "prior, posterior and truth of one simulated curve"
    style.heading(figure, motion, text, outcome, of=of)
    style.legend_below(figure, _handles(), columns=5 if q > 6 else 2)
    return figure


def _marginal(
    axis: Axes, prior: np.ndarray, posterior: np.ndarray, truth: float, name: str
) -> None:
    axis.hist(prior, bins=30, density=True, color=style.PRIOR, alpha=0.5)
    axis.hist(posterior, bins=20, density=True, color=style.OUTPUTS[name].colour, alpha=0.75)
    axis.axvline(truth, color=style.MEASURED, lw=1.2, ls="--")
    axis.set_title(style.OUTPUTS[name].symbol, fontsize=14)


def _scatter(axis: Axes, prior: np.ndarray, posterior: np.ndarray, truth: np.ndarray) -> None:
    axis.plot(*prior.T, "o", color=style.PRIOR, ms=1.4, mew=0, alpha=0.35, rasterized=True)
    axis.plot(*posterior.T, "o", color=style.MODEL, ms=1.4, mew=0, alpha=0.22, rasterized=True)
    axis.axvline(truth[0], color=style.MEASURED, lw=0.7, ls="--")
    axis.axhline(truth[1], color=style.MEASURED, lw=0.7, ls="--")


def _coefficient(axis: Axes, value: float) -> None:
    """Print a correlation, the darker the stronger."""
    axis.set_axis_off()
    weight = "bold" if abs(value) > 0.7 else "normal"
    look = {"color": style.MODEL, "alpha": 0.3 + 0.7 * min(1.0, abs(value)), "fontsize": 13}
    place = {"transform": axis.transAxes, "ha": "center", "va": "center"}
    axis.text(0.5, 0.5, f"{value:+.2f}".replace("-", "−"), weight=weight, **place, **look)


def _frame(grid: np.ndarray, drawn: np.ndarray, names: Sequence[str]) -> None:
    """Give each output one range, that of all drawn; label the lowest row and first column only."""
    low, high = drawn.min(axis=0), drawn.max(axis=0)
    room = 0.03 * (high - low)
    last = len(names) - 1
    for i, name in enumerate(names):
        grid[i, i].set_xlim(low[i] - room[i], high[i] + room[i])
        for axis in grid[i, :i]:
            axis.set_ylim(low[i] - room[i], high[i] + room[i])
        grid[last, i].set_xlabel(style.OUTPUTS[name].label)
        if i:
            grid[i, 0].set_ylabel(style.OUTPUTS[name].label)
    for (row, column), axis in np.ndenumerate(grid):
        axis.locator_params(nbins=3)
        axis.tick_params(labelbottom=row == last, labelleft=0 == column < row, labelsize=8)
        if row == column:
            axis.set_yticks([])
    grid[0, 0].figure.align_xlabels(grid[last])
    grid[0, 0].figure.align_ylabels(grid[:, 0])


def _handles() -> list:
    marginals = "posterior (marginals: colour of the parameter)"
    shares = " and ".join(f"{100 * share:.0f} %" for share in REGIONS)
    return [
        style.band_key("prior", style.PRIOR, 0.7),
        style.band_key(marginals, style.MODEL, 0.8),
        style.line_key(f"regions of {shares} of the posterior", style.MODEL, lw=1.2),
        style.line_key("truth", style.MEASURED, "--"),
        style.dot_key("posterior correlation", style.MODEL, "$+.5$", ms=18),
    ]
