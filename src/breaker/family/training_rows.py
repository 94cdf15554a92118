"""Rows of a bank for training: what the networks see and estimate; and their quality on others."""

from collections.abc import Sequence
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pandas as pd
import xarray as xr

from breaker.common.compiling import compiled
from breaker.common.zarr_store import open_store
from breaker.family.bank import GRID, GRID_STEP, shapes
from breaker.family.inputs import (
    Basis,
    NormalisedRecords,
    Sensors,
    change_inputs,
    state_inputs,
    units_of,
    without_onset,
)
from breaker.family.networks import (
    EFFECTS,
    EVENTS,
    WEARING,
    ChangeNetwork,
    StateNetwork,
    TrainedNetwork,
    effect_outputs,
    plausible_wear,
)
from breaker.family.rich_drive import CONTACTS, ELEMENTS
from breaker.family.shape import LEVELS, SHAPE_TIMES
from breaker.family.training_records import record_shapes
from breaker.model.parameters import FORCE, GAP, MOTIONS, NAMES, powers
from breaker.paper.calibration import coverage, judge_ranks, ranks

_SOME = np.array([[True, False], [False, True], [True, True]])  # motions that a drive records
_MOST = 8000  # drives that components are of: more change none of them
_COMPONENTS, _CHANGE_COMPONENTS = 64, 40
_STROKE = 10.0  # mm, to which the fall of the force refers
_WAY = LEVELS[1] - LEVELS[0]  # of the stroke, made in a duration
_LEAST_SCALE = 1e-6  # scale of an effect that no drive has
_SAME = 1e-4  # durations, by which touch or separation may move and count as unchanged
_CHANGE = 0.03  # of the logarithm of a parameter, and of an effect over the closing force
_TERMS, _FASTEST = 3, 0.3  # terms of curves that nobody explains, and their periods in a duration


@dataclass
class BankRows:
    """Drives of a bank, with new records of them for each batch.

    Attributes:
        bank: Drives: see ``bank.simulate_family``.
        frozen: Scales of inputs and outputs, as networks have them: from ``freeze`` or a network.
        noise: Range of the noise of the sensors, as of ``Sensors``.
    """

    network: ClassVar[type[TrainedNetwork]]

    bank: xr.Dataset
    frozen: dict[str, Any] = field(default_factory=dict)
    noise: tuple[float, float] = Sensors().noise

    def __post_init__(self) -> None:
        self.sensors = Sensors(noise=self.noise)
        self.curves = self.bank["shape"].values  # (drive, condition, motion, u), as stored
        self.theta = self.bank.parameters.values
        self.stroke = self.bank.stroke.values
        self.duration = self.bank.duration.values
        self.events = np.stack([self.bank.release.values, self.bank.switching.values], axis=-1)

    def __len__(self) -> int:
        return len(self.theta)

    def rows(self, drives: np.ndarray, rng: np.random.Generator) -> tuple[np.ndarray, ...]:
        """Return inputs ``(n, i)``, outputs ``(n, q)`` and which are there, of drives ``(n,)``."""
        x, y, there, _ = self.unscaled(drives, rng)
        return x, (y - self.frozen["centre"]) / self.frozen["scale"], there

    def freeze(self, rng: np.random.Generator) -> None:
        """Set the scales of inputs and outputs."""
        drives, bases = rng.permutation(len(self))[:_MOST], {}
        for m, motion in enumerate(MOTIONS):
            seen, _ = record_shapes(shapes(self.curves[drives, 0, m]), rng, Sensors())
            bases[motion] = Basis.of(seen.way[seen.present.mean(axis=1) > 0.9], _COMPONENTS)
        sizes = np.log(self.stroke[:, 0]), np.log(self.duration[:, 0])
        usual = np.array([[logs.mean(), logs.std()] for logs in sizes])
        self.frozen = {"bases": bases, "usual": usual}
        self.frozen |= self._more_scales(drives, rng)

    def _in_units(
        self, seen: NormalisedRecords, drives: np.ndarray, condition: np.ndarray, motion: int
    ) -> NormalisedRecords:
        """Records in mm and ms instead of the strokes and durations of their curves."""
        stroke, duration = self.stroke[drives, condition], self.duration[drives, condition, motion]
        return seen._replace(stroke=seen.stroke * stroke, duration=seen.duration * duration)

    def _there(self, records: dict[str, NormalisedRecords]) -> np.ndarray:
        return self.network.there(np.column_stack([seen.there for seen in records.values()]))

    def _effects(
        self, drives: np.ndarray, condition: np.ndarray, elements: np.ndarray
    ) -> dict[str, np.ndarray]:
        """Size of each of ``EFFECTS``, ``(n,)``, of drives in a condition; with the elements of
        that condition or another.
        """
        stroke = self.stroke[drives, condition]
        speed = _WAY * stroke / self.duration[drives, condition, MOTIONS.index("closing")]
        has = dict(zip(ELEMENTS, self.bank.elements.values[drives, elements].T, strict=True))
        has |= dict(zip(NAMES, self.theta[drives, condition].T, strict=True))
        slides = self.bank.contact.values[drives] == CONTACTS.index("sliding")
        force = has[FORCE.name]
        dampers = {
            f"{end}_damper": has[f"{end}_stop.damping"] * speed ** has[f"{end}_stop.power"] / force
            for end in MOTIONS
        }
        sizes = dampers | {
            "contact_preload": np.where(slides, 0.0, has["contact_preload"] / force),
            "sliding_contact": np.where(slides, has[GAP.name] / stroke, 0.0),
            "build_up": has["build_up"],
            "dry_friction": has["dry_friction"] / force,
            "opening_preload": has["opening_preload"] / force,
            "force_fall": has["force_fall"] * stroke / _STROKE,
            "drag": has["drag"] * speed ** has["drag_power"] / force,
            "train_mass": has["train_mass"],
        }
        return {name: sizes[name] for name in EFFECTS}


