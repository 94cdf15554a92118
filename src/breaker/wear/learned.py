"""What was learned of the difference of drives from the model, for the motions of a source."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import xarray as xr
from scipy.linalg import block_diag, eigh

from breaker.mechanism import NAMES
from breaker.model import Discrepancy, Model, information
from breaker.records import main_motion

__all__ = ["PHASES", "Learned", "by_phase", "phases"]

PHASES = ("start", "main motion", "end")
"""Phases of a motion in which a difference is sized."""

_START = 0.15  # share of the way between the rest positions that is the start of a motion
_SCALES = np.geomspace(0.01, 1.0, 9)  # sizes of steps, of the largest
_KNOWN = 1e-9  # share of the information, below which nothing is known of a direction
_UNWORN = 0.05  # prior sd, by which a parameter that no drive of the family wears may change


@dataclass(frozen=True, eq=False)
class Learned:
    """What was learned of the difference of drives, for the motions of a source.

    Attributes:
        basis: Curves of each motion, ``(c, t)``, mm.
        mean_of: Mean and slopes of each motion, the ``Discrepancy`` without components.
        new: Covariance of the difference in new condition, all motions, ``(n, n)``.
        wear: Second moment of the changes of parameters and difference in a life of usual wear,
            ``(p + n, p + n)``.
        rough: Variance of what the components leave out over that of a sample's noise: it is the
            same in all records, so nothing is known better than from ``1 / rough`` of them.
    """

    basis: Mapping[str, np.ndarray]
    mean_of: Mapping[str, Discrepancy]
    new: np.ndarray
    wear: np.ndarray
    rough: float

    @classmethod
    def from_dataset(
        cls,
        data: xr.Dataset,
        motions: Sequence[str],
        scale: float,
        *,
        rough_sd: float,
        noise_sd: float,
    ) -> "Learned":
        """Build from ``results/discrepancy.zarr`` at a scale.

        Args:
            data: That store.
            scale: Scale of the difference.
            rough_sd: Standard deviation of what its components leave out, mm.
            noise_sd: That of a sample's noise, mm.
        """
        p, c = len(NAMES), data.sizes["component"]
        every = [str(each) for each in data.motion.values]
        place = np.concatenate([np.arange(c) + c * every.index(motion) for motion in motions])
        cov, n = data.covariance.values, c * len(every)
        worn = np.concatenate([np.arange(p), p + n + place])
        units = np.where(np.arange(len(worn)) < p, 1.0, scale)
        wear = cov[np.ix_(worn, worn)] * np.outer(units, units)
        wear[np.arange(p), np.arange(p)] += np.square(_UNWORN)
        whole = {motion: Discrepancy.from_dataset(data.sel(motion=motion)) for motion in motions}
        # The components are unknowns of their own here, and no contact is timed.
        alone = {
            m: replace(each.scaled(scale), factor=np.zeros((0, len(each.mean))), lag=None)
            for m, each in whole.items()
        }
        return cls(
            {motion: data.basis.sel(motion=motion).values for motion in motions},
            alone,
            scale**2 * cov[np.ix_(p + place, p + place)],
            wear,
            np.square(scale * rough_sd / noise_sd),
        )

    def models(self, models: Mapping[str, Model], difference: np.ndarray) -> dict[str, Model]:
        """Return models that leave out a known difference ``(n,)``, and nothing else."""
        known = {}
        for motion, part in self.parts(difference).items():
            mean = self.mean_of[motion]
            left_out = replace(mean, mean=mean.mean + part @ self.basis[motion])
            known[motion] = models[motion].leaving_out(left_out)
        return known

    def parts(self, difference: np.ndarray) -> dict[str, np.ndarray]:
        """Split a difference ``(..., n)`` into those of its motions, ``(..., c)``."""
        shares = np.split(difference, len(self.basis), axis=-1)
        return dict(zip(self.basis, shares, strict=True))

    def information(
        self,
        known: Mapping[str, Model],
        records: Mapping[str, np.ndarray],
        centre: np.ndarray,
        onsets: Mapping[str, np.ndarray],
        *,
        steps: int,
    ) -> tuple[np.ndarray, np.ndarray, dict[str, np.ndarray]]:
        """Return the information of records about parameters and difference.

        Args:
            known: What ``models`` returns.
            records: Records of one or all motions, ``(o, t)``, mm.
            centre: Standardised parameters where it is taken, ``(o, p)``.
            onsets: Standardised onsets of each motion to start from, ``(o,)``.
            steps: Gauss-Newton steps of the onsets.

        Returns:
            Matrix ``(o, p + n, p + n)`` and slope ``(o, p + n)``, about ``centre`` and the known
            difference, and the onsets.
        """
        p, c = len(NAMES), len(self.new) // len(self.basis)
        size = p + len(self.new)
        matrix, slope = np.zeros((len(centre), size, size)), np.zeros((len(centre), size))
        found = {}
        for k, (motion, basis) in enumerate(self.basis.items()):
            if motion not in records:
                continue
            model, onset = known[motion], onsets[motion]
            one = information(model, records[motion], centre, onset, steps=steps, basis=basis)
            if model.sensor.infers_onset:
                aligned = records[motion] - _late(model, centre, one.onset)
                one = information(model, aligned, centre, one.onset, steps=1, basis=basis)
            place = np.concatenate([np.arange(p), p + k * c + np.arange(c)])
            matrix[:, place[:, None], place] += one.matrix
            slope[:, place] += one.slope
            found[motion] = one.onset
        return matrix, slope, found

    def step_sizes(
        self,
        known: Mapping[str, Model],
        centre: np.ndarray,
        matrix: np.ndarray,
        change: np.ndarray,
        step_sd: float,
        *,
        variance: float,
    ) -> np.ndarray:
        """Return how much a step changes the curve of each motion in each of its ``PHASES``.

        A step can be far smaller than drives differ, so its size is estimated with it.

        Args:
            known: What ``models`` returns.
            centre, matrix: Of the ``Reference``: where the trend started, and the information of
                one record there.
            change: Change of what an operation says of parameters and difference, ``(p + n,)``.
            step_sd: Largest sd of the step of a parameter, share of it.
            variance: Variance of the noise of ``change``, over that of one operation.

        Returns:
            Root mean squares, mm, ``(motions * 3,)``.
        """
        p = len(NAMES)
        first = next(iter(known.values()))
        prior = block_diag(
            np.diag(np.square(first.prior.log_sds / step_sd)), np.linalg.inv(self.new)
        )
        moved = _step(matrix, prior, change, variance)
        ends = np.stack([centre, centre + moved[:p]])
        sizes = []
        for motion, part in self.parts(moved[p:]).items():
            model = known[motion]
            outputs = np.column_stack([ends, np.zeros(2)])[:, : len(model.names)]
            curves = model.curves(model.destandardise(outputs))
            left = curves[1] - curves[0] + part @ self.basis[motion]
            sizes += by_phase(left, curves[0], model.sensor.times, motion).tolist()
        return np.array(sizes)


def _late(model: Model, centre: np.ndarray, onset: np.ndarray) -> np.ndarray:
    """What a motion that starts late changes of the known difference, ``(o, t)``, mm.

    It moves along with the motion, from operation to operation by more than the noise.

    Args:
        model: Model of the motion that knows the difference.
        centre, onset: Standardised parameters ``(o, p)`` and onsets ``(o,)``.
    """
    times = model.sensor.times
    shift = model.shift(model.destandardise(np.column_stack([centre, onset])))
    late = times - model.sensor.onset_sd * onset[:, None]
    moved = [np.interp(at, times, each) for at, each in zip(late, shift, strict=True)]
    return np.array(moved) - shift


def _step(matrix: np.ndarray, prior: np.ndarray, change: np.ndarray, variance: float) -> np.ndarray:
    """Return the mean of a step, ``(k,)``, by the scale of its prior that explains it best.

    Args:
        matrix: Information of one operation, ``(k, k)``.
        prior: Inverse covariance of the largest steps, ``(k, k)``.
        change: Change of the slope of the log likelihood, ``(k,)``.
        variance: Variance of its noise, over that of one operation.
    """
    told, modes = eigh(matrix, prior)
    known = told > _KNOWN * told[-1]
    told, modes = told[known], modes[:, known]
    said, squares = modes.T @ change, np.square(_SCALES)
    spread = variance + squares[:, None] * told
    log_evidence = -0.5 * (np.log(spread) + np.square(said) / (told * spread)).sum(axis=1)
    best = squares[log_evidence.argmax()]
    return modes @ (best * said / (best * told + variance))


def phases(curve: np.ndarray, times: np.ndarray, motion: str) -> np.ndarray:
    """Return which samples of a curve ``(t,)`` are in each of the ``PHASES``, ``(3, t)`` of bool.

    The start is the first 15 % of the way, the main motion goes on as ``records.main_motion`` does,
    and the end is the rest.
    """
    main = main_motion(curve, times, motion)
    begun = (curve - curve[0]) / (curve[-1] - curve[0]) < _START
    return np.stack([main & begun, main & ~begun, (times > 0.0) & ~main])


def by_phase(values: np.ndarray, curve: np.ndarray, times: np.ndarray, motion: str) -> np.ndarray:
    """Return the root mean square of values ``(t,)`` in the ``phases`` of a curve, ``(3,)``."""
    parts = phases(curve, times, motion)
    return np.array(
        [np.sqrt(np.square(values[each]).mean()) if each.any() else 0.0 for each in parts]
    )
