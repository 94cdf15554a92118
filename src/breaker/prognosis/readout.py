"""Readout of a change in a drive's coordinates: parameters by a network, measured quantities.

Inputs of a change network are the drive's curves as new, their change along the path, and the noise
of both. Measured quantities are linear in the coordinates.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import starmap
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
_WAYS = 4  # directions of a path that are drawn separately


@dataclass(frozen=True, eq=False)
class Readout:
    """A drive in n conditions, for ``Limit.read``: methods ``of_...`` return draws of quantities by
    their source, ``(n, d, parts)``, nan where unknown.

    Attributes:
        series, coordinates: Records of the drive, and their coordinates.
        network: Change network of its family; None outside all families.
        draws, seed: Number d of draws, and seed of their generator, the same for every change.
        change, variance: Mean and variance of the change of coordinates since new, ``(n, k)``.
        theta: Draws of the parameters as new, ``(d, p)``; None outside all families.
        matches: Match of the new curves with the family, by motion.
    """

    series: Series
    coordinates: Coordinates
    network: ChangeNetwork | None
    draws: int
    seed: int
    change: np.ndarray
    variance: np.ndarray
    theta: np.ndarray | None = None
    matches: Mapping[str, Match] = field(default_factory=dict)

    @classmethod
    def of(
        cls, series: Series, families: Iterable, *, draws: int, seed: int, misfit_p_value: float
    ) -> Self:
        """Return a drive as new, in the family that its curves fit with at least a p-value;
        ``families`` are state networks, each with its change network.
        """

        def as_new(levels: StateNetwork, network: ChangeNetwork) -> tuple[StateNetwork, Self]:
            coordinates = Coordinates.of(series, network.change_bases)
            zero = np.zeros((1, coordinates.size))
            return levels, cls(series, coordinates, network, draws, seed, zero, zero + 1e-12)

        (levels, as_new_readout), matches, fits = choose_family(
            starmap(as_new, families),
            lambda pair: [(m, pair[0].match(m, seen)) for m, seen in pair[1].curves()[0].items()],
            misfit_p_value,
        )
        as_new_readout = replace(as_new_readout, matches=dict(matches))
        if not fits:
            return replace(as_new_readout, network=None)
        theta = levels.draw(as_new_readout.curves()[0], draws, np.random.default_rng(seed)).theta
        return replace(as_new_readout, theta=theta)

    def at(self, change: np.ndarray, variance: np.ndarray) -> Self:
        """Return the drive at conditions, ``(..., k)``, one after the other."""
        both = np.broadcast_arrays(change, np.maximum(variance, 1e-12))
        change, variance = (array.reshape(-1, self.coordinates.size) for array in both)
        return replace(self, change=change, variance=variance)

    def curves(
        self, part: slice = slice(None), motions: Sequence[str] = ()
    ) -> tuple[dict[str, NormalisedRecords], dict[str, NormalisedRecords]]:
        """Return new curves and their changes in some conditions, for networks, by motion: of all
        motions, or of ``motions``.
        """
        new, changed = {}, {}
        for motion in motions or self.coordinates.curves:
            curve, place = self.coordinates.curves[motion], self.coordinates.places[motion]
            change, records = self.change[part, place], self.series.motions[motion]
            new[motion] = records.seen(np.tile(curve.mean, (len(change), 1)), curve.noise)
            noise = np.hypot(curve.input_noise(self.variance[part, place]), 1e-5)
            changed[motion] = records.seen(change @ curve.back @ curve.basis, noise)
        return new, changed

    def drawn(self, motions: Sequence[str] = ()) -> np.ndarray:
        """Return draws of the change of the parameters, ``(n, d, p)``, percent, from all motions or
        ``motions``. Random numbers are the same for each change, so that probabilities along a path
        are smooth. Changes beyond any wear of the family, or outside all families, are nan.
        """
        theta_drawn = np.full((len(self.change), self.draws, len(NAMES)), np.nan)
        for begin in range(0, len(theta_drawn) if self.network else 0, _BLOCK):
            part = slice(begin, begin + _BLOCK)
            rng = np.random.default_rng(self.seed)
            seen = self.curves(part, motions)
            logs, _ = self.network.draw(*seen, self.draws, rng, effects=False)
            plausible = plausible_wear(logs)[:, None, None]
            theta_drawn[part] = np.where(plausible, 100.0 * np.expm1(logs), np.nan)
        return theta_drawn

    @cached_property
    def parameters(self) -> np.ndarray:
        """Result of ``drawn``, computed once for all limits."""
        return self.drawn()

    def ways(self) -> list[tuple[Self, np.ndarray]]:
        """Return readouts that share the draws, and the deviation of each from the path, in sds,
        ``(k,)``: shuffled quantiles of a normal for each coordinate.
        """
        normal, rng = ndtri((np.arange(_WAYS) + 0.5) / _WAYS), np.random.default_rng(self.seed)
        off = np.tile((normal / normal.std())[:, None], self.coordinates.size)
        rows = []
        for k, deviation in enumerate(rng.permuted(off, axis=0)):
            theta = None if self.theta is None else self.theta[k::_WAYS]
            draws = len(range(k, self.draws, _WAYS))
            rows.append((replace(self, draws=draws, theta=theta, seed=self.seed + k), deviation))
        return rows

    def of_change(self, limit: Limit) -> np.ndarray:
        """Return draws of changes of parameters."""
        return self.parameters[..., [NAMES.index(name) for name in limit.quantities]]

    def of_model(self, limit: Limit) -> np.ndarray:
        """Return draws of quantities of the model."""
        shape = *self.parameters.shape[:2], len(limit.quantities)
        if self.theta is None:
            return np.full(shape, np.nan)
        theta = (self.theta * (1.0 + self.parameters / 100.0)).reshape(-1, len(NAMES))
        known, predicted = np.isfinite(theta).all(axis=1), np.full((len(theta), shape[-1]), np.nan)
        # A quantity without a value, which the drive no longer has, exceeds any limit.
        predicted[known] = np.nan_to_num(limit.evaluate(theta[known]), nan=np.inf)
        signs = np.where([upper for *_, upper in limit.parts], 1.0, -1.0)
        return np.where(np.isinf(predicted), signs * np.inf, predicted).reshape(shape)

    def of_record(self, limit: Limit) -> np.ndarray:
        """Return draws of measured quantities: shuffled quantiles of a normal, the same for each
        change. A draw is a drive along its path, with a common error of its readings.
        """
        read = np.full((len(self.change), self.draws, len(limit.quantities)), np.nan)
        normal = ndtri((np.arange(self.draws) + 0.5) / self.draws)
        rng = np.random.default_rng(self.seed)
        for k, key in enumerate((limit.motion, name) for name in limit.quantities):
            if reading := self.coordinates.readings.get(key):
                place = self.coordinates.places[key]
                mean = reading.mean + reading.scatter * self.change[:, place]
                sd = reading.scatter * np.sqrt(self.variance[:, place])
                read[..., k] = mean + sd * rng.permutation(normal)
                read[..., k] += reading.common * rng.permutation(normal)
        return read
