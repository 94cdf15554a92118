"""A bank of a family of drives, rows of it, and draws of networks for held-out drives."""

from collections.abc import Sequence
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import ClassVar, NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

from breaker.common.compiling import compiled
from breaker.common.zarr_store import open_store
from breaker.family.bank import GRID as TIMES
from breaker.family.bank import shapes
from breaker.family.inputs import Basis, change_inputs, state_inputs, units_of, without_onset
from breaker.family.networks import (
    EFFECTS,
    EVENTS,
    WEARING,
    ChangeNetwork,
    StateNetwork,
    change_outputs,
    effect_outputs,
    outputs_there,
    plausible_wear,
    state_outputs,
)
from breaker.family.rich_drive import CONTACTS, ELEMENTS
from breaker.family.shape import SHAPE_TIMES
from breaker.family.training_records import record_shapes
from breaker.model.parameters import FORCE, GAP, MOTIONS, NAMES
from breaker.paper.calibration import coverage, judge_ranks, ranks

_MOST = 8000
"""Drives that components are of."""

_CLEAN = (1e-6, 1.1e-6)
"""Noise as good as none, share of the stroke."""

_COMPONENTS = 64
_TOLD = 0.6  # share of the drives whose size is given
_STROKE = 10.0  # mm, to which the fall of the force refers
_WAY = 0.4  # of the stroke, made in a duration
_LEAST_SCALE = 1e-6  # scale of a mechanism that no drive has


@dataclass
class BankRows:
    """Drives of a bank, and records of them made anew for each batch.

    Attributes:
        bank: Drives: see ``bank.simulate_family``.
        frozen: What inputs and outputs are scaled by, as the networks have it: set by
            ``freeze``, or that of the training.
    """

    kind: ClassVar[str]
    """"levels" or "changes"."""
    atoms: ClassVar[tuple[bool, ...]]
    """Which outputs may be exactly 0."""
    names: ClassVar[tuple[str, ...]]
    """Of the outputs."""

    bank: xr.Dataset
    frozen: dict = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.curves = self.bank["shape"].values  # (drive, condition, motion, u), as stored
        self.theta = self.bank.parameters.values
        self.stroke = self.bank.stroke.values
        self.duration = self.bank.duration.values
        self.elements = self.bank.elements.values
        self.events = np.stack([self.bank.release.values, self.bank.switching.values], axis=-1)

    def __len__(self) -> int:
        return len(self.theta)

    @property
    def sizes(self) -> tuple[int, int]:
        """Numbers of inputs and outputs."""
        x, y, _ = self.rows(np.arange(1), np.random.default_rng(1))
        return x.shape[1], y.shape[1]

    def rows(self, drives: np.ndarray, rng: np.random.Generator) -> tuple[np.ndarray, ...]:
        """Return inputs ``(n, i)``, outputs ``(n, q)`` and which are there, of drives ``(n,)``."""
        x, y, there, _ = self.unscaled(drives, rng)
        return x, (y - self.frozen["centre"]) / self.frozen["scale"], there

    def physical(self, outputs: np.ndarray) -> np.ndarray:
        """Return outputs ``(..., q)`` with parameters in their units, or changes in percent."""
        found = outputs.copy()
        found[..., : len(NAMES)] = np.exp(found[..., : len(NAMES)])
        return found

    def _motions(self, n: int, rng: np.random.Generator) -> np.ndarray:
        """Which motions there are, ``(n, 2)`` of bool: closing, opening or both."""
        return np.array([[True, False], [False, True], [True, True]])[rng.integers(0, 3, n)]

    def _bases(self, drives: np.ndarray, rng: np.random.Generator) -> dict[str, Basis]:
        """Components of the shapes of drives."""
        found = {}
        for m, motion in enumerate(MOTIONS):
            seen, *_ = record_shapes(self._curves(drives, 0, m), rng, noise=_CLEAN)
            whole = seen.way[seen.present.mean(axis=1) > 0.9]
            found[motion] = Basis.of(whole, _COMPONENTS)
        return found

    def _usual(self) -> np.ndarray:
        sizes = [np.log(self.stroke[:, 0]), np.log(self.duration[:, 0])]
        return np.array([[each.mean(), each.std()] for each in sizes])

    def _mechanisms(
        self, drives: np.ndarray, condition: np.ndarray, elements: np.ndarray
    ) -> dict[str, np.ndarray]:
        """Sizes of mechanisms of drives in a condition, with the elements of that or another."""
        return _mechanism_sizes(
            self.theta[drives, condition],
            self.elements[drives, elements],
            self.bank.contact.values[drives],
            self.stroke[drives, condition],
            self.duration[drives, condition, MOTIONS.index("closing")],
        )

    def _curves(self, drives: np.ndarray, condition: np.ndarray | int, motion: int) -> np.ndarray:
        return shapes(self.curves[drives, condition, motion])


