"""Changes of a drive in words: of its wear, and steps from one operation to the next."""

from collections.abc import Iterator, Mapping, Sequence
from operator import attrgetter
from typing import NamedTuple

import numpy as np
import pandas as pd
import xarray as xr
from scipy.special import ndtr

from breaker.decisions.alarms import spell_table
from breaker.mechanism import NAMES
from breaker.wear import IN_ROW

__all__ = [
    "changes",
    "named",
    "same_bend",
    "step_table",
    "with_changes",
    "with_steps",
]

_SETTLED = 100  # operations after its alarm at which a change is described
_SURE = 0.95  # probability from which a parameter is named, or a jump of everything,
_MOST = 3  # and parameters that are named where it may be any of them
_HALF = 1.6449  # sds of a normal in half its 90 % interval
_LEAST = 1e-9  # least sd of a slope
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


def with_changes(trend: xr.Dataset) -> xr.Dataset:
    """Add the changes of the wear that a whole trend found, each bend once.

    Args:
        trend: What ``Follower.follow`` returns, all operations.

    Returns:
        ``trend`` with, over ``change``: ``change_alarm``, the operation at which it was first
        noticed; ``change_start`` and ``change_interval (change, bound)``, where it began;
        ``change_kind (change, kind)``; ``change_moved (change, parameter)``, the probability that
        the slope is another one after it, in the likelier direction; and ``change_parameters``, its
        name. All of it as known a hundred operations after the alarm, or before the next or a known
        event.
    """
    alarms, last, start, intervals = _alarms(trend)
    kinds = trend.kind_probability.values[last]
    moved = np.array([_moved(trend, *each) for each in zip(intervals[:, 0], last, strict=True)])
    moved = moved.reshape(-1, trend.sizes["parameter"])
    groups = same_bend(intervals)
    best = [group[-1] for group in groups]  # that has seen most
    moved = np.array([moved[group].max(axis=0) for group in groups]).reshape(-1, moved.shape[1])
    return trend.assign(
        change_alarm=("change", trend.operation.values[[alarms[group[0]] for group in groups]]),
        change_start=("change", start[best]),
        change_interval=(("change", "bound"), intervals[best]),
        change_kind=(("change", "kind"), kinds[best]),
        change_moved=(("change", "parameter"), moved),
        change_parameters=("change", np.array([*map(named, moved, kinds[best])], dtype=str)),
    )


