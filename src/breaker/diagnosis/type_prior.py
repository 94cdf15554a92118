"""The prior of a type: its medians and log-sds, and where each part of a log-sd comes from."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from breaker.common.randomness import generator
from breaker.configuration.loading import UNLIKE, defaults
from breaker.diagnosis.type_model import (
    TypeDraws,
    TypeOfBreaker,
    draws_of,
    learn_contact_lag,
    learn_type,
)
from breaker.diagnosis.type_records import Recorded
from breaker.model.curves import travel
from breaker.model.parameters import NAMES, Size
from breaker.model.prior import Prior
from breaker.model.sensor import Sensor

SWINGING = 0.2
"""Share of openings that may swing back where the workflow simulates openings at all."""

_OPENINGS = 400  # of a prior, that tell whether the model stops them
_WIDTHS = (np.inf, *np.geomspace(1.0, 0.1, 11).round(2).tolist())  # log-sds, tried in turn
_LIKE = 0.99 * UNLIKE  # times the reference drive's that a median may be
_WEAR_SDS = 3.0  # sd of the room that the largest usual wear is


@dataclass(frozen=True, eq=False)
class FittedPrior:
    """The prior of a type of breaker.

    Attributes:
        reference: The family's prior, scaled to about the size of the type.
        names: Of the breakers.
        drawn: What the records of each say, by itself.
        learned: What they have in common.
        room: Log-sds of the room for wear, ``(p,)``.
        unfit: Breakers of which no record was inferred, which are left out.
        unlike: Parameters whose median would be refused as that of no drive, and is bounded.
        contact_lag: See ``learn_contact_lag``; of motions whose contacts were recorded.
        widest: The largest log-sds of the prior, ``(p,)``, where those of the records cannot be
            taken.
    """

    reference: Prior
    names: tuple[str, ...]
    drawn: TypeDraws
    learned: TypeOfBreaker
    room: np.ndarray
    unfit: tuple[str, ...] = ()
    unlike: tuple[str, ...] = ()
    contact_lag: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    widest: np.ndarray = field(default_factory=lambda: np.full(len(NAMES), np.inf))

    @property
    def alone(self) -> bool:
        """Whether the records of one breaker are the only source."""
        return len(self.names) == 1

    @property
    def spread_seen(self) -> np.ndarray:
        """Log-sds of all parts together, ``(p,)``."""
        return np.hypot(self.learned.log_sds, self.room)

    @property
    def prior(self) -> Prior:
        """The fitted prior."""
        return Prior(self.learned.medians, np.minimum(self.spread_seen, self.widest))

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
        """Low ends, medians and high ends of 90 % intervals of the breakers, ``(3, b, p)``, in the
        units of the parameters.
        """
        return np.quantile(self.drawn.theta, [0.05, 0.5, 0.95], axis=1)


def fit_type(recorded: Recorded, room: np.ndarray) -> FittedPrior:
    """Fit the prior of a type.

    Args:
        recorded: Records of some breakers.
        room: Log-sds of the room for wear, ``(p,)``.

    Raises:
        ValueError: If no record of any breaker was inferred.
    """
    every = {name: draws_of(answers) for name, answers in recorded.answers.items()}
    found = {name: draws for name, draws in every.items() if draws}
    if not found:
        raise ValueError(
            f"no record of {', '.join(every)} is of a family of drives ("
            + " | ".join(f"{name}: {recorded.fit_in_words(name)}" for name in recorded.tried)
            + "): look at one (`breaker infer FILE --plot PNG`), and at endurance.format"
        )
    drawn, default = TypeDraws.of(found.values()), Prior.from_settings(defaults()["prior"])
    learned, usual = learn_type(drawn, default.log_sds), default.sized(recorded.size).medians
    medians = np.clip(learned.medians, usual / _LIKE, usual * _LIKE)
    return FittedPrior(
        reference_of(recorded),
        tuple(found),
        drawn,
        replace(learned, medians=medians),
        room,
        tuple(name for name in every if name not in found),
        tuple(np.array(NAMES)[medians != learned.medians].tolist()),
        learn_contact_lag(recorded.answers.values()),
    )


def swings_back(prior: Prior, size: Size, seed: int) -> float:
    """Return the share of a prior's openings that swing back by more than half of their way.

    Of drives that dampers stop, friction is low, and the two-spring model has nothing else to stop.
    """
    usual = Sensor(**defaults()["sensor"]).sized(size).times
    theta = prior.sample(_OPENINGS, generator(seed, "fit-prior openings"))
    time, begin = usual[usual >= 0.0], np.zeros(_OPENINGS)
    ways = travel(theta, time, "opening", onset=begin).travel
    return float(np.mean([np.ptp(way[way.argmin() :]) > 0.5 * np.ptp(way) for way in ways]))


def reference_of(recorded: Recorded) -> Prior:
    """Return the family's prior at the size of the records."""
    return Prior.from_settings(recorded.levels.settings["prior"]).sized(recorded.size)


def wear_allowance(change: Mapping[str, tuple[float, float]]) -> np.ndarray:
    """Return the room that a prior needs for wear, log-sds, ``(p,)``.

    Args:
        change: Ranges of changes of a family that wears, shares.

    Example:
        >>> wear_allowance({"L": (0.005, 0.12)}).round(3)  # 12 % is three times this
        array([0.   , 0.   , 0.   , 0.   , 0.   , 0.   , 0.038])
    """
    ends = np.array([change.get(name, (0.0, 0.0)) for name in NAMES])
    return np.abs(np.log1p(ends)).max(axis=1) / _WEAR_SDS