@dataclass
class StateRows(BankRows):
    """Records of one operation, and the state of the drive.

    Attributes:
        known_size: Share of the drives whose size is known: users know it more often than not.
    """

    network, from_logarithms = StateNetwork, staticmethod(np.exp)

    noise: tuple[float, float] = (1e-4, 3e-2)
    known_size: float = 0.6

    def _more_scales(self, drives: np.ndarray, rng: np.random.Generator) -> dict[str, Any]:
        _, y, there, _ = self.unscaled(drives, rng)
        y = np.where(there, y, np.nan)
        centre, scale = np.nanmean(y, axis=0), np.nanstd(y, axis=0)
        first = len(NAMES) + len(EVENTS)
        centre[first:] = 0.0  # which is where an effect is that is not there
        scale[first:] = np.sqrt(np.nanmean(np.square(y[:, first:]), axis=0)) + _LEAST_SCALE
        return {"centre": centre, "scale": scale}

    def unscaled(
        self, drives: np.ndarray, rng: np.random.Generator, motions: np.ndarray = _SOME
    ) -> tuple[np.ndarray, ...]:
        """Return inputs, outputs before their scales, which are there, and units of the outputs.

        With its unit an output is the logarithm of a parameter.

        Args:
            drives: Numbers of drives, ``(n,)``.
            motions: Which motions there may be, ``(k, 2)``; each drive has one of these rows.
        """
        n = len(drives)
        condition = rng.integers(0, 2, n)
        motions = motions[rng.integers(0, len(motions), n)]
        known = rng.random(n) < self.known_size
        records, events = {}, []
        for m, motion in enumerate(MOTIONS):
            curves = shapes(self.curves[drives, condition, m])
            seen, origin = record_shapes(curves, rng, self.sensors, wanted=motions[:, m])
            after = self.events[drives, condition, m] - origin[:, None]
            events.append(after / seen.duration[:, None])
            records[motion] = self._in_units(seen, drives, condition, m)
        x = state_inputs(records, known, self.frozen["bases"], self.frozen["usual"])
        events = np.hstack(events)
        events = np.where(np.isfinite(events), events, SHAPE_TIMES[-1])
        stroke, duration = units_of(records)
        (length, time), logs = powers(), np.log(self.theta[drives, condition])
        scaled = logs - (np.log(stroke)[:, None] * length + np.log(duration)[:, None] * time)
        effects = effect_outputs(self._effects(drives, condition, condition), duration)
        y = np.hstack([scaled, events, effects])
        units = np.zeros_like(y)
        units[:, : len(NAMES)] = logs - scaled
        return x, y, self._there(records), units