def _alarms(trend: xr.Dataset) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Where changes were noticed, and where they are described, indices ``(n,)``.

    And when they began, as known there: medians ``(n,)`` and 90 % intervals ``(n, 2)``.
    """
    alarms = np.flatnonzero(trend.alarm.values)
    ends = np.flatnonzero(trend.alarm.values | (trend.event.values != ""))
    ends = np.append(ends, trend.sizes["operation"])
    last = ends[np.searchsorted(ends, alarms, side="right")] - 1
    settled = np.searchsorted(trend.operation, trend.operation[alarms] + _SETTLED)
    last = np.minimum(last, settled)
    begun = trend.start_interval.values[last].reshape(-1, 3)
    return alarms, last, begun[:, 1], begun[:, [0, 2]]


def same_bend(intervals: np.ndarray) -> list[list[int]]:
    """Group notices that may be of the same bend, by number, in the order of their first ones.

    They are if the 90 % interval of the one's beginning overlaps that of the last one before.

    >>> same_bend(np.array([[10.0, 40.0], [30.0, 35.0], [90.0, 95.0], [36.0, 50.0]]))
    [[0, 1], [2], [3]]

    Args:
        intervals: Where what was noticed began, operations, ``(n, 2)``; nan, like no other.
    """
    groups = []
    for i, (low, high) in enumerate(intervals):
        for group in groups:
            if _overlap((low, high), intervals[group[-1]]):
                group.append(i)
                break
        else:
            groups.append([i])
    return groups


def _overlap(one: Sequence[float], other: Sequence[float]) -> bool:
    """Say whether two intervals have anything in common."""
    return one[0] <= other[1] and other[0] <= one[1]


def _moved(trend: xr.Dataset, start: float, last: int) -> np.ndarray:
    """Probability that each slope rose, or that it fell, whichever is likelier, ``(p,)``.

    A change of one parameter moves its slope and no other. Where several may have moved, the slope
    at the operation ``last`` (an index) is compared with that of the last operation before
    ``start``, as normals: what is known of a slope before the change says nothing of it after.
    """
    p = trend.sizes["parameter"]
    kinds = trend.kind_probability.values[last]
    before = max(np.searchsorted(trend.operation, start, side="right") - 1, 0)
    slopes = trend.slope.values[[before, last]]
    widths = np.ptp(trend.slope_interval.values[[before, last]], axis=-1)
    scale = np.maximum(np.hypot(*widths) / (2.0 * _HALF), _LEAST)
    return kinds[:p] + kinds[p:].sum() * ndtr(np.abs(slopes[1] - slopes[0]) / scale)


def named(moved: np.ndarray, kinds: np.ndarray) -> str:
    """Name what changed: every parameter whose slope surely moved, else those that may have.

    >>> named(np.array([0.0, 0, 0, 0.96, 0, 1, 0]), np.array([0.0, 0, 0, 0, 0, 0, 0, 1, 0]))
    'gamma_a, f'
    >>> named(np.array([0.0, 0, 0, 0.4, 0, 0.6, 0]), np.array([0.0, 0, 0, 0.4, 0, 0.6, 0, 0, 0]))
    'f or gamma_a'

    Args:
        moved: Probability of each parameter, ``(p,)``.
        kinds: Probability of each kind of change, ``(kind,)``.
    """
    if kinds[-1] >= _SURE:
        return "all levels, as in a repair"
    sure = [name for name, each in zip(NAMES, moved, strict=True) if each >= _SURE]
    order = np.argsort(-kinds[: len(NAMES)], kind="stable")[:_MOST]
    enough = np.cumsum(kinds[order]) >= _SURE  # it is one of the first
    if sure or not enough[-1]:
        unsure = "several parameters" if kinds[-2] >= _SURE else "the wear"
        return ", ".join(sure) or unsure
    return " or ".join(NAMES[k] for k in order[: 1 + np.argmax(enough)])


def changes(
    trends: Mapping[str, xr.Dataset], operations: np.ndarray, measured: xr.Dataset | None = None
) -> list[str]:
    """What changed, noted at the operation at which it was first noticed, ``(o,)``.

    A bend that both motions saw, or measured quantities, too, and a step and a change of the wear
    in the same place, are one.

    Args:
        trends: Whole trends by source, those that limits are read from.
        measured: What ``follow_measured`` returns, if limits are on measured quantities.
    """
    when = attrgetter("noticed")
    notices = sorted([each for name in trends for each in _notices(name, trends[name])], key=when)
    intervals = np.array([each.interval for each in notices]).reshape(-1, 2)
    groups = [[notices[i] for i in group] for group in same_bend(intervals)]
    if measured is not None:
        _join(groups, sorted(_measured_notices(measured), key=when))
    noted = {int(operation): [] for operation in operations}
    for group in groups:
        noted[min(each.noticed for each in group)].append(_told(group))
    for trend in trends.values():
        for number, words in zip(trend.operation.values, trend.event.values, strict=True):
            if words and words not in noted[int(number)]:  # of trends apart the same
                noted[int(number)].append(str(words))
    return ["; ".join(words) for words in noted.values()]


class _Notice(NamedTuple):
    """One change or step that was noticed, and its beginning."""

    noticed: int
    interval: tuple[float, float]
    source: str
    step: str = ""
    start: float = np.nan
    moved: np.ndarray | None = None
    kinds: np.ndarray | None = None  # None also of a change of a measured quantity


def _notices(source: str, trend: xr.Dataset) -> Iterator[_Notice]:
    """Yield the changes and steps of a trend."""
    for k in range(trend.sizes["change"]):
        one = trend.isel(change=k)
        when = int(one.change_alarm), tuple(one.change_interval.values.tolist())
        kept = one.change_start.item(), one.change_moved.values, one.change_kind.values
        yield _Notice(*when, source, "", *kept)
    for k in range(trend.sizes["jump"]):
        one = trend.isel(jump=k)
        first = np.searchsorted(trend.operation, one.jump_from) - 1  # the last before it
        interval = float(trend.operation[max(first, 0)]), float(one.jump_noticed)
        yield _Notice(int(one.jump_noticed), interval, source, one.jump_words.item())


def _measured_notices(trend: xr.Dataset) -> Iterator[_Notice]:
    """Yield the changes of measured quantities, each bend of one of them once."""
    for followed in trend.followed.values:
        one = trend.sel(followed=followed)
        alarms, _, start, intervals = _alarms(one)
        motion, quantity = str(followed).split(" ", 1)
        for group in same_bend(intervals):
            interval = tuple(intervals[group[-1]].tolist())
            noticed, source = int(one.operation[alarms[group[0]]]), f"{quantity} of {motion}"
            yield _Notice(noticed, interval, f"measured {source}", "", start[group[-1]].item())


def _join(groups: list[list[_Notice]], others: Sequence[_Notice]) -> None:
    """Add notices to groups of the same bend, or as new ones; two groups never become one."""
    for each in others:
        for group in groups:
            if any(_overlap(each.interval, known.interval) for known in group):
                group.append(each)
                break
        else:
            groups.append([each])


def _told(group: Sequence[_Notice]) -> str:
    """Describe what was noticed of one bend, with its beginning as the best source knows it.

    Measured quantities are named where no trend of parameters saw it.
    """
    steps = ", ".join(each.step for each in group if each.step)
    bends = [each for each in group if not each.step]
    if not bends:
        return steps
    wear = [each for each in bends if each.kinds is not None]
    best = min(wear or bends, key=lambda each: each.interval[1] - each.interval[0])
    sources = " and ".join(dict.fromkeys(each.source for each in wear or bends))
    if not np.isfinite(best.start):
        return f"{sources}: a change that later ones took back"
    name = named(np.max([each.moved for each in wear], axis=0), best.kinds) if wear else sources
    if steps:
        return f"{steps}, with a change of {name}"
    low, high = best.interval
    of = f"{sources}: change" if wear else "change"
    return f"{of} of {name} at about {best.start:,.0f} ({low:,.0f} to {high:,.0f})"


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
    return spell_table(rows)