class StateRows(BankRows):
    """Records of one operation, and the state of the drive."""

    kind, names, atoms = "levels", (*NAMES, *EVENTS, *EFFECTS), StateNetwork.atoms

    def freeze(self, rng: np.random.Generator) -> None:
        """Set the scales."""
        drives = rng.permutation(len(self))[:_MOST]
        self.frozen = {"bases": self._bases(drives, rng), "usual": self._usual()}
        _, y, there, _ = self.unscaled(drives, rng)
        y = np.where(there, y, np.nan)
        centre, scale = np.nanmean(y, axis=0), np.nanstd(y, axis=0)
        first = len(NAMES) + len(EVENTS)
        centre[first:] = 0.0  # which is where a mechanism is that is not there
        scale[first:] = np.sqrt(np.nanmean(np.square(y[:, first:]), axis=0)) + _LEAST_SCALE
        self.frozen |= {"centre": centre, "scale": scale}

    def unscaled(
        self,
        drives: np.ndarray,
        rng: np.random.Generator,
        *,
        condition: np.ndarray | None = None,
        motions: np.ndarray | None = None,
        told: np.ndarray | None = None,
        **sensor,
    ) -> tuple[np.ndarray, ...]:
        """Return inputs, outputs before their scales, and which are there, of drives ``(n,)``.

        The last of four is what makes of each output the logarithm of a parameter in its unit.

        Args:
            condition: New 0 or worn 1, ``(n,)``; drawn if None, as are the ``motions`` that there
                are, ``(n, 2)``, and whether the size is ``told``, ``(n,)``.
            sensor: As for ``record_shapes``.
        """
        n = len(drives)
        condition = rng.integers(0, 2, n) if condition is None else condition
        motions = self._motions(n, rng) if motions is None else motions
        told = rng.random(n) < _TOLD if told is None else told
        records, events = self._records(drives, condition, motions, rng, **sensor)
        x = state_inputs(records, told, self.frozen["bases"], self.frozen["usual"])
        theta = self.theta[drives, condition]
        stroke, duration = units_of(records)
        sizes = self._mechanisms(drives, condition, condition)
        sizes = effect_outputs(sizes, duration)
        y = np.hstack([state_outputs(theta, events, stroke, duration), sizes])
        units = np.zeros_like(y)
        units[:, : len(NAMES)] = np.log(theta) - y[:, : len(NAMES)]
        motions = np.column_stack([each.there for each in records.values()])
        return x, y, outputs_there(motions) & motions.any(axis=1)[:, None], units

    def _records(self, drives, condition, motions, rng, **sensor):
        """Records in mm and ms by motion, and all events as they show them, ``(n, 4)``."""
        records, events = {}, []
        for m, motion in enumerate(MOTIONS):
            curves = self._curves(drives, condition, m)
            wanted = motions[:, m]
            seen, origin, duration = record_shapes(curves, rng, wanted=wanted, **sensor)
            unit = self.duration[drives, condition, m]
            stroke = self.stroke[drives, condition]
            records[motion] = seen._replace(stroke=seen.stroke * stroke, duration=duration * unit)
            found = self.events[drives, condition, m]
            events.append((found - origin[:, None]) / duration[:, None])
        events = np.hstack(events)
        return records, np.where(np.isfinite(events), events, SHAPE_TIMES[-1])


