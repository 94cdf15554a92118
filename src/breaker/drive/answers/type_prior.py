"""The prior of a type: its medians and log-sds, and where each part of a log-sd comes from."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from breaker.common.randomness import generator
from breaker.configuration.loading import read
from breaker.configuration.magnitudes import UNLIKE
from breaker.drive.answers.limit_verdicts import NORMAL
from breaker.drive.answers.type_records import Recorded
from breaker.drive.answers.type_spread import Spread, TypeFit, find_spread, fit_breaker
from breaker.mechanism.curves import travel
from breaker.mechanism.prior import Prior
from breaker.mechanism.sensor import Sensor
from breaker.quantities.parameters import NAMES
from breaker.quantities.size import Size, powers
from breaker.shipped import DEFAULTS

DESIGN = 0.6
"""Share of a breaker's posterior variance that is taken for an error that its type shares."""

SWINGING = 0.2
"""Share of openings that may swing back where the workflow simulates openings at all."""

_DRAWS = 500  # of each operation
_OPENINGS = 400  # of a prior, that tell whether the model stops them
_SIZE = 0.3  # sd of the logarithms of a size that is read from records: next to nothing known
_ALONE = 1.0  # log-sds of the default: spread between breakers where there is one alone
_WIDTHS = (np.inf, *np.geomspace(1.0, 0.1, 11).round(2).tolist())  # log-sds, tried in turn
_LIKE = 0.99 * UNLIKE  # times the reference drive's that a median may be
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
        unlike: Parameters whose median would be refused as that of no drive, and is bounded.
        widest: The largest log-sds of the prior, ``(p,)``, where those of the records cannot be
            taken.
    """

    reference: Prior
    fits: Mapping[str, TypeFit]
    spread: Spread
    room: np.ndarray
    unfit: tuple[str, ...] = ()
    unlike: tuple[str, ...] = ()
    widest: np.ndarray = field(default_factory=lambda: np.full(len(NAMES), np.inf))

    @property
    def alone(self) -> bool:
        """Whether the records of one breaker are the only source."""
        return len(self.fits) == 1

    @property
    def between(self) -> np.ndarray:
        """Spread between breakers."""
        between = self.spread.between
        return np.maximum(between, _ALONE * _of_a_type(self.reference)) if self.alone else between

    @property
    def design(self) -> np.ndarray:
        """Error that all breakers of the type may share, so that more of them do not lessen it.

        Breakers of a type have the same levers and dampers, so that the model's error is alike in
        all of them, and in those to be judged.
        """
        sds = [self.own(name)[1] for name in self.fits]
        return np.sqrt(DESIGN * np.mean(np.square(sds), axis=0))

    @property
    def spread_seen(self) -> np.ndarray:
        """Log-sds of all parts together, ``(p,)``."""
        parts = (self.spread.centre_sd, self.between, self.design, self.room)
        return self.reference.log_sds * np.sqrt(np.sum(np.square(parts), axis=0))

    @property
    def prior(self) -> Prior:
        """The fitted prior."""
        medians = self.reference.destandardise(self.spread.centre)
        return Prior(medians, np.minimum(self.spread_seen, self.widest))

    def own(self, name: str) -> tuple[np.ndarray, np.ndarray]:
        """Return a breaker's standardised parameters and their sds, by itself, ``(p,)``."""
        mean, cov = self.fits[name].posterior(precision_of(self.reference))
        return mean, np.sqrt(cov.diagonal())

    def without(self, name: str, rng: np.random.Generator) -> "FittedPrior":
        """Return the prior that the other breakers make."""
        others = {other: fit for other, fit in self.fits.items() if other != name}
        spread = _spread_of(others, self.reference, rng)
        return replace(self, fits=others, spread=spread)

    def accepted(self, check: Callable[["FittedPrior"], None]) -> "FittedPrior":
        """Return the prior as wide as a check accepts it, bounded where it needs to be.

        Few breakers that differ, or records at the ends of the family, leave a spread next to
        unknown. A prior that wide has drives that do not move, or cannot be followed.

        Args:
            check: Raises a ``ValueError`` where a prior cannot be used.

        Raises:
            ValueError: That of the check, if it accepts no width.
        """

        def refusal(widest: np.ndarray) -> ValueError | None:
            try:
                check(replace(self, widest=widest))
            except ValueError as error:
                return error
            return None

        tried = (np.full(len(NAMES), width) for width in _WIDTHS)
        bounds = next((each for each in tried if (why := refusal(each)) is None), None)
        if bounds is None:
            raise why
        for i in np.argsort(self.spread_seen):  # those without need are set free, the least first
            free = np.where(np.arange(len(NAMES)) == i, np.inf, bounds)
            if self.spread_seen[i] <= bounds[i] or refusal(free) is None:
                bounds = free
        return replace(self, widest=bounds)

    @property
    def intervals(self) -> np.ndarray:
        """Low ends, middles and high ends of 90 % intervals of the breakers, ``(3, b, p)``, in the
        units of the parameters.
        """
        own = np.array([self.own(name) for name in self.fits])  # (b, 2, p)
        ends = (own[:, 0] + sds * own[:, 1] for sds in (-NORMAL[90], 0.0, NORMAL[90]))
        return np.stack([self.reference.destandardise(each) for each in ends])


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
    # By their order, as names hold the folder, which may be anywhere.
    for number, (name, operations) in enumerate(recorded.operations.items()):
        rng = generator(seed, "fit-prior draws", number)
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
            f"no record of {', '.join(recorded.operations)} is of a family of drives ("
            + " | ".join(f"{name}: {recorded.fit_in_words(name)}" for name in recorded.tried)
            + "): look at one (`breaker infer FILE --plot PNG`), and at endurance.format"
        )
    spread = _spread_of(fits, reference, generator(seed, "fit-prior spread"))
    unfit = tuple(name for name in recorded.operations if name not in fits)
    usual = _default().sized(recorded.size).medians
    centre = np.clip(spread.centre, *map(reference.standardise, (usual / _LIKE, usual * _LIKE)))
    unlike = tuple(np.array(NAMES)[centre != spread.centre].tolist())
    return FittedPrior(reference, fits, replace(spread, centre=centre), room, unfit, unlike)


def _spread_of(fits: Mapping[str, TypeFit], reference: Prior, rng: np.random.Generator) -> Spread:
    """The spread of a type, standardised by the reference."""
    between = _of_a_type(reference)
    return find_spread([*fits.values()], precision_of(reference), rng, between)


def _of_a_type(reference: Prior) -> np.ndarray:
    """Log-sds of the default prior, in those of the reference, ``(p,)``.

    A family of drives of any kind is wider than one of about one size. Breakers of a type are not.
    """
    return np.minimum(_default().log_sds / reference.log_sds, 1.0)


def _default() -> Prior:
    """The prior of the reference drive."""
    return Prior.from_settings(read(DEFAULTS)["prior"])


def swings_back(prior: Prior, size: Size, seed: int) -> float:
    """Return the share of a prior's openings that swing back by more than half of their way.

    Of drives that dampers stop, friction is low, and the two-spring model has nothing else to stop.
    """
    usual = Sensor.from_settings(read(DEFAULTS)["sensor"]).sized(size).times
    theta = prior.sample(_OPENINGS, generator(seed, "fit-prior openings"))
    time, begin = usual[usual >= 0.0], np.zeros(_OPENINGS)
    ways = travel(theta, time, "opening", onset=begin).travel
    return float(np.mean([np.ptp(way[way.argmin() :]) > 0.5 * np.ptp(way) for way in ways]))


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
