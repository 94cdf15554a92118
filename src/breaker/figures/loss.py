"""How a training went, and how many solver steps its posterior needs."""

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import LogLocator

from breaker.figures.style import MODEL, PRIOR, WARNING, heading, new_figure, styled

__all__ = ["loss"]


@styled
def loss(history: xr.Dataset, convergence: xr.Dataset | None = None, *, motion: str) -> Figure:
    """Draw training and validation loss, learning rate, and the convergence in solver steps.

    Args:
        history: ``training_loss (step)``, ``learning_rate (step)``, coordinate ``step``, and
            ``validation_loss (evaluation)`` of the EMA weights at ``evaluation_step (evaluation)``;
            attributes ``best_step``, ``held_out_log_density`` and ``held_out_log_density_se`` in
            nats per curve.
        convergence: ``mean_difference (solver_steps)`` and ``max_difference (solver_steps)`` from
            the finest solution, in posterior sd; attributes ``chosen_steps`` and
            ``reference_steps``, those of the finest. None for a network without a solver.
        motion: Motion of the title.
    """
    figure = new_figure(11.5 if convergence is not None else 7.5, 5.4)
    columns = (
        [["loss", "steps"], ["rate", "steps"]] if convergence is not None else [["loss"], ["rate"]]
    )
    ratios = (1.6, 1.0) if convergence is not None else None
    axes = figure.subplot_mosaic(columns, height_ratios=(3.2, 1.0), width_ratios=ratios)
    _losses(axes["loss"], history)
    _rate(axes["rate"], history)
    axes["rate"].sharex(axes["loss"])
    axes["loss"].tick_params(labelbottom=False)
    if convergence is not None:
        _convergence(axes["steps"], convergence)
    density, error = (history.attrs[f"held_out_log_density{end}"] for end in ("", "_se"))
    verdict = f"held-out log density {density:.3f} ± {error:.3f} nats per curve"
    heading(figure, motion, "training", verdict)
    return figure


def _losses(axis: Axes, history: xr.Dataset) -> None:
    validation, at = history["validation_loss"].values, history["evaluation_step"].values
    axis.plot(
        history["step"],
        history["training_loss"],
        color=PRIOR,
        lw=0.6,
        alpha=0.8,
        label="training, one batch",
    )
    axis.plot(at, validation, "o-", color=MODEL, ms=3, label="validation, EMA weights")
    best = int(history.attrs["best_step"])
    value = validation[at == best]
    if not value.size:
        raise ValueError(f"best_step {best} is not among the evaluation steps")
    label = f"best, kept: step {best}, loss {value[0]:.4g}"
    axis.plot([best], value[:1], "*", color=WARNING, ms=13, label=label)
    if np.nanmin(history["training_loss"]) > 0 and np.nanmin(validation) > 0:
        axis.set_yscale("log")
        axis.yaxis.set_major_locator(LogLocator(subs=(1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 7.0)))
        axis.yaxis.set_major_formatter("{x:g}")  # 0.3 reads better than 3 x 10^-1
        axis.minorticks_off()
    axis.set(title="loss", ylabel="loss")
    axis.legend(loc="upper right")


def _rate(axis: Axes, history: xr.Dataset) -> None:
    axis.plot(history["step"], history["learning_rate"], color=MODEL)
    axis.set(xlabel="training step", ylabel="learning rate", ylim=(0, None))
    axis.ticklabel_format(axis="y", scilimits=(-2, 2))


def _convergence(axis: Axes, convergence: xr.Dataset) -> None:
    steps = convergence["solver_steps"].values
    chosen = int(convergence.attrs["chosen_steps"])
    for name, marker, label in (("max", "s--", "largest"), ("mean", "o-", "mean")):
        values = convergence[f"{name}_difference"].values
        axis.plot(steps, values, marker, color=MODEL, ms=5, label=label)
    axis.axvline(chosen, color=WARNING, lw=1.2, ls=":")
    axis.set_xscale("log", base=2)
    axis.set_yscale("log")
    axis.set_xticks(steps, [str(step) for step in steps])
    axis.minorticks_off()
    axis.set(
        title="convergence of the draws",
        xlabel="solver steps",
        ylabel=f"difference from {convergence.attrs['reference_steps']} steps (posterior sd)",
    )
    mark = Line2D([], [], color=WARNING, lw=1.2, ls=":", label=f"chosen: {chosen} steps")
    axis.legend(handles=[*axis.get_lines()[:2], mark], loc="best")