def _mechanism_sizes(
    theta: np.ndarray,
    elements: np.ndarray,
    contact: np.ndarray,
    stroke: np.ndarray,
    duration: np.ndarray,
) -> dict[str, np.ndarray]:
    """Return the size of each of ``EFFECTS``, ``(n,)``.

    Args:
        theta: Parameters, ``(n, p)``.
        elements: In the order of ``rich_drive.ELEMENTS``, ``(n, e)``.
        contact: Number of the kind of contact in ``rich_drive.CONTACTS``, ``(n,)``.
        stroke, duration: Of closings, ``(n,)``, mm and ms.
    """
    has = dict(zip(ELEMENTS, elements.T, strict=True)) | dict(zip(NAMES, theta.T, strict=True))
    slides, force = contact == CONTACTS.index("sliding"), has[FORCE.name]
    speed = _WAY * stroke / duration

    def damper(stop: str) -> np.ndarray:
        return has[f"{stop}.damping"] * speed ** has[f"{stop}.power"] / force

    sizes = {
        "contact_preload": np.where(slides, 0.0, has["contact_preload"] / force),
        "sliding_contact": np.where(slides, has[GAP.name] / stroke, 0.0),
        "build_up": has["build_up"],
        "dry_friction": has["dry_friction"] / force,
        "opening_preload": has["opening_preload"] / force,
        "force_fall": has["force_fall"] * stroke / _STROKE,
        "drag": has["drag"] * speed ** has["drag_power"] / force,
        "train_mass": has["train_mass"],
        "closing_damper": damper("closing_stop"),
        "opening_damper": damper("opening_stop"),
    }
    return {name: sizes[name] for name in EFFECTS}


_CHANGE_COMPONENTS = 40
_BACK = 0.2  # share of the changes that go from worn to new, as after maintenance
_NOISE = (1e-5, 1e-2)  # of a sample, share of the stroke: of means of many records down
_SAME = 1e-4  # durations, by which touch or separation may move and count as unchanged
_CHANGE = 0.03  # of the logarithm of a parameter, and of a mechanism over the closing force
_ODD = (0.005, 0.05, 3)  # shares of a change, and terms of curves that nobody explains
_FASTEST = 0.3  # periods of a term in a duration
_STEP = TIMES[1] - TIMES[0]
_fast = compiled()


class _Pairs(NamedTuple):
    """Drives ``(n,)``, each in two conditions: new 0 or worn 1, ``(n,)``."""

    drives: np.ndarray
    first: np.ndarray
    second: np.ndarray


