"""The trend of a drive over its operations: from records to lines, alarms and remaining lives.

One pass over the operations of a *source*: one motion, or both where they agree. Each operation's
likelihood is taken near the trend so far (``information``), the hypotheses about the current
segment learn from it (``changepoint``), and the remaining life follows (``lifetime``). All that the
next operation needs is a :class:`State`, which is stored, so that new operations go on from it.

The first operations, the *reference*, are too few for a trend: see ``reference``, also for what
becomes of a drive that the model does not fit.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import xarray as xr
from tqdm import tqdm

from breaker.mechanism import NAMES, Limit
from breaker.model import Model, generator
from breaker.wear.changepoint import KINDS, Hypotheses, Tracker
from breaker.wear.lifetime import Horizon, Remaining, remaining_life
from breaker.wear.lines import SPACING
from breaker.wear.reference import Reference, find_reference
from breaker.wear.series import Series, likelihood, series_of
from breaker.wear.state import State

__all__ = ["Follower", "Series", "State", "age_bins", "series_of"]

_QUANTILES = (0.05, 0.5, 0.95)
_PER_CENT = 100.0


def age_bins(last: int) -> np.ndarray:
    """Return the edges of the ages in which run lengths are counted, operations, geometric."""
    return np.concatenate([[0.0], np.geomspace(1.0, max(last, 2), 60), [np.inf]])


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
    def prior(self):
        """Prior of the parameters, one for both motions."""
        return next(iter(self.models.values())).prior

    def begin(self, series: Series) -> State:
        """Return the state before the first operation of a series, with its baseline.

        Without an operation that all motions have there is none yet, and nothing is known.
        """
        first = int(series.operations[0])
        usable = np.logical_and.reduce([series.usable(motion) for motion in self.models])
        used = np.flatnonzero(usable)[: self.settings["baseline"]]
        if not used.size:
            return self._begin(first, None)
        records = {motion: series.records[motion][used] for motion in self.models}
        outputs = {motion: series.outputs[motion][used] for motion in self.models}
        start = find_reference(self.models, records, outputs)
        return self._begin(first, start)

    def _begin(self, first: int, start: Reference | None) -> State:
        return State(self.tracker.begin(first), start, 0, first, ())

    def idle(self, first: int) -> tuple[State, xr.Dataset]:
        """Return the state and the empty trend of a source that is not followed."""
        state = self._begin(first, None)
        left = remaining_life(self.tracker, state.hypotheses, self.limits, self.prior, self.horizon)
        row = self._row(state, left) | {"change_probability": 0.0, "alarm": False, "outlier": 0.0}
        return state, self._dataset(np.array([first]), [row]).isel(operation=slice(0, 0))

    def follow(self, state: State, series: Series) -> tuple[State, xr.Dataset]:
        """Go through operations.

        Args:
            state: What is known before them.
            series: The operations.

        Returns:
            What is known after them, and a dataset over ``operation``: ``level``, ``slope``
            (percent a thousand operations) and their 90 % intervals; ``scatter`` (percent) and
            ``outlier``; ``run_length_probability`` over ``age``; ``change_probability``, ``alarm``;
            ``start_interval`` and ``kind_probability`` of the segment's beginning, by now;
            ``remaining``, ``toward`` and ``beyond`` of each limit, and the ``value`` of each of
            their parts.
        """
        if state.reference is None:
            state = replace(self.begin(series), first=state.first)
        rows = []
        usable = {motion: series.usable(motion) for motion in self.models}
        name = " and ".join(self.models)
        count = range(len(series.operations))
        for i in tqdm(count, desc=f"following {name}", mininterval=5, unit="operation"):
            state, row, _ = self.step(state, series, i, usable)
            rows.append(row)
        return state, self._dataset(series.operations, rows)

    def step(
        self, state: State, series: Series, i: int, usable: Mapping[str, np.ndarray]
    ) -> tuple[State, dict[str, np.ndarray], Remaining]:
        """Learn from operation ``i`` of a series; return what follows and its row of results."""
        operation = int(series.operations[i])
        hypotheses = self.tracker.predict(state.hypotheses, operation)
        there = [motion for motion in self.models if usable[motion][i]]
        level, cov = hypotheses.level()
        predicted = level[: len(NAMES)], cov[: len(NAMES), : len(NAMES)]
        if state.seen < self.settings["baseline"]:
            predicted = None
        matrix, slope, centre = likelihood(
            {motion: self.models[motion] for motion in there}, series, i, state.reference, predicted
        )
        outlier = np.nan
        learns = bool(matrix.any())
        seen = state.seen + learns
        if learns:
            hypotheses, _, outlier = self.tracker.learn(hypotheses, matrix, slope, centre)
        changed = hypotheses.began_after(state.since)
        settled = seen >= self.settings["settle"]
        alarm = settled and changed >= self.settings["alarm_level"]
        alarms = (*state.alarms[-1:], operation) if alarm else state.alarms
        state = replace(state, hypotheses=hypotheses, seen=seen, alarms=alarms)
        left = remaining_life(self.tracker, hypotheses, self.limits, self.prior, self.horizon)
        if not seen:
            left = left.unknown()  # before the first record there is the prior alone
        row = self._row(state, left) | {
            "change_probability": changed,
            "alarm": alarm,
            "outlier": outlier,
        }
        return state, row, left

    def _row(self, state: State, left: Remaining) -> dict[str, np.ndarray]:
        """What is stored of an operation."""
        p, hypotheses = len(NAMES), state.hypotheses
        mean, cov = hypotheses.level()
        sd = 1.6449 * np.sqrt(np.diag(cov))
        ends = np.stack([mean - sd, mean, mean + sd])  # (3, 2 p)
        levels = self.prior.destandardise(ends[:, :p])
        slopes = _PER_CENT * self.prior.log_sds * ends[:, p:]
        before = state.alarms[-2] if len(state.alarms) > 1 else state.first
        began = hypotheses.weight * (
            (hypotheses.start > before) & (hypotheses.start <= state.since)
        )
        kinds = np.bincount(hypotheses.kind + 1, began, len(KINDS) + 1)[1:]
        age = hypotheses.operation - hypotheses.start
        ages = np.histogram(age, self._ages, weights=hypotheses.weight)[0]
        grid = self.horizon.grid
        return {
            "level": levels[1],
            "level_interval": levels[[0, 2]].T,
            "slope": slopes[1],
            "slope_interval": slopes[[0, 2]].T,
            "scatter": _PER_CENT * self.tracker.scatters[hypotheses.scatter] @ hypotheses.weight,
            "run_length_probability": ages,
            "start_interval": _start(hypotheses, began, before, state.since),
            "kind_probability": kinds / began.sum()
            if began.sum() > 0
            else np.full(len(KINDS), np.nan),
            "remaining": np.array([_reached(grid, cdf, _QUANTILES) for cdf in left.cdf]).reshape(
                len(left.cdf), len(_QUANTILES)
            ),
            "toward": left.toward,
            "beyond": left.beyond,
            "value": np.quantile(left.now, _QUANTILES, axis=0).T,
        }

    @property
    def _ages(self) -> np.ndarray:
        return age_bins(self.settings["horizon"])

    def _dataset(self, operations: np.ndarray, rows: list[dict]) -> xr.Dataset:
        dims = {
            **dict.fromkeys(("level", "slope"), ("parameter",)),
            **dict.fromkeys(("level_interval", "slope_interval"), ("parameter", "bound")),
            "run_length_probability": ("age",),
            "start_interval": ("quantile",),
            "kind_probability": ("kind",),
            "remaining": ("limit", "quantile"),
            **dict.fromkeys(("toward", "beyond"), ("limit",)),
            "value": ("part", "quantile"),
        }
        edges = self._ages
        parts = [(limit, part) for limit in self.limits for part in limit.parts]
        coords = {
            "operation": operations,
            "parameter": list(NAMES),
            "bound": ["lower", "upper"],
            "kind": list(KINDS),
            "quantile": list(_QUANTILES),
            "limit": [limit.name for limit in self.limits],
            "words": ("limit", [limit.words for limit in self.limits]),
            "part_limit": ("part", [limit.name for limit, _ in parts]),
            "part_quantity": ("part", [quantity for _, (quantity, _, _) in parts]),
            "part_bound": ("part", [bound for _, (_, bound, _) in parts]),
            "part_upper": ("part", [is_upper for _, (_, _, is_upper) in parts]),
            "age_lower": ("age", edges[:-1]),
            "age_upper": ("age", edges[1:]),
        }
        return xr.Dataset(
            {
                name: (("operation", *dims.get(name, ())), np.array([row[name] for row in rows]))
                for name in rows[0]
            },
            coords=coords,
        )


def _start(hypotheses: Hypotheses, began: np.ndarray, earliest: int, latest: int) -> np.ndarray:
    """Median and 90 % interval of the segment's beginning, ``(3,)``, operations.

    Hypotheses that began within a share of their age of each other are kept as one, and it may
    have begun anywhere among them, but not before the last alarm nor after its own.
    """
    low, middle, high = _quantiles(hypotheses.start, began, _QUANTILES)
    now = hypotheses.operation
    ends = low - SPACING * (now - low), high + SPACING * (now - high)
    return np.array([np.maximum(ends[0], earliest), middle, np.minimum(ends[1], latest)])


def _quantiles(values: np.ndarray, weight: np.ndarray, shares: Sequence[float]) -> np.ndarray:
    """Quantiles of weighted values, nan where nothing has a weight."""
    if not weight.sum() > 0:
        return np.full(len(shares), np.nan)
    order = np.argsort(values, kind="stable")
    ladder = np.cumsum(weight[order]) / weight.sum()
    place = np.minimum(np.searchsorted(ladder, shares), len(values) - 1)
    return values[order][place].astype(float)


def _reached(grid: np.ndarray, cdf: np.ndarray, shares: Sequence[float]) -> np.ndarray:
    """Future operations by which a probability is reached, inf where it is not, nan of nan."""
    if np.isnan(cdf).any():
        return np.full(len(shares), np.nan)
    return np.array(
        [np.interp(share, cdf, grid) if cdf[-1] >= share else np.inf for share in shares]
    )
