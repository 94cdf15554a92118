r"""Two visits to one drive, a few records each: their joint density, the drive's own error shared.

A record of visit v is ``curve(z_v + e) + delta + errors``. All that the records share counts once:

- The parameters of a visit are those of all its records, of closing and opening alike. Operations
  scatter about them by ``e``, 0.4 % of each parameter.
- ``delta``, what the model leaves out of this drive, is that of both visits, ``xi factor`` with the
  components of ``model.Discrepancy``, and moves along with the onset of a record. It has changed by
  a share of its size, ``delta_today = delta + s xi' factor``; s is 0.03, 0.1 or 0.3, each as
  probable. In drives of the family that wear over a life it is 0.3.
- The change of the natural logarithm of each parameter is a priori Cauchy about 0: below 2 % in
  half of all drives, beyond 5 % in a quarter, beyond 20 % in 6 %, either way. So a change that
  records do not tell stays as probable as that.

The unknowns are the standardised parameters of the first visit and, in place of the changes, the
standard normal numbers u of the same probabilities, ``change = 0.02 tan(pi (Phi(u) - 1/2))``. Their
density is exact in both. Scatter and error are linear and integrated; the onset of each record is
integrated by Laplace's method, about its place as it moves with the parameters.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.special import ndtr

from breaker.mechanism import NAMES
from breaker.model import Model, Prior, linearise

__all__ = ["SHARES", "Design", "Look", "Visits", "add", "change_of", "prior_beyond"]

SHARES = np.array([0.03, 0.1, 0.3])
"""Of the drive's own error, by which it may have changed from visit to visit."""

_P = len(NAMES)
_CHANGE = 0.02  # of the logarithm of a parameter: half of all changes are smaller
_BEYOND = 8.0  # of u: no prior supports such a change
_SCATTER = 0.004  # sd of the logarithm of a parameter between operations, as of the rigs


def prior_beyond(share: float) -> float:
    """Return how probable a change of a parameter beyond a share is a priori, up or down.

    >>> round(prior_beyond(0.05), 2)
    0.24
    """
    more, less = np.arctan(np.abs(np.log1p([share, -share])) / _CHANGE) / np.pi
    return float(1.0 - more - less)


class Design(NamedTuple):
    """Records of a motion, linear in the unknowns about a place.

    Attributes:
        model: Joint model of the motion.
        left: What is left of the records there, whitened, ``(r, t)``.
        slopes: What the unknowns of each record add to it, whitened, ``(r, k, t)``.
        columns: Numbers of these unknowns among all, ``(r, k)``.
        late: Mean, slopes and components of the error as they are in each record, which begins late
            by its onset, ``(r, 1 + p + c, t)``, mm.
    """

    model: Model
    left: np.ndarray
    slopes: np.ndarray
    columns: np.ndarray
    late: np.ndarray

    @property
    def gains(self) -> np.ndarray:
        """Information of each record about its unknowns, ``(r, k, k)``."""
        return self.slopes @ self.slopes.swapaxes(1, 2)


class Look(NamedTuple):
    """The log density of all unknowns near a place, a parabola.

    Attributes:
        precision, uphill: Curvature ``(m, m)``, without second derivatives of the curves, and
            slope ``(m,)``.
        depth: Minus its value, but for a constant; ``inf`` outside the prior's support.
        misfit: Squares that are left of the records and of what is not a parameter.
    """

    precision: np.ndarray
    uphill: np.ndarray
    depth: float
    misfit: float