@dataclass
class ChangeRows(BankRows):
    """Records of a drive in two conditions, and what has changed.

    Attributes:
        noise: Of means of many records down.
        back: Share of the changes that go from worn to new, as after maintenance.
        odd: Range of the size of what nobody explains, as a share of a change, log-uniform; none if
            it is empty.
    """

    network = ChangeNetwork

    noise: tuple[float, float] = (1e-5, 1e-2)
    back: float = 0.2
    odd: tuple[float, ...] = (0.005, 0.05)

    @staticmethod
    def from_logarithms(logs: np.ndarray) -> np.ndarray:
        """Return changes in percent."""
        return 100.0 * np.expm1(logs)

    def _more_scales(self, drives: np.ndarray, rng: np.random.Generator) -> dict[str, Any]:
        order, both = np.array([[0], [1]]) + 0 * drives, np.ones((len(drives), 2), dtype=bool)
        clean = replace(self, noise=Sensors().noise, odd=())
        bases = {}
        for motion, change in clean._records(drives, order, both, rng)[1].items():
            basis = Basis.of(change.way, _CHANGE_COMPONENTS)
            bases[motion] = basis._replace(mean=np.zeros(SHAPE_TIMES.size))
        scale = np.full(len(self.network.outputs), _CHANGE)
        return {"change_bases": bases, "centre": 0.0 * scale, "scale": scale}

    def unscaled(
        self, drives: np.ndarray, rng: np.random.Generator, motions: np.ndarray = _SOME
    ) -> tuple[np.ndarray, ...]:
        """Return inputs, outputs before their scales, which are there, and zeros as their units.

        Arguments as of ``StateRows.unscaled``.
        """
        n = len(drives)
        motions = motions[rng.integers(0, len(motions), n)]
        before = (rng.random(n) < self.back).astype(int)
        order = np.array([before, 1 - before])
        records, changes, y = self._records(drives, order, motions, rng)
        scales = (self.frozen[name] for name in ("bases", "change_bases", "usual"))
        x = change_inputs(records, changes, *scales)
        return x, y, self._there(records), np.zeros_like(y)

    def _records(self, drives, order, motions, rng):
        """References in mm and ms, changes from them, and outputs, ``(n, q)``.

        ``order`` has the conditions before and after, ``(2, n)``.
        """
        references, changes, moved = {}, {}, []
        for m, motion in enumerate(MOTIONS):
            curves = [shapes(self.curves[drives, each, m]) for each in order]
            stroke = [self.stroke[drives, each] for each in order]
            unit = [self.duration[drives, each, m] for each in order]
            seen, _ = record_shapes(curves[0], rng, self.sensors, wanted=motions[:, m])
            seen = self._in_units(seen, drives, order[0], m)
            like = seen.stroke / stroke[1], seen.duration / unit[1]
            after, _ = record_shapes(curves[1], rng, self.sensors, wanted=seen.there, like=like)
            if self.odd:
                some = after.there
                sizes = [stroke[1] / stroke[0], unit[0] / unit[1]]
                size = _sizes(*(values[some] for values in (*curves, *sizes)))
                after.way[some] += _odd(size, self.odd, rng)
            there = seen.present & after.present
            change = without_onset(seen.way, after.way, there)
            noises = np.hypot(seen.noise, after.noise)
            references[motion] = seen._replace(there=seen.there & after.there)
            changes[motion] = after._replace(way=change, present=there, noise=noises)
            took = [
                np.diff(self.events[drives, each, m])[:, 0] * time
                for each, time in zip(order, unit, strict=True)
            ]
            late = took[1] - took[0]
            late = np.where(np.isfinite(late), late, 0.0) / seen.duration
            moved.append(np.where(np.abs(late) < _SAME, 0.0, late))
        before, after = (self.theta[drives, each] for each in order)
        logs = np.log(np.where(after == before, 1.0, after / before))
        was, by = (self._effects(drives, order[0], elements) for elements in order)
        worn = effect_outputs({n: by[n] - was[n] for n in WEARING}, units_of(references)[1])
        return references, changes, np.hstack([logs, np.array(moved).T, worn])


def _odd(size: np.ndarray, share: tuple[float, float], rng: np.random.Generator) -> np.ndarray:
    """Smooth random curves ``(n, g)``, as large as shares of changes of a size ``(n,)``."""
    size = size * np.exp(rng.uniform(*np.log(share), len(size)))
    rate, phase = rng.uniform(0.0, 1.0, (2, len(size), _TERMS, 1))
    curves = np.sin(2.0 * np.pi * (_FASTEST * rate * SHAPE_TIMES + phase)).sum(axis=1)
    return size[:, None] * np.clip(SHAPE_TIMES + 1.0, 0.0, 1.0) * curves  # none at the rest before


@compiled()
def _sizes(before, after, length, unit):
    """Root mean square of a change in the units of what was before, ``(n,)``."""
    found = np.empty(len(before))
    for r in range(len(before)):
        total = 0.0
        for i in range(before.shape[1]):
            place = (GRID[i] * unit[r] - GRID[0]) / GRID_STEP
            j = min(max(int(place), 0), before.shape[1] - 2)
            x = min(max(place - j, 0.0), 1.0)
            there = (1.0 - x) * after[r, j] + x * after[r, j + 1]
            total += (length[r] * there - before[r, i]) ** 2
        found[r] = np.sqrt(total / before.shape[1])
    return found


