"""What a change in a drive's coordinates means: parameters by a network, measured quantities.

A network of changes sees the drive's curves as new, their change along the path, and how well both
are known. Measured quantities are linear in the coordinates.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Self

import numpy as np
from scipy.special import ndtri

from breaker.family.inputs import NormalisedRecords
from breaker.family.membership import Match, choose_family
from breaker.family.networks import ChangeNetwork, StateNetwork, plausible_wear
from breaker.model.limits import Limit
from breaker.model.parameters import NAMES
from breaker.prognosis.coordinates import Coordinates
from breaker.prognosis.series import Series

_BLOCK = 64  # changes that are read at once
_WAYS = 4  # ways of a path that are drawn apart


@dataclass(frozen=True, eq=False)
class Readout:
    """How changes of one drive are read.

    Attributes:
        series: Its records.
        coordinates: Theirs.
        levels, changes: Networks of the family it is of; None where it is of none.
        draws: Number of draws d.
        seed: Of their generator, the same for every change.
        theta: Draws of its parameters as new, ``(d, p)``; None of no family.
        matches: How its new curves fit the family, by motion.
    """

    series: Series
    coordinates: Coordinates
    levels: StateNetwork | None
    changes: ChangeNetwork | None
    draws: int
    seed: int
    theta: np.ndarray | None = None
    matches: Mapping[str, Match] = field(default_factory=dict)

    @classmethod
    def of(
        cls,
        series: Series,
        families: Sequence[tuple[StateNetwork, ChangeNetwork]],
        *,
        draws: int,
        seed: int,
        misfit_p_value: float,
    ) -> Self:
        """Return the readout of a drive by the family that its new curves fit, with at least a
        p-value.
        """
        drives = (
            cls(series, Coordinates.of(series, changes.change_bases), levels, changes, draws, seed)
            for levels, changes in families
        )
        found, matches, fits = choose_family(
            drives,
            lambda drive: [(m, drive.levels.match(m, seen)) for m, seen in drive.new().items()],
            misfit_p_value,
        )
        found = replace(found, matches=dict(matches))
        if not fits:
            return found.withheld()
        theta = found.levels.draw(found.new(), draws, np.random.default_rng(seed)).theta
        return replace(found, theta=theta)

    def new(self) -> dict[str, NormalisedRecords]:
        """Return the new curves, as networks see them, by motion."""
        return self.curves(*np.zeros((2, 1, self.size)))[0]

    def withheld(self) -> Self:
        """Return a readout without networks, which reads only what is measured."""
        return replace(self, levels=None, changes=None, theta=None)

    @property
    def family(self) -> str:
        """Name of the family; empty of none."""
        return self.changes.settings["family"] if self.changes else ""

    @property
    def size(self) -> int:
        """Number of coordinates."""
        return sum(self.coordinates.sizes) + len(self.coordinates.readings)

    def curves(
        self, change: np.ndarray, variance: np.ndarray, motions: Sequence[str] | None = None
    ) -> tuple[dict[str, NormalisedRecords], dict[str, NormalisedRecords]]:
        """Return new curves and their changes, as networks see them, by motion: all, or
        ``motions``.

        Args:
            change, variance: Of the coordinates, ``(n, k)``.
        """
        new, changed = {}, {}
        for motion in motions or self.coordinates.curves:
            curve, place = self.coordinates.curves[motion], self.coordinates.places(motion)
            records = self.series.motions[motion]
            mean = np.tile(curve.mean, (len(change), 1))
            new[motion] = records.seen(mean, curve.noise)
            noise = np.hypot(curve.input_noise(variance[:, place]), 1e-5)
            changed[motion] = records.seen(curve.change(change[:, place]), noise)
        return new, changed

    def parameters(
        self, change: np.ndarray, variance: np.ndarray, motions: Sequence[str] | None = None
    ) -> np.ndarray:
        """Return draws of the change of the parameters, ``(n, d, p)``, percent; arguments as
        ``curves``.

        The same random numbers for each change, so that probabilities along a path are smooth; nan
        where a change is larger than any wear of the family, or there is no family.
        """
        found = np.full((len(change), self.draws, len(NAMES)), np.nan)
        if self.changes is None:
            return found
        known = np.flatnonzero(np.isfinite(change).all(axis=1))
        for begin in range(0, known.size, _BLOCK):
            some = known[begin : begin + _BLOCK]
            seen = self.curves(change[some], variance[some], motions)
            rng = np.random.default_rng(self.seed)
            logs, _ = self.changes.draw(*seen, self.draws, rng, effects=False)
            found[some] = np.where(
                plausible_wear(logs)[:, None, None], 100.0 * np.expm1(logs), np.nan
            )
        return found

    def ways(self) -> list[tuple[Self, np.ndarray]]:
        """Return readouts that share the draws, and where on its way each is, in sds, ``(k,)``: for
        each coordinate shuffled quantiles of a normal.
        """
        normal, rng = ndtri((np.arange(_WAYS) + 0.5) / _WAYS), np.random.default_rng(self.seed)
        ways = rng.permuted(np.tile((normal / normal.std())[:, None], self.size), axis=0)
        found = []
        for k in range(_WAYS):
            theta = None if self.theta is None else self.theta[k::_WAYS]
            draws = len(range(k, self.draws, _WAYS))
            found.append((replace(self, draws=draws, theta=theta, seed=self.seed + k), ways[k]))
        return found


@dataclass(frozen=True, eq=False)
class Condition:
    """A drive in some conditions, as limits read it: draws of quantities, ``(n, d, parts)``; nan
    where a quantity is not known. ``Limit.read`` calls the method of the limit's source.

    Attributes:
        readout: Of the drive.
        change, variance: Of the coordinates, ``(n, k)``.
    """

    readout: Readout
    change: np.ndarray
    variance: np.ndarray

    @cached_property
    def parameters(self) -> np.ndarray:
        """Draws of the change of the parameters, one network's for all limits."""
        return self.readout.parameters(self.change, self.variance)

    def of_change(self, limit: Limit) -> np.ndarray:
        """Return draws of changes of parameters."""
        return self.parameters[..., [NAMES.index(name) for name in limit.quantities]]

    def of_model(self, limit: Limit) -> np.ndarray:
        """Return draws of quantities of the model."""
        draws, new = self.parameters, self.readout.theta
        if new is None:
            return np.full((*draws.shape[:2], len(limit.quantities)), np.nan)
        theta = (new * (1.0 + draws / 100.0)).reshape(-1, len(NAMES))
        known = np.isfinite(theta).all(axis=1)
        found = np.full((len(theta), len(limit.quantities)), np.nan)
        # What a drive does not have any more is beyond any limit.
        found[known] = np.nan_to_num(limit.evaluate(theta[known]), nan=np.inf)
        signs = np.where([upper for *_, upper in limit.parts], 1.0, -1.0)
        return np.where(np.isinf(found), signs * np.inf, found).reshape(*draws.shape[:2], -1)

    def of_record(self, limit: Limit) -> np.ndarray:
        """Return draws of what records show: shuffled quantiles of a normal, alike for each change,
        as a draw is a drive, followed along its path, whose readings share an error.
        """
        draws = self.readout.draws
        found = np.full((len(self.change), draws, len(limit.quantities)), np.nan)
        normal = ndtri((np.arange(draws) + 0.5) / draws)
        rng = np.random.default_rng(self.readout.seed)
        for k, name in enumerate(limit.quantities):
            if known := self.readout.coordinates.reading(limit.motion, name):
                reading, place = known
                mean = reading.mean + reading.scatter * self.change[:, place, None]
                sd = reading.scatter * np.sqrt(self.variance[:, place, None])
                found[..., k] = mean + sd * rng.permutation(normal)
                found[..., k] += reading.common * rng.permutation(normal)
        return found
