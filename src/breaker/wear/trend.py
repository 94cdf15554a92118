"""The trend of a drive over its operations: from records to lines, alarms and remaining lives.

One pass over the operations of a *source*: one motion, or both where they agree. Each operation's
likelihood is taken near the trend so far (``series``), the hypotheses about the current segment
learn from it (``changepoint``), and the remaining life follows (``lifetime``). All that the next
operation needs is a :class:`State`, which is stored, so that new operations go on from it.

The first operations, the *reference*, are too few for a trend and are pooled: see ``reference``,
also for how a drive is followed that the model does not fit.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import xarray as xr
from tqdm import tqdm

from breaker.mechanism import NAMES, Limit
from breaker.model import Model, Prior, generator
from breaker.wear import rows
from breaker.wear.changepoint import Tracker
from breaker.wear.lifetime import Horizon, Remaining, remaining_life
from breaker.wear.reference import find_reference
from breaker.wear.series import Series, likelihood
from breaker.wear.state import State

__all__ = ["Follower"]


@dataclass(frozen=True, eq=False)
class Follower:
    """What follows a drive: its models, its model of wear and its limits.

    Attributes:
        models: Joint model of each motion of the source.
        tracker: The model of wear.
        limits: Limits of which a remaining life is asked.
        horizon: How far it is looked for.
        settings: The section ``wear_model`` of the configuration.
    """

    models: Mapping[str, Model]
    tracker: Tracker
    limits: Sequence[Limit]
    horizon: Horizon
    settings: Mapping

    @classmethod
    def from_settings(
        cls, models: Mapping[str, Model], limits: Sequence[Limit], settings: Mapping, seed: int
    ) -> "Follower":
        """Build from the section ``wear_model`` of the configuration."""
        prior = next(iter(models.values())).prior
        rng = generator(seed, "remaining life")
        normals = rng.standard_normal((settings["lines"], 2 * len(NAMES)))
        return cls(
            models,
            Tracker.from_settings(settings, prior.log_sds),
            limits,
            Horizon(settings["horizon"], normals, settings["widening"]),
            settings,
        )

    @property
    def prior(self) -> Prior:
        """Prior of the parameters, one for both motions."""
        return next(iter(self.models.values())).prior

    def begin(self, series: Series) -> State:
        """Return the state before the first operation of a series, with its reference.

        Without an operation with records of all motions there is no reference, and nothing is
        known.
        """
        first = int(series.operations[0])
        usable = np.logical_and.reduce([series.usable(motion) for motion in self.models])
        used = np.flatnonzero(usable)[: self.settings["baseline"]]
        reference = None
        if used.size:
            records = {motion: series.records[motion][used] for motion in self.models}
            outputs = {motion: series.outputs[motion][used] for motion in self.models}
            reference = find_reference(self.models, records, outputs)
        return State(self.tracker.begin(first), reference, 0, first, ())

    def together(self, state: State) -> bool:
        """Say whether the source can be followed: one motion, or two that agree."""
        if len(self.models) < 2:
            return True
        level = self.settings["agreement_p_value"]
        return state.reference is not None and state.reference.agreement >= level

    def follow(self, state: State, series: Series) -> tuple[State, xr.Dataset]:
        """Go through operations.

        Args:
            state: What is known before them.
            series: The operations.

        Returns:
            The state after them, and a dataset over ``operation``: ``level``, ``slope``
            (percent per thousand operations) and their 90 % intervals; ``scatter`` (percent) and
            ``outlier``; ``run_length_probability`` over ``age``; ``change_probability``, ``alarm``;
            ``start_interval`` and ``kind_probability`` of the segment's beginning, by now;
            ``remaining``, ``toward`` and ``beyond`` of each limit, and the ``value`` of each of
            their parts. Motions that differ are not followed: then there is no operation in it.
        """
        if state.reference is None:
            state = replace(self.begin(series), first=state.first)
        if not self.together(state):
            nothing = dict.fromkeys(self.models, np.zeros(1, dtype=bool))
            _, row, _ = self.step(state, series, 0, nothing)  # for its form
            return state, self.dataset(series.operations[:1], [row]).isel(operation=slice(0, 0))
        found = []
        usable = {motion: series.usable(motion) for motion in self.models}
        name, count = " and ".join(self.models), range(len(series.operations))
        for i in tqdm(count, desc=f"following {name}", mininterval=5, unit="operation"):
            state, row, _ = self.step(state, series, i, usable)
            found.append(row)
        return state, self.dataset(series.operations, found)

    def step(
        self, state: State, series: Series, i: int, usable: Mapping[str, np.ndarray]
    ) -> tuple[State, rows.Row, Remaining]:
        """Learn from operation ``i`` of a series.

        Args:
            state: What is known before it.
            series: The operations.
            i: Index of the operation in the series.
            usable: Which operations have a usable record of each motion, ``(o,)``.

        Returns:
            The state after it, its row of results and the remaining lives.
        """
        operation, p = int(series.operations[i]), len(NAMES)
        hypotheses = self.tracker.predict(state.hypotheses, operation)
        level, cov = hypotheses.level()
        predicted = None if state.seen < self.settings["baseline"] else (level[:p], cov[:p, :p])
        there = {motion: self.models[motion] for motion in self.models if usable[motion][i]}
        matrix, slope, centre = likelihood(there, series, i, state.reference, predicted)
        learns, outlier = bool(matrix.any()), np.nan
        if learns:
            hypotheses, _, outlier = self.tracker.learn(hypotheses, matrix, slope, centre)
        seen = state.seen + learns
        changed = hypotheses.began_after(state.since)
        alarm = seen >= self.settings["settle"] and changed >= self.settings["alarm_level"]
        alarms = (*state.alarms[-1:], operation) if alarm else state.alarms
        state = replace(state, hypotheses=hypotheses, seen=seen, alarms=alarms)
        left = remaining_life(self.tracker, hypotheses, self.limits, self.prior, self.horizon)
        if not seen:
            left = left.unknown()  # before the first record there is the prior alone
        row = rows.row(state, left, self.tracker, self.prior, self.horizon)
        row |= {"change_probability": ((), changed), "alarm": ((), alarm), "outlier": ((), outlier)}
        return state, row, left

    def dataset(self, operations: np.ndarray, found: Sequence[rows.Row]) -> xr.Dataset:
        """Put the rows of operations ``(o,)``, at least one, into one dataset."""
        return rows.dataset(operations, found, self.limits, self.horizon.operations)