def rows_of(
    kind: str, bank: xr.Dataset, like: TrainedNetwork | None = None, **drawn: Any
) -> BankRows:
    """Return rows of "levels" or "changes", in the scales of a network if one is given.

    Args:
        drawn: What the rows draw otherwise than in training: attributes of ``StateRows`` or
            ``ChangeRows``.
    """
    frozen = {part.name: getattr(like, part.name) for part in fields(like)} if like else {}
    return (StateRows if kind == StateNetwork.kind else ChangeRows)(bank, frozen, **drawn)


def sample_rows(
    network: TrainedNetwork, rows: BankRows, source: str, draws: int, rng: np.random.Generator
) -> xr.Dataset:
    """Draw from the posteriors of one record of each motion of each drive.

    Args:
        rows: Drives, in the scales of the network.
        source: Which motions there are: "closing", "opening" or "both".

    Returns:
        ``draws (curve, draw, output)`` and ``truth (curve, output)``: parameters, or their changes
        in percent, and events, in durations. What is exactly 0 has a random order, by a jitter of
        a billionth of a scale. Changes beyond any wear are left out; ``withheld`` counts them.
    """
    logs, motions = len(NAMES), np.array([[source in (motion, "both") for motion in MOTIONS]])
    x, y, there, units = rows.unscaled(np.arange(len(rows)), rng, motions)
    told = there.any(axis=0)
    x, y, units = (values[(there == told).all(axis=1)] for values in (x, y, units))
    features = network.network.features(x)
    values = np.stack([network.sample(row[None], told, draws, rng)[0] for row in features])
    kept = np.ones(len(values), dtype=bool)
    if isinstance(network, ChangeNetwork):
        kept = plausible_wear(values[..., :logs])

    def physical(outputs: np.ndarray, units: np.ndarray) -> np.ndarray:
        jitter = 1e-9 * network.scale * rng.standard_normal(outputs.shape)
        outputs = outputs + units + np.array(network.atoms) * jitter
        outputs[..., :logs] = rows.from_logarithms(outputs[..., :logs])
        return outputs[..., told]

    return xr.Dataset(
        {
            "draws": (("curve", "draw", "output"), physical(values[kept], units[kept][:, None])),
            "truth": (("curve", "output"), physical(y[kept], units[kept])),
        },
        {"output": np.array(network.outputs)[told]},
        {"withheld": int((~kept).sum())},
    )


def open_family(shards: Sequence[str | Path], held_out: int) -> tuple[xr.Dataset, xr.Dataset]:
    """Read the shards of a bank, and separate its last drives.

    Raises:
        ValueError: If that leaves no drives to train on.
    """
    bank = xr.concat([open_store(path) for path in shards], dim="drive", combine_attrs="override")
    rest = bank.sizes["drive"] - held_out
    if rest <= 0:
        raise ValueError(
            f"the bank has {rest + held_out} drives, and {held_out} are held out: none is left to "
            "train on; raise family.drives"
        )
    return bank.isel(drive=slice(rest)), bank.isel(drive=slice(rest, None))


def family_quality(data: xr.Dataset, *, log: bool) -> pd.DataFrame:
    """Judge a network of a family on held-out drives: one row an output.

    Args:
        data: Result of ``sample_rows``.
        log: Whether parameters are judged by their logarithms.

    Returns:
        Columns ``output``, ``calibration_p`` and ``calibrated``, all outputs together at 99 %,
        ``coverage_90``, ``contraction`` (1 - mean square error of the posterior mean over the
        variance of the truth, nan where that does not vary), and in the scale of the judgement
        ``rms_error`` and ``half_width``, the median half width of 90 % intervals.
    """
    draws, truth = data.draws.values.copy(), data.truth.values.copy()
    logs = log & np.isin(data.output.values, NAMES)
    for values in (draws, truth):
        values[..., logs] = np.log(values[..., logs])
    rank, count = ranks(draws, truth), data.sizes["draw"]
    judged = judge_ranks(rank, count, alpha=0.01)
    square = np.square(draws.mean(axis=1) - truth).mean(axis=0)
    low, high = np.quantile(draws, [0.05, 0.95], axis=1)
    spread = truth.var(axis=0)
    spread[spread < 1e-12] = np.nan  # round-off of what does not vary
    return pd.DataFrame(
        {
            "output": data.output.values,
            "calibration_p": judged.p_values,
            "calibrated": ~judged.outside,
            "coverage_90": coverage(rank, count, levels=[0.9])[0],
            "contraction": 1.0 - square / spread,
            "rms_error": np.sqrt(square),
            "half_width": np.median(high - low, axis=0) / 2.0,
        }
    )
