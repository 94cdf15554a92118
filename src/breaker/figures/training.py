"""Course of a training, and the solver steps that its posterior needs (paper, Sec. 4)."""

from collections.abc import Mapping

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from breaker.figures import panels as p
from breaker.figures import style


@style.styled
def loss(history: xr.Dataset, solver: xr.Dataset, *, motion: str) -> Figure:
    """Draw training loss, validation, learning rate, and the convergence in solver steps.

    The training loss of a flow with a solver has another scale than the validation, and is in a
    separate panel. Other networks train on the negative log density, as in the validation.

    ``history`` has the losses, nats per curve. ``solver`` has the differences from the finest
    solution and the chosen numbers of steps, or only the attribute ``solves`` = 0 without a solver.
    """
    if solver.attrs["solves"]:
        figure = style.new_figure(11.5, 7.0)
        rows = [["loss", "draws"], ["density", "log density"], ["rate", "log density"]]
        axes = figure.subplot_mosaic(rows, height_ratios=(2, 2, 1), width_ratios=(1.6, 1.0))
        _training(axes["loss"], history)
        axes["loss"].set(title="training loss", ylabel="loss, a scale of its own")
        axes["loss"].legend(loc="upper right")
        lines = {"max": ("s--", "largest"), "mean": ("o-", "mean")}
        _convergence(axes["draws"], solver, lines, "chosen_steps", "posterior sd")
        lines = {"density": ("o-", "mean")}
        _convergence(axes["log density"], solver, lines, "chosen_density_steps", "nats")
        axes["draws"].set_title("convergence of the draws")
        axes["log density"].set_title("convergence of the log density")
    else:
        figure = style.new_figure(7.5, 5.6)
        axes = figure.subplot_mosaic([["density"], ["rate"]], height_ratios=(3, 1))
        _training(axes["density"], history)
    _validation(axes["density"], history)
    rate = axes["rate"]
    rate.plot(history["step"], history["learning_rate"], color=style.MODEL)
    rate.set(xlabel="training step", ylabel="learning rate", ylim=(0, None))
    rate.ticklabel_format(axis="y", scilimits=(-2, 2))
    for axis in (axes[name] for name in ("loss", "density") if name in axes):
        axis.sharex(rate)
        axis.tick_params(labelbottom=False)
    density, error = (history.attrs[f"held_out_log_density{end}"] for end in ("", "_se"))
    finding = f"Log density of held-out curves: {density:.3f} ± {error:.3f} nats per curve"
    best, last = history.attrs["best_step"], history["step"].values[-1]
    about = f"{p.SOURCES[motion]}: training. The best weights are those of step {best} of {last}"
    style.title(figure, finding, about)
    return figure


def _training(axis: Axes, history: xr.Dataset) -> None:
    values = history["training_loss"].values
    label = "training, one batch, weights of the moment"
    axis.plot(history["step"], values, color=style.PRIOR, lw=0.6, label=label)
    # The large losses of the first steps are outside the axis.
    shown = values[min(values.size - 1, values.size // 20) :]
    room = 0.05 * np.ptp(shown)
    axis.set_ylim(shown.min() - room, shown.max() + room)


def _validation(axis: Axes, history: xr.Dataset) -> None:
    """Draw the validation, on an axis that keeps at least its present range."""
    low, high = axis.get_ylim() if axis.lines else (np.inf, -np.inf)
    values, steps = history["validation_loss"].values, history["evaluation_step"].values
    axis.plot(steps, values, "o-", color=style.MODEL, ms=3, label="validation curves, EMA weights")
    best = int(history.attrs["best_step"])
    value = values[steps == best][0]
    axis.plot(best, value, "*", color=style.CORRECTED, ms=13, label=f"best, kept: {value:.3f}")
    loss, error = -history.attrs["held_out_log_density"], history.attrs["held_out_log_density_se"]
    axis.axhspan(loss - error, loss + error, color=style.PRIOR, alpha=0.4, lw=0)
    look = {"lw": 1.0, "ls": "--", "label": "held-out curves, ± 1 s.e."}
    axis.axhline(loss, color=style.REFERENCE, **look)
    lowest, highest = min(values.min(), loss - error), max(values.max(), loss + error)
    room = 0.05 * (highest - lowest)
    axis.set_ylim(min(low, lowest - room), max(high, highest + room))
    axis.set(title="negative log density", ylabel="nats per curve")
    axis.legend(loc="upper right")


def _convergence(axis: Axes, solver: xr.Dataset, lines: Mapping, chosen: str, unit: str) -> None:
    """Draw differences from the finest solution over the steps, and the chosen number of steps."""
    steps = solver["solver_steps"].values
    for name, (marker, label) in lines.items():
        values = solver[f"{name}_difference"].values
        axis.plot(steps, values, marker, color=style.MODEL, ms=5, label=label)
    count = int(solver.attrs[chosen])
    axis.axvline(count, color=style.CORRECTED, lw=1.2, ls=":", label=f"chosen: {count}")
    axis.set_xscale("log", base=2)
    axis.set_yscale("log")
    axis.set_xticks(steps, [str(step) for step in steps])
    axis.minorticks_off()
    difference = f"difference from {solver.attrs['reference_steps']} steps\n({unit})"
    axis.set(xlabel="solver steps", ylabel=difference)
    axis.legend(loc="best", fontsize=8)
