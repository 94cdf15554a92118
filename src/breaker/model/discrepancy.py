r"""What the model leaves out of a motion: its own error, as one more Gaussian.

No real drive is the model. With ``delta`` the difference of a drive's curve from the model's curve
*at the drive's true parameters*, a record is ``curve + delta + zero + noise`` (Kennedy & O'Hagan,
2001, "Bayesian calibration of computer models"). A record alone says little of ``delta``, for the
model bends its parameters until it fits; so ``delta`` is learned from drives that are richer than
the model and whose parameters are known (``breaker.synthetic``). It is taken for normal given the
standardised parameters z, with a mean linear in them and few components:

``delta = s (mean + z slopes) + s xi factor``,   ``xi ~ N(0, 1)``.

The scale ``s`` says how far a drive is from the model: 0, the model is right; 1, as far as the
drives that it was learned from.

The contact of a drive does not touch or part at the model's time either. Its ``Lag`` behind the
model's is one more normal number, with the same components:

``lag = s (mean + z slopes + xi loading + sd eta)``,   ``eta ~ N(0, 1)``.
"""

from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from breaker.mechanism import Size

if TYPE_CHECKING:  # what reads arrays alone does not load it
    import xarray as xr

__all__ = ["Discrepancy", "Lag", "Modes", "modes", "open_discrepancy"]

_CURVE = ("mean", "slopes", "factor")
_LAG = ("lag_mean", "lag_slopes", "lag_loading", "lag_sd")


@dataclass(frozen=True, eq=False)
class Lag:
    """Normal distribution of how much later a drive's contact switches than the model's.

    Attributes:
        mean: At the prior medians, ms.
        slopes: Change of the mean by each standardised parameter, ``(p,)``, ms.
        loading: What each component of the curve's error brings along, ``(c,)``, ms.
        sd: Of what the components do not tell, ms.
    """

    mean: float
    slopes: np.ndarray
    loading: np.ndarray
    sd: float

    def scaled(self, factor: float) -> "Lag":
        """Return it with all of it multiplied."""
        parts = self.mean, self.slopes, self.loading, self.sd
        return Lag(*(factor * each for each in parts))


@dataclass(frozen=True, eq=False)
class Discrepancy:
    """Normal distribution of what the model leaves out of a motion.

    Attributes:
        mean: At the prior medians, ``(t,)``, mm.
        slopes: Change of the mean by each standardised parameter, ``(p, t)``, mm.
        factor: Components, each scaled to its standard deviation, ``(c, t)``, mm: the covariance
            about the mean is ``factor.T @ factor``.
        lag: That of the contact; None where it was not learned.

    Example:
        >>> ramp = np.linspace(0.0, 1.0, 5)
        >>> left_out = Discrepancy(ramp, np.zeros((7, 5)), 0.1 * ramp[None])
        >>> left_out.shift(np.zeros((1, 7))).tolist()
        [[0.0, 0.25, 0.5, 0.75, 1.0]]
        >>> float(left_out.scaled(2.0).sd[-1])
        0.2
    """

    mean: np.ndarray
    slopes: np.ndarray
    factor: np.ndarray
    lag: Lag | None = None

    def __post_init__(self) -> None:
        t = len(self.mean)
        if self.slopes.ndim != 2 or self.slopes.shape[1] != t or self.factor.shape[1:] != (t,):
            raise ValueError(
                f"mean (t,), slopes (p, t) and factor (c, t) are {self.mean.shape}, "
                f"{self.slopes.shape} and {self.factor.shape}"
            )
        if self.lag is None:
            return
        found = tuple(np.shape(each) for each in (self.lag.slopes, self.lag.loading))
        if found != (wanted := ((len(self.slopes),), (len(self.factor),))):
            raise ValueError(f"slopes (p,) and loading (c,) of the lag are {found}, not {wanted}")

    @classmethod
    def from_dataset(cls, data: "xr.Dataset") -> "Discrepancy":
        """Return that of one motion from what ``synthetic.learn`` returns.

        Raises:
            KeyError: If a part is missing; the lag may be missing as a whole.
        """
        names = [*_CURVE, *(_LAG if any(name in data for name in _LAG) else ())]
        parts = {name: np.asarray(data[name], dtype=np.float64) for name in names}
        lag = [parts.pop(name) for name in _LAG if name in parts]
        return cls(**parts, lag=Lag(*lag) if lag else None)

    @property
    def sd(self) -> np.ndarray:
        """Standard deviation about the mean, ``(t,)``, mm."""
        return np.sqrt(np.square(self.factor).sum(axis=0))

    def scaled(self, scale: float) -> "Discrepancy | None":
        """Return it at a scale; None at scale 0, where there is none."""
        if not scale:
            return None
        lag = self.lag and self.lag.scaled(scale)
        return Discrepancy(scale * self.mean, scale * self.slopes, scale * self.factor, lag)

    def sized(self, size: Size) -> "Discrepancy":
        """Return it as it is for drives of another size."""
        lag = self.lag and self.lag.scaled(size.times)
        return replace(self.scaled(size.lengths), lag=lag)

    def shift(self, z: np.ndarray) -> np.ndarray:
        """Return the mean at standardised parameters, ``(..., p) -> (..., t)``, mm."""
        return self.mean + z @ self.slopes

    def sample(self, shape: tuple[int, ...], rng: np.random.Generator) -> np.ndarray:
        """Draw deviations from the mean, ``(*shape, t)``, mm."""
        return rng.standard_normal((*shape, len(self.factor))) @ self.factor


def open_discrepancy(store: str | Path | None, motion: str) -> Discrepancy | None:
    """Return what the model leaves out of a motion, from the store of all motions.

    Args:
        store: Zarr store; none, or an empty list as Snakemake has it, where nothing is left out.
        motion: "closing" or "opening".
    """
    if not store:
        return None
    from breaker.stores import open_store

    return Discrepancy.from_dataset(open_store(store).sel(motion=motion))


class Modes(NamedTuple):
    """Modes of a discrepancy, whitened by noise and zero, of the samples that are there.

    Attributes:
        directions: Orthonormal, ``(c, t)``, zero where a sample is missing.
        weights: The same for residuals that are not whitened, 1/mm, ``(c, t)``.
        variances: Over that of the noise, ``(c,)``.
    """

    directions: np.ndarray
    weights: np.ndarray
    variances: np.ndarray


@lru_cache(maxsize=512)
def modes(sensor, present: bytes) -> Modes:
    """Return the modes of a ``Sensor``'s discrepancy.

    Args:
        present: Which samples are there, the bytes of a bool array ``(t,)``.
    """
    there = np.frombuffer(present, dtype=np.bool_)
    whiten = sensor.noise_and_zero.whiten
    whitened = whiten(np.where(there, sensor.discrepancy.factor, np.nan))
    _, sizes, directions = np.linalg.svd(whitened, full_matrices=False)
    directions = np.where(there, directions, 0.0)
    weights = whiten(np.where(there, directions, np.nan))
    return Modes(directions, weights, np.square(sizes))
