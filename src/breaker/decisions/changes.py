"""Changes of a drive in words: of its wear, and steps from one operation to the next."""

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd
import xarray as xr

from breaker.wear import IN_ROW

__all__ = ["changes", "latest_step", "step_table", "with_steps"]

_NAMED = 0.7  # share of the largest change of a step, from which that of a motion is named
_PHASES = {
    "start": "the start of the motion",
    "main motion": "the main motion",
    "end": "the end of the stroke",
}


def with_steps(trend: xr.Dataset) -> xr.Dataset:
    """Add the steps of a whole trend, in words.

    Args:
        trend: What ``Follower.follow`` returns, all operations: ``step`` and ``surprise``
            ``(operation)`` and ``step_size (operation, phase)``.

    Returns:
        ``trend`` with, over ``jump``: ``jump_noticed``, the operation at which a step is noticed,
        ``jump_from``, the first operation that is unlike those before, and ``jump_words``, such as
        "closing: the end of the stroke changed at operation 1,204 (0.4 mm)".
    """
    operations, learnt = trend.operation.values, np.isfinite(trend.surprise.values)
    found = np.flatnonzero(trend.step.values.astype(bool))
    # So many operations in a row make a step: it lies before the first of them.
    first = [np.append(np.flatnonzero(learnt[:i]), i)[-IN_ROW:][0] for i in found.tolist()]
    begins = operations[np.array(first, dtype=int)]
    sizes, phases = trend.step_size.values[found], trend.phase.values
    words = [_words(phases, *each) for each in zip(sizes, begins.tolist(), strict=True)]
    return trend.assign(
        jump_noticed=("jump", operations[found]),
        jump_from=("jump", begins),
        jump_words=("jump", np.array(words, dtype=str)),
    )


def _words(phases: Sequence[str], sizes: np.ndarray, operation: int) -> str:
    """Name the phase that changed most of each motion that did, with its root mean square, mm."""
    told = []
    for motion in dict.fromkeys(str(phase).split(" ")[0] for phase in phases):
        own = {str(p): x for p, x in zip(phases, sizes, strict=True) if str(p).startswith(motion)}
        most = max(own, key=own.get)
        if own[most] >= _NAMED * sizes.max():
            name = _PHASES[most.removeprefix(f"{motion} ")]
            told.append(f"{motion}: {name} changed at operation {operation:,} ({own[most]:.2g} mm)")
    return ", ".join(told)


def changes(trends: Mapping[str, xr.Dataset], operations: np.ndarray) -> list[str]:
    """What changed, noted at the operation at which it was noticed, ``(o,)``.

    Args:
        trends: Whole trends by source, those that limits are read from.
        operations: Numbers of the operations.
    """
    noted = {int(operation): [] for operation in operations}
    for source, trend in trends.items():
        for k in range(trend.sizes["change"]):
            one = trend.isel(change=k)
            noted[int(one.change_alarm)].append(f"{source}: {_change_words(one)}")
        for k in range(trend.sizes["jump"]):
            one = trend.isel(jump=k)
            noted[int(one.jump_noticed)].append(one.jump_words.item())
        for number, words in zip(trend.operation.values, trend.event.values, strict=True):
            if words and words not in noted[int(number)]:  # of trends apart the same
                noted[int(number)].append(str(words))
    return ["; ".join(words) for words in noted.values()]


def _change_words(one: xr.Dataset) -> str:
    """Describe a change of the wear."""
    if not np.isfinite(one.change_start.item()):
        return "a change that later ones took back"
    low, high = one.change_interval.values
    name = one.kind.values[one.change_kind.values.argmax()]
    return f"change of {name} at about {one.change_start.item():.0f} ({low:.0f} to {high:.0f})"


def latest_step(
    trends: Mapping[str, xr.Dataset], operations: np.ndarray, *, within: int
) -> list[str]:
    """Describe the last step before each operation, ``(o,)``; empty without one.

    Args:
        trends: As of ``changes``.
        operations: Numbers of the operations.
        within: Operations for which a step is told.
    """
    steps = []
    for trend in trends.values():
        every = (trend.isel(jump=k) for k in range(trend.sizes["jump"]))
        steps += [(int(one.jump_noticed), one.jump_words.item()) for one in every]
    told = []
    for operation in operations:
        recent = [each for each in steps if each[0] <= operation <= each[0] + within]
        told.append(max(recent, key=lambda each: each[0])[1] if recent else "")
    return told


def step_table(trends: Mapping[str, xr.Dataset]) -> pd.DataFrame:
    """Return the steps as rows of the table of alarms, without a limit and a probability.

    Args:
        trends: As of ``changes``.
    """
    rows = []
    for source, trend in trends.items():
        for k in range(trend.sizes["jump"]):
            one = trend.isel(jump=k)
            ends = int(one.jump_from), int(one.jump_noticed)
            rows.append(("", one.jump_words.item(), source, *ends, np.nan))
    columns = {"limit": str, "words": str, "motion": str}
    columns |= {"from_operation": "Int64", "to_operation": "Int64", "highest_probability": float}
    return pd.DataFrame(rows, columns=list(columns)).astype(columns)