class ChangeRows(BankRows):
    """Records of a drive in two conditions, and what has changed."""

    kind = "changes"
    names = (*NAMES, *(f"later {motion}" for motion in MOTIONS), *WEARING)
    atoms = ChangeNetwork.atoms

    def freeze(self, rng: np.random.Generator) -> None:
        """Set the scales."""
        drives = rng.permutation(len(self))[:_MOST]
        bases, usual = self._bases(drives, rng), self._usual()
        n, motions = len(drives), np.ones((len(drives), 2), dtype=bool)
        pairs = _Pairs(drives, np.zeros(n, dtype=int), np.ones(n, dtype=int))
        _, changes, _ = self._records(pairs, motions, rng, _CLEAN, odd=False)
        change_bases = {
            motion: Basis.of(each.way, _CHANGE_COMPONENTS)._replace(mean=np.zeros(SHAPE_TIMES.size))
            for motion, each in changes.items()
        }
        scale = np.full(len(self.names), _CHANGE)
        scales = {"centre": 0.0 * scale, "scale": scale}
        self.frozen = {"bases": bases, "change_bases": change_bases, "usual": usual} | scales

    def physical(self, outputs: np.ndarray) -> np.ndarray:
        """Return outputs ``(..., q)``, the changes of parameters in percent."""
        found = outputs.copy()
        found[..., : len(NAMES)] = 100.0 * np.expm1(found[..., : len(NAMES)])
        return found

    def unscaled(
        self,
        drives: np.ndarray,
        rng: np.random.Generator,
        *,
        motions: np.ndarray | None = None,
        noise: Sequence[float] = _NOISE,
        back: float = _BACK,
    ) -> tuple[np.ndarray, ...]:
        """Return inputs, outputs before their scales, and which are there, of drives ``(n,)``.

        The last of four is 0: changes have no unit.

        Args:
            motions: As of ``StateRows.unscaled``.
            noise: Range of the noise of a sample of records or means of them, share of the stroke.
            back: Share of the changes from worn to new.
        """
        n = len(drives)
        motions = self._motions(n, rng) if motions is None else motions
        before = (rng.random(n) < back).astype(int)
        pairs = _Pairs(drives, before, 1 - before)
        records, changes, y = self._records(pairs, motions, rng, noise)
        scales = (self.frozen[name] for name in ("bases", "change_bases", "usual"))
        x = change_inputs(records, changes, *scales)
        motions = np.column_stack([each.there for each in records.values()])
        some = motions.any(axis=1)[:, None]
        there = np.hstack([some.repeat(len(NAMES), 1), motions, some.repeat(len(WEARING), 1)])
        return x, y, there, np.zeros_like(y)

    def _records(self, pairs, motions, rng, noise, *, odd=True):
        """References in mm and ms, changes from them, and outputs, ``(n, q)``; ``odd`` adds changes
        of no drive of the family.
        """
        references, changes, moved = {}, {}, []
        drives, first, second = pairs
        order = first, second
        for m, motion in enumerate(MOTIONS):
            before, after = (self._curves(drives, each, m) for each in order)
            stroke = self.stroke[drives, first], self.stroke[drives, second]
            unit = self.duration[drives, first, m], self.duration[drives, second, m]
            seen, _, duration = record_shapes(before, rng, noise=noise, wanted=motions[:, m])
            seen = seen._replace(stroke=seen.stroke * stroke[0], duration=duration * unit[0])
            like = seen.stroke / stroke[1], seen.duration / unit[1]
            present, *_ = record_shapes(after, rng, noise=noise, like=like, wanted=seen.there)
            way, some = present.way, present.there
            if odd:
                both = (each[some] for each in (before, after))
                sizes = (tuple(one[some] for one in each) for each in (stroke, unit))
                way[some] += _odd(*both, *sizes, rng)
            seen = seen._replace(there=seen.there & present.there)
            there = seen.present & present.present
            both = np.hypot(seen.noise, present.noise)
            references[motion] = seen
            changes[motion] = present._replace(
                way=without_onset(seen.way, way, there), present=there, noise=both
            )
            takes = [
                np.diff(self.events[drives, each, m])[:, 0] * one
                for each, one in zip(order, unit, strict=True)
            ]
            late = np.where(first == second, 0.0, takes[1] - takes[0])
            late = np.where(np.isfinite(late), late, 0.0) / seen.duration
            moved.append(np.where(np.abs(late) < _SAME, 0.0, late))
        both = self.theta[drives, first], self.theta[drives, second]
        sizes = (self._mechanisms(drives, first, elements) for elements in order)
        was, by = next(sizes), next(sizes)
        worn = {name: by[name] - was[name] for name in WEARING}
        worn = effect_outputs(worn, units_of(references)[1])
        outputs = np.hstack([change_outputs(*both, np.array(moved).T), worn])
        return references, changes, outputs


def _odd(
    before: np.ndarray,
    after: np.ndarray,
    stroke: tuple[np.ndarray, np.ndarray],
    unit: tuple[np.ndarray, np.ndarray],
    rng: np.random.Generator,
) -> np.ndarray:
    """Smooth random curves, as large as shares of the change of curves ``(n, u)``, ``(n, g)``."""
    low, high, terms = _ODD
    size = _sizes(before, after, stroke[1] / stroke[0], unit[0] / unit[1])
    size *= np.exp(rng.uniform(np.log(low), np.log(high), len(size)))
    rate, phase = rng.uniform(0.0, 1.0, (2, len(size), terms, 1))
    curves = np.sin(2.0 * np.pi * (_FASTEST * rate * SHAPE_TIMES + phase)).sum(axis=1)
    return size[:, None] * np.clip(SHAPE_TIMES + 1.0, 0.0, 1.0) * curves  # none at the rest before


@_fast
def _sizes(before, after, length, unit):
    """Root mean square of a change in the units of what was before, ``(n,)``."""
    found = np.empty(len(before))
    for r in range(len(before)):
        total = 0.0
        for i in range(before.shape[1]):
            place = (TIMES[i] * unit[r] - TIMES[0]) / _STEP
            j = min(max(int(place), 0), before.shape[1] - 2)
            x = min(max(place - j, 0.0), 1.0)
            there = (1.0 - x) * after[r, j] + x * after[r, j + 1]
            total += (length[r] * there - before[r, i]) ** 2
        found[r] = np.sqrt(total / before.shape[1])
    return found


