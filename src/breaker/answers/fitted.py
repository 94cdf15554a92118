"""The prior of a type: its medians and log-sds, and where each part of a log-sd comes from."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import xarray as xr

from breaker.answers.fits import Fit, fit_breaker
from breaker.answers.judgement import NORMAL
from breaker.answers.recorded import Recorded
from breaker.answers.spread import Spread, find_spread
from breaker.mechanism import NAMES, PARAMETERS, powers
from breaker.model import Prior, generator

__all__ = ["FittedPrior", "fit_type", "precision_of", "reference_of", "wear_allowance"]

_DRAWS = 500  # of each operation
_SIZE = 0.3  # sd of the logarithms of a size that is read from records: next to nothing known
_DESIGN = 0.6  # share of a breaker's posterior variance taken for an error that its type shares
_ALONE = 1.0  # log-sds of the default: spread between breakers where there is one alone
_WEAR_SDS = 3.0  # sd of the room that the largest usual wear is


@dataclass(frozen=True, eq=False)
class FittedPrior:
    """The prior of a type of breaker.

    The parts of its log-sds are in those of the reference prior, ``(p,)``.

    Attributes:
        reference: The family's prior, scaled to about the size of the type.
        fits: What the records of each breaker say, by name.
        spread: Centre and spread of the type.
        room: Room for wear.
        unfit: Breakers without a record in the family, which are left out.
    """

    reference: Prior
    fits: Mapping[str, Fit]
    spread: Spread
    room: np.ndarray
    unfit: tuple[str, ...] = ()

    @property
    def alone(self) -> bool:
        """Whether the records of one breaker are the only source."""
        return len(self.fits) == 1

    @property
    def between(self) -> np.ndarray:
        """Spread between breakers."""
        return np.maximum(self.spread.between, _ALONE) if self.alone else self.spread.between

    @property
    def design(self) -> np.ndarray:
        """Error that all breakers of the type may share, so that more of them do not lessen it.

        Breakers of a type have the same levers and dampers, so that the model's error is alike in
        all of them, and in those to be judged.
        """
        sds = [self.own(name)[1] for name in self.fits]
        return np.sqrt(_DESIGN * np.mean(np.square(sds), axis=0))

    @property
    def prior(self) -> Prior:
        """The fitted prior."""
        parts = (self.spread.centre_sd, self.between, self.design, self.room)
        return Prior(
            self.reference.destandardise(self.spread.centre),
            self.reference.log_sds * np.sqrt(np.sum(np.square(parts), axis=0)),
        )

    def own(self, name: str) -> tuple[np.ndarray, np.ndarray]:
        """Return a breaker's standardised parameters and their sds, by itself, ``(p,)``."""
        mean, cov = self.fits[name].posterior(precision_of(self.reference))
        return mean, np.sqrt(cov.diagonal())

    def without(self, name: str, rng: np.random.Generator) -> "FittedPrior":
        """Return the prior that the other breakers make."""
        others = {other: fit for other, fit in self.fits.items() if other != name}
        spread = find_spread([*others.values()], precision_of(self.reference), rng)
        return FittedPrior(self.reference, others, spread, self.room)

    def to_dataset(self) -> xr.Dataset:
        """Return what a figure shows, in the units of the parameters.

        ``median`` and ``log_sd (kind, parameter)`` of the fitted and of the default prior at the
        size; ``low``, ``middle`` and ``high (breaker, parameter)``: 90 % intervals of the breakers.
        """
        own = np.array([self.own(name) for name in self.fits])  # (b, 2, p)
        low, middle, high = (
            self.reference.destandardise(own[:, 0] + sds * own[:, 1])
            for sds in (-NORMAL[90], 0.0, NORMAL[90])
        )
        priors, by_breaker = (self.prior, self.reference), ("breaker", "parameter")
        return xr.Dataset(
            {
                "median": (("kind", "parameter"), np.array([each.medians for each in priors])),
                "log_sd": (("kind", "parameter"), np.array([each.log_sds for each in priors])),
                "low": (by_breaker, low),
                "middle": (by_breaker, middle),
                "high": (by_breaker, high),
            },
            coords={
                "kind": ["fitted", "default"],
                "breaker": list(self.fits),
                "parameter": list(NAMES),
                "unit": ("parameter", [each.unit for each in PARAMETERS]),
            },
        )


def fit_type(recorded: Recorded, room: np.ndarray, seed: int, least: float) -> FittedPrior:
    """Fit the prior of a type.

    Args:
        recorded: Records of some breakers.
        room: Room for wear, log-sds of the reference prior, ``(p,)``.
        least: p-value below which a record is out of the family; it is left out.

    Raises:
        ValueError: If no breaker has a record in the family.
    """
    levels, reference = recorded.levels, reference_of(recorded)
    fits = {}
    for name, operations in recorded.operations.items():
        rng = generator(seed, "fit-prior draws", name)
        within = [
            each
            for each in operations
            if all(levels.match(motion, seen).p_value >= least for motion, seen in each.items())
        ]
        if within:
            theta = np.concatenate([levels.draw(each, _DRAWS, rng).theta for each in within])
            fits[name] = fit_breaker(theta, reference)
    if not fits:
        raise ValueError(
            f"no record of {', '.join(recorded.operations)} is of the family "
            f"{levels.settings['family']}: look at one (`breaker infer FILE --plot PNG`), and at "
            "endurance.format"
        )
    spread = find_spread(
        [*fits.values()], precision_of(reference), generator(seed, "fit-prior spread")
    )
    unfit = tuple(name for name in recorded.operations if name not in fits)
    return FittedPrior(reference, fits, spread, room, unfit)


def reference_of(recorded: Recorded) -> Prior:
    """Return the family's prior at the size of the records."""
    return Prior.from_settings(recorded.levels.settings["prior"]).sized(recorded.size)


def precision_of(reference: Prior) -> np.ndarray:
    """Return the inverse covariance of standardised parameters where the size is only about that.

    It is what parameters share, so their logarithms are known only as well as that of the size.
    """
    shared = _SIZE * powers() / reference.log_sds
    return np.linalg.inv(np.eye(len(NAMES)) + shared.T @ shared)


def wear_allowance(change: Mapping[str, tuple[float, float]], prior: Prior) -> np.ndarray:
    """Return the room that a prior needs for wear, in its log-sds, ``(p,)``.

    Args:
        change: The section ``rigs.wear.change`` of the configuration: ranges of changes, shares.

    Example:
        >>> prior = Prior([2.0, 0.045, 0.040, 0.30, 0.12, 0.75, 10.0], [0.1] * 7)
        >>> wear_allowance({"L": (0.005, 0.12)}, prior).round(2)  # 12 % is three times this
        array([0.  , 0.  , 0.  , 0.  , 0.  , 0.  , 0.38])
    """
    ends = np.array([change.get(name, (0.0, 0.0)) for name in NAMES])
    return np.abs(np.log1p(ends)).max(axis=1) / (_WEAR_SDS * prior.log_sds)