@dataclass(frozen=True, eq=False)
class Visits:
    """Records of two visits to one drive.

    All unknowns are a vector ``(m,)``: parameters of the first visit and u, ``2 p``; then for each
    motion the components of the error, those of its change, and of each record the onset, where it
    is inferred, and the scatter. All but the parameters are standard normal a priori.

    Attributes:
        models: Joint model of each motion.
        records: Records of each, ``(r, t)``, mm; NaN where a sample is missing.
        today: Which of them are of the second visit, ``(r,)`` of bool.
    """

    models: Mapping[str, Model]
    records: Mapping[str, np.ndarray]
    today: Mapping[str, np.ndarray]

    @cached_property
    def prior(self) -> Prior:
        """Prior of the parameters of a visit."""
        return next(iter(self.models.values())).prior

    @cached_property
    def components(self) -> dict[str, int]:
        """Number of components of the error of each motion, c."""
        found = {motion: each.sensor.discrepancy for motion, each in self.models.items()}
        return {motion: 0 if each is None else len(each.factor) for motion, each in found.items()}

    @cached_property
    def columns(self) -> dict[str, np.ndarray]:
        """Numbers of the unknowns of each record, by motion, ``(r, 2 p + 2 c + o + p)``."""
        found, first = {}, 2 * _P
        for motion, records in self.records.items():
            both, own = 2 * self.components[motion], self.models[motion].sensor.infers_onset + _P
            shared = [*range(2 * _P), *range(first, first + both)]
            apart = first + both + np.arange(own * len(records)).reshape(-1, own)
            found[motion] = np.column_stack([np.tile(shared, (len(records), 1)), apart])
            first += both + apart.size
        return found

    @property
    def size(self) -> int:
        """Number of unknowns, m."""
        return 1 + int(max(each.max() for each in self.columns.values()))

    def parameters(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return standardised parameters of both visits, ``(..., 2 p) -> (..., p)`` each."""
        before = x[..., :_P]
        return before, before + change_of(x[..., _P : 2 * _P])[0] / self.prior.log_sds

    def log_prior(self, x: np.ndarray) -> np.ndarray:
        """Return the log density of parameters and u, ``(n, 2 p) -> (n,)``, but for a constant.

        It is ``-inf`` where a visit is outside the prior's support or cannot be simulated.
        """
        found = 0.0
        for model in self.models.values():
            rest = np.zeros((len(x), len(model.outputs) - _P))
            first, second = (
                model.log_prior(np.column_stack([each, rest])) for each in self.parameters(x)
            )
            found = np.where(np.isfinite(second) & np.isfinite(found), first, -np.inf)
        return found - 0.5 * np.square(x[:, _P:]).sum(axis=1)

    def look(self, y: np.ndarray) -> Look:
        """Return the log density of all unknowns ``(m,)`` near a place.

        The change of the error is as large as it may be.
        """
        precision, uphill = np.eye(len(y)), -y
        precision[:_P, :_P] = self.prior.precision
        uphill[:_P] = -self.prior.precision @ y[:_P]
        if not np.isfinite(self.log_prior(y[None, : 2 * _P])[0]):
            return Look(precision, uphill, np.inf, np.inf)
        depth, misfit = -y @ uphill, float(np.square(y[2 * _P :]).sum())
        for design in self.designs(y):
            squares = float(np.square(design.left).sum())
            depth, misfit = depth + squares, misfit + squares
            add(precision, uphill, design, design.left)
        return Look(precision, uphill, 0.5 * depth, misfit)

    def designs(self, y: np.ndarray) -> Iterator[Design]:
        """Yield the records of each motion, linear about unknowns ``(m,)``."""
        before, after = self.parameters(y[: 2 * _P])
        stretch = change_of(y[_P : 2 * _P])[1] / self.prior.log_sds
        for motion, model in self.models.items():
            records, today, c = self.records[motion], self.today[motion], self.components[motion]
            own = y[self.columns[motion][:, 2 * _P :]]
            error, change, onset, scatter = np.split(own, [c, 2 * c, own.shape[1] - _P], axis=1)
            scale = _SCATTER / self.prior.log_sds
            z = np.where(today[:, None], after, before) + scale * scatter
            bare, worn = model.leaving_out(None), SHARES[-1] * today[:, None]
            curves, slopes = linearise(bare, np.column_stack([z, onset]), records=records)
            late = _late(model, onset)
            amounts = np.column_stack([np.ones(len(z)), z, error + worn * change])
            left = records - curves - np.einsum("rk,rkt->rt", amounts, late)
            there = np.where(np.isnan(records)[:, None], np.nan, late)
            of_error = bare.sensor.whiten(there)
            by_z, basis = slopes[:, :_P] + of_error[:, 1 : 1 + _P], of_error[:, 1 + _P :]
            parts = [by_z, today[:, None, None] * stretch[:, None] * by_z]
            parts += [basis, worn[:, None] * basis, slopes[:, _P:], scale[:, None] * by_z]
            whole = np.concatenate(parts, axis=1)
            yield Design(model, bare.sensor.whiten(left), whole, self.columns[motion], late)


def add(precision: np.ndarray, uphill: np.ndarray, design: Design, left: np.ndarray) -> None:
    """Add what records say, and leave, to curvature and slope of all unknowns."""
    along = (design.slopes @ left[..., None])[..., 0]
    for columns, gain, toward in zip(design.columns, design.gains, along, strict=True):
        precision[np.ix_(columns, columns)] += gain
        uphill[columns] += toward


def _late(model: Model, onset: np.ndarray) -> np.ndarray:
    """Mean, slopes and components of the error in records with onsets ``(r, 0 or 1)``.

    Returns:
        ``(r, 1 + p + c, t)``, mm: it moves along with the motion.
    """
    sensor, left_out = model.sensor, model.sensor.discrepancy
    if left_out is None:
        return np.zeros((len(onset), 1 + _P, sensor.samples))
    rows = np.vstack([left_out.mean, left_out.slopes, left_out.factor])
    times = sensor.times - sensor.onset_sd * onset.sum(axis=1)[:, None]
    return np.array([[np.interp(at, sensor.times, row) for row in rows] for at in times])


def change_of(u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the change of a logarithm for standard normal numbers, and its derivative."""
    u = np.clip(u, -_BEYOND, _BEYOND)
    share = np.pi * ndtr(-np.abs(u))  # never near pi, so exact in the tails
    slope = np.pi * np.exp(-0.5 * np.square(u)) / np.sqrt(2 * np.pi) / np.square(np.sin(share))
    return _CHANGE * np.sign(u) / np.tan(share), _CHANGE * slope
