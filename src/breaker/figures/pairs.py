"""Prior, posterior and truth of one simulated case, pair by pair (paper, Fig. 7)."""

from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from breaker.figures import panels as p
from breaker.figures import style


@style.styled
def pairs(
    case: xr.Dataset,
    prior: np.ndarray,
    *,
    about: str,
    correlation: np.ndarray,
    regions: Mapping[tuple[int, int], tuple[np.ndarray, ...]],
) -> Figure:
    """Draw regions pair by pair below the diagonal, marginals on it, correlations above it.

    ``case`` has ``draws (draw, output)`` and ``truth``; ``prior`` is ``(m, q)``, physical units.
    """
    posterior, truth, names = (case[name].values for name in ("draws", "truth", "output"))
    q = len(names)
    figure = style.new_figure(1.6 * q + 0.6, 1.5 * q + 1.0)
    grid = figure.subplots(q, q, sharex="col", squeeze=False)
    for place, axis in np.ndenumerate(grid):
        _panel(axis, *place, case, prior, correlation[place])
        if place[::-1] in regions:
            axis.contour(*regions[place[::-1]], colors=style.MODEL, linewidths=(0.9, 1.5))
    _frame(grid, np.concatenate([prior, posterior, truth[None]]), names)
    low, high = np.quantile(posterior, [0.025, 0.975], axis=0)
    inside = int(((truth >= low) & (truth <= high)).sum())
    if q > 1:
        upper = np.abs(np.triu(correlation, 1))
        i, j = np.unravel_index(np.argmax(upper), upper.shape)
        value = p.signed(f"{correlation[i, j]:+.2f}")
        about += f"\nmost correlated: {p.word(names[i])} and {p.word(names[j])} ({value})"
    about += "\nbelow the diagonal regions of 90 % and 50 % of the posterior, above it correlations"
    style.title(figure, f"95 % intervals contain {inside} of {q} true values of one record", about)
    p.legend_below(figure)
    return figure


def _panel(
    axis: Axes, row: int, column: int, case: xr.Dataset, prior: np.ndarray, correlation: float
) -> None:
    """Draw a marginal or a pair; above the diagonal print a correlation, darker if stronger."""
    posterior, truth = case["draws"].values, case["truth"].values
    if row < column:
        look = {"alpha": 0.3 + 0.7 * min(1.0, abs(correlation)), "fontsize": 13}
        place = {"transform": axis.transAxes, "ha": "center", "va": "center"}
        axis.text(0.5, 0.5, p.signed(f"{correlation:+.2f}"), color=style.MODEL, **place, **look)
        axis.set_axis_off()
        return
    axis.axvline(truth[column], color=style.MEASURED, lw=0.9, ls="--", label="truth")
    if row == column:
        output = p.OUTPUTS[case["output"].values[row]]
        look = {"density": True, "color": style.PRIOR, "alpha": 0.5, "label": "prior"}
        axis.hist(prior[:, row], bins=30, **look)
        look |= {
            "color": output.colour,
            "alpha": 0.75,
            "label": "posterior",
        }
        axis.hist(posterior[:, row], bins=20, **look)
        axis.set_title(p.named(output.name).replace(" $", "\n$"), fontsize=11)
        return
    dots = {"mew": 0, "ms": 1.4, "rasterized": True}
    axis.plot(*prior[:, [column, row]].T, "o", color=style.PRIOR, alpha=0.35, **dots)
    axis.plot(*posterior[:, [column, row]].T, "o", color=style.MODEL, alpha=0.22, **dots)
    axis.axhline(truth[row], color=style.MEASURED, lw=0.9, ls="--")


def _frame(grid: np.ndarray, drawn: np.ndarray, names: Sequence[str]) -> None:
    """Set one range per output, of all that is drawn; label only lowest row and first column."""
    low, high = drawn.min(axis=0), drawn.max(axis=0)
    room = 0.03 * (high - low)
    last = len(names) - 1
    for (row, column), axis in np.ndenumerate(grid):
        axis.locator_params(nbins=3)
        axis.tick_params(labelbottom=row == last, labelleft=0 == column < row, labelsize=8)
        if row == column:
            axis.set_xlim(low[row] - room[row], high[row] + room[row])
            axis.set_yticks([])
        elif row > column:
            axis.set_ylim(low[row] - room[row], high[row] + room[row])
        if row == last:
            axis.set_xlabel(p.OUTPUTS[names[column]].label)
        if column == 0 < row:
            axis.set_ylabel(p.OUTPUTS[names[row]].label)
    grid[0, 0].figure.align_labels()
