"""Rows of a family's bank for networks of changes: records of a drive in two conditions."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from breaker.common.compiling import compiled
from breaker.family.change_network import Changes, change_outputs
from breaker.family.family_bank import GRID as TIMES
from breaker.family.family_records import record_shapes
from breaker.family.level_rows import CLEAN, MOST, BankRows
from breaker.family.mechanisms import WEARING, mechanism_outputs
from breaker.family.network_inputs import Basis, change_inputs, units_of, without_onset
from breaker.family.normalised_shape import SHAPE_TIMES
from breaker.model.parameters import MOTIONS, NAMES

_COMPONENTS = 40
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
    atoms = Changes.atoms

    def freeze(self, rng: np.random.Generator) -> None:
        """Set the scales."""
        drives = rng.permutation(len(self))[:MOST]
        bases, usual = self._bases(drives, rng), self._usual()
        n, motions = len(drives), np.ones((len(drives), 2), dtype=bool)
        pairs = _Pairs(drives, np.zeros(n, dtype=int), np.ones(n, dtype=int))
        _, changes, _ = self._records(pairs, motions, rng, CLEAN, odd=False)
        change_bases = {
            motion: Basis.of(each.way, _COMPONENTS)._replace(mean=np.zeros(SHAPE_TIMES.size))
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
            motions: As of ``LevelRows.unscaled``.
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
        worn = mechanism_outputs(worn, units_of(references)[1])
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