def rows_of(
    kind: str, bank: xr.Dataset, like: StateNetwork | ChangeNetwork | None = None
) -> BankRows:
    """Return rows of "levels" or "changes", scaled as those that a network was trained on."""
    frozen = {} if like is None else {each.name: getattr(like, each.name) for each in fields(like)}
    return {each.kind: each for each in (StateRows, ChangeRows)}[kind](bank, frozen)


def sample_rows(
    network: StateNetwork | ChangeNetwork,
    rows: BankRows,
    source: str,
    draws: int,
    rng: np.random.Generator,
    **sensor,
) -> xr.Dataset:
    """Draw from the posteriors of one record of each motion of each drive.

    Args:
        rows: Drives, in the scales of the network.
        source: Which motions there are: "closing", "opening" or "both".
        sensor: As of the ``unscaled`` of the rows.

    Returns:
        ``draws (curve, draw, output)`` and ``truth (curve, output)``: parameters, or their changes
        in percent, and events, in durations. What is exactly 0 has a random order, by a jitter of
        a billionth of a scale. Changes beyond any wear are left out; ``withheld`` counts them.
    """
    n = len(rows)
    motions = np.tile([source != "opening", source != "closing"], (n, 1))
    x, y, there, units = rows.unscaled(np.arange(n), rng, motions=motions, **sensor)
    told = there.any(axis=0)
    x, y, units = (each[(there == told).all(axis=1)] for each in (x, y, units))
    features = network.network.features(x)
    values = np.stack(
        [network.network.sample(each[None], told, draws, rng)[0] for each in features]
    )
    values = network.centre + network.scale * values
    kept = np.ones(len(values), dtype=bool)
    if rows.kind == "changes":
        kept = plausible_wear(values[..., : len(NAMES)])
    values, y, units = values[kept], y[kept], units[kept]

    def physical(outputs: np.ndarray, units: np.ndarray) -> np.ndarray:
        jitter = 1e-9 * network.scale * rng.standard_normal(outputs.shape)
        return rows.physical(outputs + units + np.array(rows.atoms) * jitter)[..., told]

    return xr.Dataset(
        {
            "draws": (("curve", "draw", "output"), physical(values, units[:, None])),
            "truth": (("curve", "output"), physical(y, units)),
        },
        {"output": np.array(rows.names)[told]},
        {"withheld": int((~kept).sum())},
    )


def open_family(shards: Sequence[str | Path], held_out: int) -> tuple[xr.Dataset, xr.Dataset]:
    """Read the shards of a bank, and set its last drives aside.

    Raises:
        ValueError: If that leaves no drives to train on.
    """
    bank = xr.concat([open_store(each) for each in shards], dim="drive", combine_attrs="override")
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
        data: What ``sample_rows`` returns.
        log: Whether parameters are judged by their logarithms.

    Returns:
        Columns ``output``, ``calibration_p`` and ``calibrated``, all outputs together at 99 %,
        ``coverage_90``, ``contraction`` (1 - mean square error of the posterior mean over the
        variance of the truth, nan where that does not vary), ``rms_error`` and ``half_width``, the
        median half width of 90 % intervals; both in the scale that an output is judged in.
    """
    draws, truth = data.draws.values.copy(), data.truth.values.copy()
    logs = log & np.isin(data.output.values, NAMES)
    for values in (draws, truth):
        values[..., logs] = np.log(values[..., logs])
    found = ranks(draws, truth)
    judged = judge_ranks(found, data.sizes["draw"], alpha=0.01)
    error = draws.mean(axis=1) - truth
    low, high = np.quantile(draws, [0.05, 0.95], axis=1)
    spread = truth.var(axis=0)
    spread[spread < 1e-12] = np.nan  # round-off of what does not vary
    return pd.DataFrame(
        {
            "output": data.output.values,
            "calibration_p": judged.p_values,
            "calibrated": ~judged.outside,
            "coverage_90": coverage(found, data.sizes["draw"], levels=[0.9])[0],
            "contraction": 1.0 - np.square(error).mean(axis=0) / spread,
            "rms_error": np.sqrt(np.square(error).mean(axis=0)),
            "half_width": np.median(high - low, axis=0) / 2.0,
        }
    )
