"""How a training went, and how many solver steps its posterior needs."""

import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from breaker.figures import style

__all__ = ["loss"]


@style.styled
def loss(history: xr.Dataset, convergence: xr.Dataset | None = None, *, motion: str) -> Figure:
    """Draw training loss, validation, learning rate, and the convergence in solver steps.

    A flow with a solver is trained on a loss with a scale of its own, any other on its negative log
    density, which has the scale of the validation.

    Args:
        history: ``training_loss (step)``, ``learning_rate (step)``, coordinate ``step``, and
            ``validation_loss (evaluation)``, the negative log density of the EMA weights in nats
            per curve, at ``evaluation_step (evaluation)``; attributes ``best_step``,
            ``held_out_log_density`` and ``held_out_log_density_se`` in nats per curve.
        convergence: ``mean_difference (solver_steps)`` and ``max_difference (solver_steps)`` from
            the finest solution, in posterior sd, ``density_difference (solver_steps)`` in nats;
            attributes ``chosen_steps``, ``chosen_density_steps`` and ``reference_steps``, those of
            the finest. None for a network without a solver.
    """
    rows = ["loss", "validation", "rate"]
    figure = style.new_figure(11.5 if convergence is not None else 7.5, 7.0)
    columns = [[row, "steps"] if convergence is not None else [row] for row in rows]
    ratios = (1.6, 1.0) if convergence is not None else None
    axes = figure.subplot_mosaic(columns, height_ratios=(2.0, 2.0, 1.0), width_ratios=ratios)
    _training(axes["loss"], history, solves=convergence is not None)
    _validation(axes["validation"], history)
    _rate(axes["rate"], history)
    for row in rows[:2]:
        axes[row].sharex(axes["rate"])
        axes[row].tick_params(labelbottom=False)
    if convergence is not None:
        _convergence(axes["steps"], convergence)
    density, error = (history.attrs[f"held_out_log_density{end}"] for end in ("", "_se"))
    outcome = f"held-out log density {density:.3f} ± {error:.3f} nats per curve"
    style.heading(figure, motion, "training", outcome)
    return figure


def _training(axis: Axes, history: xr.Dataset, *, solves: bool) -> None:
    values = history["training_loss"].values
    label = "one batch, weights of the moment"
    axis.plot(history["step"], values, color=style.PRIOR, lw=0.6, label=label)
    # The first steps, from far away, would dwarf all that follows.
    start = min(values.size - 1, values.size // 20)
    low, high = values[start:].min(), values[start:].max()
    room = 0.05 * (high - low)
    unit = "loss, a scale of its own" if solves else "nats per curve"
    title = "training loss" + ("" if solves else ": negative log density")
    axis.set(title=title, ylabel=unit, ylim=(low - room, high + room))
    axis.legend(loc="upper right")


def _validation(axis: Axes, history: xr.Dataset) -> None:
    values, at = history["validation_loss"].values, history["evaluation_step"].values
    axis.plot(at, values, "o-", color=style.MODEL, ms=3, label="validation curves, EMA weights")
    best = int(history.attrs["best_step"])
    value = values[at == best]
    if not value.size:
        raise ValueError(f"best_step {best} is not among the evaluation steps")
    label = f"best, kept: step {best}, {value[0]:.3f}"
    axis.plot([best], value[:1], "*", color=style.WARNING, ms=13, label=label)
    density, error = (history.attrs[f"held_out_log_density{end}"] for end in ("", "_se"))
    axis.axhspan(-density - error, -density + error, color=style.PRIOR, alpha=0.4, lw=0)
    label = "held-out curves, ± 1 s.e."
    axis.axhline(-density, color=style.REFERENCE, lw=1.0, ls="--", label=label)
    axis.set(title="validation: negative log density", ylabel="nats per curve")
    axis.legend(loc="upper right")


def _rate(axis: Axes, history: xr.Dataset) -> None:
    axis.plot(history["step"], history["learning_rate"], color=style.MODEL)
    axis.set(xlabel="training step", ylabel="learning rate", ylim=(0, None))
    axis.ticklabel_format(axis="y", scilimits=(-2, 2))


def _convergence(axis: Axes, convergence: xr.Dataset) -> None:
    steps = convergence["solver_steps"].values
    for name, marker, colour, label in (
        ("max", "s--", style.MODEL, "draws, largest (posterior sd)"),
        ("mean", "o-", style.MODEL, "draws, mean (posterior sd)"),
        ("density", "^-", style.PRIOR, "log density, mean (nats)"),
    ):
        values = convergence[f"{name}_difference"].values
        axis.plot(steps, values, marker, color=colour, ms=5, label=label)
    marks = []
    for key, dashes, words in (("steps", ":", "draws"), ("density_steps", "--", "density")):
        chosen = int(convergence.attrs[f"chosen_{key}"])
        axis.axvline(chosen, color=style.WARNING, lw=1.2, ls=dashes)
        label = f"chosen for the {words}: {chosen}"
        marks.append(style.line_key(label, style.WARNING, dashes, lw=1.2))
    axis.set_xscale("log", base=2)
    axis.set_yscale("log")
    axis.set_xticks(steps, [str(step) for step in steps])
    axis.minorticks_off()
    axis.set(
        title="convergence of the solver",
        xlabel="solver steps",
        ylabel=f"difference from {convergence.attrs['reference_steps']} steps",
    )
    axis.legend(handles=[*axis.get_lines()[:3], *marks], loc="best", fontsize=8)
