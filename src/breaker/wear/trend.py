"""The trend of a drive over its operations: from records to lines, alarms and remaining lives.

One pass over the operations of a *source*: one motion, or both where they agree. Each operation's
likelihood is taken near the trend so far (``series``), the hypotheses about the current segment
learn from it (``changepoint``), and the remaining life follows (``lifetime``). All that the next
operation needs is a :class:`State`, which is stored, so that new operations go on from it.

The first operations, the *reference*, are too few for a trend and are pooled: see ``reference``.

Where the model is held to leave something out, what is followed are apparent parameters, and true
ones are read off them: see ``difference``. Besides, every operation is compared with the last ones,
in all that it says, to notice a step at once: see ``steps``.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import xarray as xr
from tqdm import tqdm

from breaker.mechanism import NAMES, Limit
from breaker.model import Model, Prior, generator
from breaker.wear import rows
from breaker.wear.changepoint import Tracker
from breaker.wear.difference import Difference
from breaker.wear.events import after_event
from breaker.wear.hypotheses import Hypotheses, confirmed
from breaker.wear.learned import PHASES, Learned
from breaker.wear.lifetime import Horizon, Remaining, remaining_life
from breaker.wear.reference import find_reference, onset_of
from breaker.wear.series import Series, likelihood
from breaker.wear.state import State
from breaker.wear.steps import VARIANCE, Watch
from breaker.wear.temperature import Felt, Warmth, coefficient, feel, lines

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
        learned: What was learned of the difference of drives; None where the model is held to be
            right.
    """

    models: Mapping[str, Model]
    tracker: Tracker
    limits: Sequence[Limit]
    horizon: Horizon
    settings: Mapping
    learned: Learned | None = None
    _cache: dict = field(default_factory=dict, repr=False)

    @classmethod
    def from_settings(
        cls,
        models: Mapping[str, Model],
        limits: Sequence[Limit],
        settings: Mapping,
        seed: int,
        learned: Learned | None = None,
    ) -> "Follower":
        """Build from the section ``wear_model`` of the configuration.

        Of the limits, those on measured quantities are left out: see ``follow_measured``.
        """
        prior = next(iter(models.values())).prior
        tracker = Tracker.from_settings(settings, prior.log_sds)
        rng = generator(seed, "remaining life")
        normals = rng.standard_normal((settings["lines"], 2 * len(NAMES)))
        return cls(
            models,
            tracker if learned is None else replace(tracker, bend=settings["bend"]),
            [limit for limit in limits if limit.of == "model"],
            Horizon(settings["horizon"], normals, settings["widening"]),
            settings,
            learned,
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
        used = series.alike(np.flatnonzero(usable)[: self.settings["baseline"]])
        reference = None
        if used.size:
            records = {motion: series.records[motion][used] for motion in self.models}
            outputs = {motion: series.outputs[motion][used] for motion in self.models}
            reference = find_reference(self.models, records, outputs, self.learned)
        warmth = Warmth.begin(np.array([series.temperature_of(i) for i in used]))
        if reference is None or self.learned is None:
            return State(self.tracker.begin(first), reference, 0, first, (), warmth=warmth)
        matrix = reference.matrix
        difference = Difference.begin(self.learned, reference.difference, matrix, first)
        passes = difference.gain @ self.learned.new @ difference.gain.T
        watch = Watch.begin(len(matrix))
        hypotheses = self.tracker.begin(first, passes)
        return State(hypotheses, reference, 0, first, (), difference, watch, warmth)

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

        Returns:
            The state after them, and a dataset over ``operation``: ``level``, ``slope``
            (percent per thousand operations) and their 90 % intervals; ``scatter`` (percent) and
            ``outlier``; ``run_length_probability`` over ``age``; ``change_probability``, ``alarm``;
            ``start_interval`` and ``kind_probability`` of the segment's beginning, by now;
            ``event``, what a known event starts anew, in words; ``temperature_effect``, mean and
            sd of the change of ``gamma_a`` for 10 K, percent; ``remaining``, ``toward`` and
            ``beyond`` of each limit, and the ``value`` of each of their parts; ``surprise``,
            ``step`` and ``step_size`` of each phase (see ``steps``).
            Motions that differ are not followed: then there is no operation in it.
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
            i: Index of the operation in the series.
            usable: Which operations have a usable record of each motion, ``(o,)``.

        Returns:
            The state after it, its row of results and the remaining lives.
        """
        operation, p = int(series.operations[i]), len(NAMES)
        before, (state, felt) = state.hypotheses, self._predict(state, series, i)
        hypotheses = felt.at_it(state.hypotheses)
        level, cov = hypotheses.level()
        predicted = None if state.seen < self.settings["baseline"] else (level[:p], cov[:p, :p])
        there = {m: model for m, model in self._known(state).items() if usable[m][i]}
        matrix, slope, centre = self._likelihood(there, state, series, i, predicted, felt)
        learns, outlier = bool(matrix.any()), np.nan
        if learns:
            seen_alone = felt.blurred(matrix[:p, :p], slope[:p])
            hypotheses, _, outlier = self.tracker.learn(hypotheses, *seen_alone, centre)
        hypotheses, seen = felt.at_reference(hypotheses), state.seen + learns
        changed = confirmed(before, hypotheses, state.since)
        alarm = learns and changed >= self.settings["alarm_level"]
        alarm = alarm and seen >= self.settings["settle"]
        alarms = (*state.alarms[-1:], operation) if alarm else state.alarms
        state = replace(state, hypotheses=hypotheses, seen=seen, alarms=alarms)
        lacks = any(np.isnan(series.records[motion][i]).any() for motion in there)
        state, compared = self._compare(state, matrix, slope, learns, alarm, lacks)
        told = replace(state, hypotheses=self._true(state))
        left = remaining_life(told.hypotheses, self.limits, self.prior, self.horizon)
        if not seen:
            left = left.unknown()  # before the first record there is the prior alone
        row = rows.row(told, left, self.tracker, self.prior, self.horizon)
        row |= {"change_probability": ((), changed), "alarm": ((), alarm), "outlier": ((), outlier)}
        warmth = coefficient(hypotheses, self.tracker.log_sds)
        row |= {"temperature_effect": (("moment",), np.array(warmth))}
        row |= {"event": ((), series.event(i).told(operation))}
        return state, row | compared, left

    def _predict(self, state: State, series: Series, i: int) -> tuple[State, Felt]:
        """Return what is known before an operation, and what its temperature does."""
        predicted = self.tracker.predict(state.hypotheses, int(series.operations[i]))
        state = replace(state, hypotheses=predicted)
        state = after_event(series.event(i), state, self.tracker, self.learned)
        hypotheses, warmth, felt = feel(
            *(state.hypotheses, state.warmth, series.temperature_of(i)),
            *(self.settings, self.tracker.log_sds),
        )
        return replace(state, hypotheses=hypotheses, warmth=warmth), felt

    def _known(self, state: State) -> Mapping[str, Model]:
        """Models that know the difference which the reference shares, built once."""
        if state.difference is None:
            return self.models
        if self._cache.get("of") is not state.reference:
            models = self.learned.models(self.models, state.reference.difference)
            self._cache.update({"of": state.reference, "models": models})
        return self._cache["models"]

    def _likelihood(
        self,
        there: Mapping[str, Model],
        state: State,
        series: Series,
        i: int,
        predicted: tuple[np.ndarray, np.ndarray] | None,
        felt: Felt,
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Information of an operation about parameters and, if there is one, difference."""
        if state.difference is None:
            return likelihood(there, series, i, state.reference, predicted)
        centre, size = felt.moved(state.reference.centre), len(state.reference.matrix)
        if len(there) < len(self.models):  # the apparent parameters of one motion are others
            return np.zeros((size, size)), np.zeros(size), centre
        records = {motion: series.records[motion][i : i + 1] for motion in there}
        onsets = {motion: onset_of(series.outputs[motion][i : i + 1]) for motion in there}
        # Always at the reference: apparent parameters may lie far off, where the curve bends.
        found = self.learned.information(there, records, centre[None], onsets, steps=2)
        return found[0][0], found[1][0], centre

    def _true(self, state: State) -> Hypotheses:
        """Hypotheses about the true parameters, with the uncertainty that the difference leaves."""
        found, p = lines(state.hypotheses), len(NAMES)
        if state.difference is None:
            return found
        drift = found.level()[0][p:]
        readout = state.difference.readout(
            self.learned, found.operation, drift, self.tracker.slope_sd
        )
        mean, cov = readout.apply(found.mean, found.cov)
        return replace(found, mean=mean, cov=cov)

    def _compare(
        self,
        state: State,
        matrix: np.ndarray,
        slope: np.ndarray,
        learns: bool,
        alarm: bool,
        lacks: bool,
    ) -> tuple[State, rows.Row]:
        """Learn of the difference, and compare the operation with the last ones.

        Args:
            state: What is known after the operation of the rest.
            matrix, slope: Its information about parameters and difference.
            learns: Whether there is any.
            alarm: Whether a change of the trend is reported.
            lacks: Whether samples of its records are missing.
        """
        nothing = np.full(len(self.models) * len(PHASES), np.nan)
        row = {"surprise": ((), np.nan), "step": ((), False), "step_size": (("phase",), nothing)}
        if state.difference is None or not learns:
            return state, row
        reference, operation = state.reference, state.hypotheses.operation
        level = self.settings["step_p_value"] if state.seen > self.settings["settle"] else 0.0
        watch, surprise, change = state.watch, np.nan, None
        if not lacks or reference.resembles(matrix):
            said = np.linalg.solve(reference.root, slope)
            watch, surprise, change = watch.learn(float(operation), said, level)
        difference = state.difference.learn(operation, matrix, slope)
        if alarm or change is not None:
            drift = lines(state.hypotheses).level()[0][len(NAMES) :]
            difference = difference.renewed(
                self.learned, operation, drift, stepped=change is not None
            )
        row["surprise"] = ((), surprise)
        if change is not None:
            sizes = self.learned.step_sizes(
                *(self._known(state), reference.centre, reference.matrix),
                *(reference.root @ change, self.tracker.step_sd),
                variance=VARIANCE,
            )
            row |= {"step": ((), True), "step_size": (("phase",), sizes)}
        return replace(state, difference=difference, watch=watch), row

    def dataset(self, operations: np.ndarray, found: Sequence[rows.Row]) -> xr.Dataset:
        """Put the rows of operations ``(o,)``, at least one, into one dataset."""
        last = self.horizon.operations
        return rows.dataset(operations, found, self.limits, last, list(self.models))
