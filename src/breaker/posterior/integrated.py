"""Density of the parameters at two visits, with all else of ``visits`` integrated.

Error and scatter are linear, so their integral is exact; an onset follows the parameters, and is
integrated about there by Laplace's method.
"""

import numpy as np
from scipy.special import logsumexp

from breaker.mechanism import NAMES, travel
from breaker.posterior.visits import SHARES, Design, Visits, add, change_of

__all__ = ["Density"]

_P = len(NAMES)
_ROWS = 200  # draws that are weighed at once: some MB


class Density:
    """Density of the parameters of both visits, with all else integrated.

    Args:
        y: Mode of all unknowns, ``(m,)``.
        precision: The curvature there: see ``Look``.
    """

    def __init__(self, visits: Visits, y: np.ndarray, precision: np.ndarray) -> None:
        self.visits, self._designs = visits, list(visits.designs(y))
        rest = slice(2 * _P, None)
        # Where all else is most probable, given parameters of both visits.
        stretch = np.append(np.ones(_P), change_of(y[_P : 2 * _P])[1] / visits.prior.log_sds)
        back = np.eye(2 * _P)
        back[_P:, :_P] = -np.eye(_P)
        along = -np.linalg.solve(precision[rest, rest], precision[rest, : 2 * _P])
        self._follows = (along / stretch) @ back
        self._place, self._rest = np.concatenate(visits.parameters(y[: 2 * _P])), y[rest]
        curvature, nothing = np.zeros((len(y), len(y))), np.zeros(len(y))
        for design in self._designs:
            add(curvature, nothing, design, np.zeros_like(design.left))
        self._inverse, self._half_log = [], []
        # Contiguous, as products of matrices are fast.
        self._slopes = [
            np.ascontiguousarray(each.slopes[:, 2 * _P :].swapaxes(1, 2)) for each in self._designs
        ]
        for share in SHARES:
            scales = self._scales(share)
            matrix = curvature[rest, rest] * np.outer(scales, scales) + np.eye(len(scales))
            self._inverse.append(np.linalg.inv(matrix))
            self._half_log.append(0.5 * np.linalg.slogdet(matrix)[1])

    def _scales(self, share: float) -> np.ndarray:
        """Sizes of all that is integrated at a share, over those at the largest, ``(m - 2 p,)``."""
        scales = np.ones(self.visits.size)
        for motion, columns in self.visits.columns.items():
            c = self.visits.components[motion]
            scales[columns[0, 2 * _P + c : 2 * _P + 2 * c]] = share / SHARES[-1]
        return scales[2 * _P :]

    def log_joint(self, x: np.ndarray) -> np.ndarray:
        """Return the log density of parameters and u, ``(n, 2 p) -> (n,)``, but for a constant."""
        result = self.visits.log_prior(x)
        inside = np.flatnonzero(np.isfinite(result))
        for rows in np.array_split(inside, len(inside) // _ROWS + 1):
            result[rows] += self._log_likelihood(x[rows])
        return result

    def _log_likelihood(self, x: np.ndarray) -> np.ndarray:
        both = np.array(self.visits.parameters(x))
        moved = np.concatenate(both, axis=1) - self._place
        expected = self._rest + moved @ self._follows.T
        along, squares = np.zeros_like(expected), np.zeros(len(x))
        for design, slopes in zip(self._designs, self._slopes, strict=True):
            model, today = design.model, self.visits.today[design.model.motion]
            sensor, columns = model.sensor.noise_and_zero, design.columns[:, 2 * _P :] - 2 * _P
            z = both[today.astype(int)]  # (r, n, p)
            onset = np.zeros(z.shape[:2])
            if sensor.infers_onset:
                onset = expected[:, columns[:, -_P - 1]].T
            left = self._left(design, z, onset)
            squares += np.square(left).sum(axis=(0, 2)) + np.square(onset).sum(axis=0)
            found = left @ slopes
            if sensor.infers_onset:
                found[:, :, -_P - 1] -= onset
            for place, one in zip(columns, found, strict=True):
                along[:, place] += one
        return self._integrated(along, squares)

    def _left(self, design: Design, z: np.ndarray, onset: np.ndarray) -> np.ndarray:
        """What parameters ``(r, n, p)`` and onsets ``(r, n)`` leave of records, ``(r, n, t)``."""
        model, records = design.model, self.visits.records[design.model.motion]
        sensor = model.sensor.noise_and_zero
        theta = model.prior.destandardise(z).reshape(-1, _P)
        late = sensor.onset_sd * onset.ravel()
        curves = travel(theta, sensor.times, model.motion, onset=late).travel
        curves = curves.reshape(*onset.shape, -1)
        shift = design.late[:, :1] + z @ design.late[:, 1 : 1 + _P]
        return sensor.whiten(records[:, None] - curves - shift)

    def _integrated(self, along: np.ndarray, squares: np.ndarray) -> np.ndarray:
        """Integrate what is linear, and the share by which the error has changed."""
        found = []
        for share, inverse, half_log in zip(SHARES, self._inverse, self._half_log, strict=True):
            scaled = along * self._scales(share)
            explained = ((scaled @ inverse) * scaled).sum(axis=1)
            found.append(0.5 * (explained - squares) - half_log)
        return logsumexp(found, axis=0) - np.log(len(SHARES))
