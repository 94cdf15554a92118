"""Rows of a bank: inputs and outputs of the networks, for training and for validation."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import xarray as xr

from breaker.common.compiling import compiled
from breaker.family.bank import GRID, shapes
from breaker.family.inputs import (
    Basis,
    NormalisedRecords,
    Sensors,
    change_inputs,
    state_inputs,
    units_of,
    without_onset,
)
from breaker.family.integrator import STROKE
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

_SOME = np.array([[True, False], [False, True], [True, True]])  # recorded motions of a drive
_MOST = 8000  # drives from which components are computed: more drives do not change them
_COMPONENTS = 64, 40  # of shapes, and of their changes
_LEAST_SCALE = 1e-6  # scale of an effect that no drive has
_SAME = 1e-4  # durations, below which touch or separation counts as unchanged
_CHANGE = 0.03  # scale of changes of log parameters, and of effects over the closing force
_TERMS, _FASTEST = 3, 0.3  # terms of unexplained curves, and most periods of a term in a duration


@dataclass
class BankRows:
    """Drives of a bank, with new records for each batch by sensors in a range of noise. Subclasses
    define ``network``, and ``_made``, which returns records, inputs, outputs and their units.

    Attributes:
        bank: Drives: see ``bank.simulate_family``.
        frozen: Scales of inputs and outputs, from ``freeze`` or a network.
    """

    bank: xr.Dataset
    frozen: Mapping[str, Any] = field(default_factory=dict)
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
        """Return inputs ``(n, i)`` of drives, outputs ``(n, q)``, and which they determine."""
        x, y, there, _ = self.unscaled(drives, rng)
        return x, (y - self.frozen["centre"]) / self.frozen["scale"], there

    def unscaled(
        self, drives: np.ndarray, rng: np.random.Generator, motions: np.ndarray = _SOME
    ) -> tuple[np.ndarray, ...]:
        """Return inputs, unscaled outputs, which of them are determined, and terms that make those
        of a state logarithms of parameters.

        Args:
            drives: Indices of drives, ``(n,)``.
            motions: Sets of recorded motions, ``(k, 2)``; each drive has one of these rows.
        """
        records, x, y, units = self._made(drives, rng, motions)
        there = np.column_stack([seen.there for seen in records.values()])
        return x, y, self.network.there(there), units

    def freeze(self, rng: np.random.Generator) -> None:
        """Set the scales of inputs and outputs."""
        drives, bases = rng.permutation(len(self))[:_MOST], {}
        for m, motion in enumerate(MOTIONS):
            seen, _ = record_shapes(shapes(self.curves[drives, 0, m]), rng, Sensors())
            bases[motion] = Basis.of(seen.way[seen.present.mean(axis=1) > 0.9], _COMPONENTS[0])
        sizes = np.log(self.stroke[:, 0]), np.log(self.duration[:, 0])
        usual = np.array([[logs.mean(), logs.std()] for logs in sizes])
        self.frozen = {"bases": bases, "usual": usual}
        self.frozen |= self._more_scales(drives, rng)

    def _in_units(
        self, seen: NormalisedRecords, drives: np.ndarray, condition: np.ndarray, motion: int
    ) -> NormalisedRecords:
        """Return records in mm and ms instead of the strokes and durations of their curves."""
        stroke, duration = self.stroke[drives, condition], self.duration[drives, condition, motion]
        return seen._replace(stroke=seen.stroke * stroke, duration=seen.duration * duration)

    def _effects(
        self, drives: np.ndarray, condition: np.ndarray, elements: np.ndarray
    ) -> dict[str, np.ndarray]:
        """Return sizes ``(n,)`` of ``EFFECTS`` in a condition, with ``elements`` of any."""
        stroke = self.stroke[drives, condition]
        duration = self.duration[drives, condition, MOTIONS.index("closing")]
        speed = np.ptp(LEVELS) * stroke / duration
        numbers = dict(zip(ELEMENTS, self.bank.elements.values[drives, elements].T, strict=True))
        numbers |= dict(zip(NAMES, self.theta[drives, condition].T, strict=True))
        slides = self.bank.contact.values[drives] == CONTACTS.index("sliding")
        force = numbers[FORCE.name]
        sizes = {name: numbers[name] / force for name in ("dry_friction", "opening_preload")}
        sizes |= {name: numbers[name] for name in ("build_up", "train_mass")}
        sizes["contact_preload"] = np.where(slides, 0.0, numbers["contact_preload"] / force)
        sizes["sliding_contact"] = np.where(slides, numbers[GAP.name] / stroke, 0.0)
        sizes["force_fall"] = numbers["force_fall"] * stroke / STROKE
        sizes["drag"] = numbers["drag"] * speed ** numbers["drag_power"] / force
        for end in MOTIONS:
            damping = numbers[f"{end}_stop.damping"] * speed ** numbers[f"{end}_stop.power"]
            sizes[f"{end}_damper"] = damping / force
        return {name: sizes[name] for name in EFFECTS}


@dataclass
class StateRows(BankRows):
    """Records of one operation, and the state of the drive. The size is known for a share of the
    drives, more than half, as users usually know it.
    """

    network = StateNetwork
    noise: tuple[float, float] = (1e-4, 3e-2)
    known_size: float = 0.6

    def _more_scales(self, drives: np.ndarray, rng: np.random.Generator) -> dict[str, Any]:
        _, y, there, _ = self.unscaled(drives, rng)
        y = np.where(there, y, np.nan)
        centre, scale = np.nanmean(y, axis=0), np.nanstd(y, axis=0)
        first = len(NAMES) + len(EVENTS)
        centre[first:] = 0.0  # the size of an absent effect
        scale[first:] = np.sqrt(np.nanmean(np.square(y[:, first:]), axis=0)) + _LEAST_SCALE
        return {"centre": centre, "scale": scale}

    def _made(self, drives, rng, motions):
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
        units = np.pad(logs - scaled, [(0, 0), (0, y.shape[1] - len(NAMES))])
        return records, x, y, units


@dataclass
class ChangeRows(BankRows):
    """Records of a drive in two conditions, and the changes of its parameters.

    Attributes:
        noise: Range of noise; the lower end is that of means of many records.
        back: Share of the changes that go from worn to new, as after maintenance.
        odd: Range of unexplained changes, log-uniform, as a share of a change; none if empty.
    """

    network = ChangeNetwork
    noise: tuple[float, float] = (1e-5, 1e-2)
    back: float = 0.2
    odd: tuple[float, ...] = (0.005, 0.05)

    def _more_scales(self, drives: np.ndarray, rng: np.random.Generator) -> dict[str, Any]:
        order, both = np.array([[0], [1]]), np.ones((len(drives), 2), dtype=bool)
        clean = replace(self, noise=Sensors().noise, odd=())
        bases = {}
        for motion, change in clean._records(drives, order, both, rng)[1].items():
            basis = Basis.of(change.way, _COMPONENTS[1])
            bases[motion] = basis._replace(mean=np.zeros(SHAPE_TIMES.size))
        scale = np.full(len(self.network.outputs), _CHANGE)
        return {"change_bases": bases, "centre": 0.0 * scale, "scale": scale}

    def _made(self, drives, rng, motions):
        n = len(drives)
        motions = motions[rng.integers(0, len(motions), n)]
        before = (rng.random(n) < self.back).astype(int)
        order = np.array([before, 1 - before])
        records, changes, y = self._records(drives, order, motions, rng)
        scales = (self.frozen[name] for name in ("bases", "change_bases", "usual"))
        return records, change_inputs(records, changes, *scales), y, np.zeros_like(y)

    def _records(self, drives, order, motions, rng):
        """Return references in mm and ms, changes, and outputs, by conditions before and after."""
        references, changes, moved = {}, {}, []
        for m, motion in enumerate(MOTIONS):
            curves = [shapes(self.curves[drives, which, m]) for which in order]
            stroke, unit = self.stroke[drives, order], self.duration[drives, order, m]
            seen, _ = record_shapes(curves[0], rng, self.sensors, wanted=motions[:, m])
            seen = self._in_units(seen, drives, order[0], m)
            like = seen.stroke / stroke[1], seen.duration / unit[1]
            after, _ = record_shapes(curves[1], rng, self.sensors, wanted=seen.there, like=like)
            if self.odd:
                both = after.there
                sizes = (*curves, stroke[1] / stroke[0], unit[0] / unit[1])
                size = _sizes(*(values[both] for values in sizes))
                after.way[both] += _smooth(size, self.odd, rng)
            there = seen.present & after.present
            change = without_onset(seen.way, after.way, there)
            noises = np.hypot(seen.noise, after.noise)
            references[motion] = seen._replace(there=seen.there & after.there)
            changes[motion] = after._replace(way=change, present=there, noise=noises)
            took = np.diff(self.events[drives, order, m])[..., 0] * unit
            late = took[1] - took[0]
            late = np.where(np.isfinite(late), late, 0.0) / seen.duration
            moved.append(np.where(np.abs(late) < _SAME, 0.0, late))
        before, after = self.theta[drives, order]
        logs = np.log(np.where(after == before, 1.0, after / before))
        was, now = (self._effects(drives, order[0], elements) for elements in order)
        worn = effect_outputs({n: now[n] - was[n] for n in WEARING}, units_of(references)[1])
        return references, changes, np.hstack([logs, np.array(moved).T, worn])


def _smooth(size: np.ndarray, share: tuple[float, float], rng: np.random.Generator) -> np.ndarray:
    """Return smooth random curves ``(n, g)`` of sizes that are shares of ``size (n,)``."""
    size = size * np.exp(rng.uniform(*np.log(share), len(size)))
    rate, phase = rng.uniform(0.0, 1.0, (2, len(size), _TERMS, 1))
    curves = np.sin(2.0 * np.pi * (_FASTEST * rate * SHAPE_TIMES + phase)).sum(axis=1)
    return size[:, None] * np.clip(SHAPE_TIMES + 1.0, 0.0, 1.0) * curves  # 0 before the motion


@compiled()
def _sizes(before, after, length, unit):
    """Return the root mean square of changes in the units of the curves before, ``(n,)``."""
    sizes = np.empty(len(before))
    for r in range(len(before)):
        total = 0.0
        for i in range(before.shape[1]):
            place = (GRID[i] * unit[r] - GRID[0]) / (GRID[1] - GRID[0])
            j = min(max(int(place), 0), before.shape[1] - 2)
            x = min(max(place - j, 0.0), 1.0)
            height = (1.0 - x) * after[r, j] + x * after[r, j + 1]
            total += (length[r] * height - before[r, i]) ** 2
        sizes[r] = np.sqrt(total / before.shape[1])
    return sizes


def rows_of(
    kind: str, bank: xr.Dataset, like: TrainedNetwork | None = None, **drawn: Any
) -> BankRows:
    """Return rows of "levels" or "changes", in the scales of a network if it is given; ``drawn``
    replaces attributes for training.
    """
    rows = StateRows if kind == StateNetwork.kind else ChangeRows
    return rows(bank, vars(like) if like else {}, **drawn)


def sample_rows(
    network: TrainedNetwork, rows: BankRows, source: str, draws: int, rng: np.random.Generator
) -> xr.Dataset:
    """Draw from the posteriors of drives, with one record of one or both motions.

    Args:
        rows: Drives, in the scales of the network.
        source: "closing", "opening" or "both".

    Returns:
        ``draws (curve, draw, output)`` and ``truth (curve, output)``: parameters, or their changes
        in percent, and events, in durations. A jitter of a billionth of a scale gives exact zeros a
        random order. Changes beyond any wear are left out; ``withheld`` counts them.
    """
    logs, motions = len(NAMES), np.array([[source in (motion, "both") for motion in MOTIONS]])
    x, y, there, units = rows.unscaled(np.arange(len(rows)), rng, motions)
    known = there.any(axis=0)
    x, y, units = (values[(there == known).all(axis=1)] for values in (x, y, units))
    features = network.network.features(x)
    values = np.stack([network.sample(row[None], known, draws, rng)[0] for row in features])
    changes = isinstance(network, ChangeNetwork)
    kept = plausible_wear(values[..., :logs]) if changes else np.ones(len(values), dtype=bool)

    def physical(outputs: np.ndarray, units: np.ndarray) -> np.ndarray:
        jitter = 1e-9 * network.scale * rng.standard_normal(outputs.shape)
        outputs = outputs + units + np.array(network.atoms) * jitter
        head = outputs[..., :logs]
        outputs[..., :logs] = 100.0 * np.expm1(head) if changes else np.exp(head)
        return outputs[..., known]

    return xr.Dataset(
        {
            "draws": (("curve", "draw", "output"), physical(values[kept], units[kept][:, None])),
            "truth": (("curve", "output"), physical(y[kept], units[kept])),
        },
        {"output": np.array(network.outputs)[known]},
        {"withheld": int((~kept).sum())},
    )
