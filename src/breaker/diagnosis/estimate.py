"""The records of a drive, what is given beside them, and what is known of each."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from breaker.family.inputs import NormalisedRecords
from breaker.family.membership import Match
from breaker.family.networks import StateDraws, StateNetwork
from breaker.family.shape import SHAPE_TIMES, Shape
from breaker.model.parameters import GAP, MOTIONS, NAMES, UNIT, Size, powers
from breaker.model.quantities import ANSWERED, EVENTS, INFERRED, Speed
from breaker.records.contacts import ContactTimes
from breaker.records.header import Header
from breaker.records.measurements import Measured
from breaker.records.operations import Operation
from breaker.records.record import Record

if TYPE_CHECKING:
    from breaker.model.prior import Prior

SWITCHING = {"closing": "touch_time", "opening": "separation_time"}
"""Quantity of the time at which the contact touches or parts, by motion."""

FACTS = (*NAMES, "spring_compression", *SWITCHING.values())
"""What facts may be about: all that is inferred, and the wipe, which follows from the gap."""

NOTHING = Measured(np.nan, np.nan, "the record was rejected")
"""What is measured of a record that is not there."""

_OF_EVENT = {*SWITCHING.values(), *(f"{motion}_time" for motion in MOTIONS)}
_OF_EVENT |= {f"{motion}_wipe" for motion in MOTIONS}
_OF_EVENT |= ANSWERED - {"release_from10"}
WITH_CONTACT = _OF_EVENT | {GAP.name, "spring_compression"}
"""What is withheld where the contact may slide."""

MAY_SLIDE = (
    "not timed, and a contact that slides, as at such a stroke, shows none: record it, or give "
    f"--known {GAP.name}"
)
"""Why the time of touch or separation is withheld."""

_PRESSED = 60.0  # mm, longest stroke of drives that press their contact by a spring
_IMPROBABLE = 1e-3  # share of a prior's drives that lie farther out than one that it expects


@dataclass(frozen=True, eq=False)
class DriveRecord:
    """One motion of an operation.

    Attributes:
        operation, motion: What it is of.
        stated: What stands above the samples of its file.
        reason: Why it cannot be used; empty if it can.
        raw: The record as it is in its file, if it can be used.
        shape, seen: What networks see of it.
        other: Whether its file has the other motion alone.
    """

    operation: Operation
    motion: str
    stated: Header
    reason: str = ""
    raw: Record | None = None
    shape: Shape | None = None
    seen: NormalisedRecords | None = None
    other: bool = False

    @property
    def timed(self) -> bool:
        """Whether its contact was seen to switch."""
        return bool(np.isfinite(self.raw.contact.time))

    @property
    def tenth(self) -> float:
        """Time of 10 % of the way, from which networks count, ms of the file."""
        return float(self.raw.time[self.raw.segment.begin]) + self.shape.origin

    @property
    def switched(self) -> float:
        """When its contact was seen to switch, ms after 10 % of the way; nan if it was not."""
        return self.raw.contact.time - self.tenth


@dataclass(frozen=True)
class EstimateSettings:
    """How answers are drawn.

    Attributes:
        draws: Of an answer.
        misfit_p_value: From which on a record fits a family.
        seed: Of all random numbers.
    """

    draws: int
    misfit_p_value: float
    seed: int


@dataclass(frozen=True, eq=False)
class Given:
    """What is given beside the records.

    Attributes:
        size: Size of the drive beside the family's; None if it is not known.
        prior: Prior of one's own, at that size; None is the family's.
        known: Facts, ``{name: [value, sd]}``, of ``FACTS``.
    """

    size: Size | None = None
    prior: "Prior | None" = None
    known: Mapping[str, Sequence[float]] = field(default_factory=dict)

    def prior_of(self, levels: StateNetwork) -> "Prior":
        """Return the prior at the size: one's own, or the family's."""
        if self.prior is not None:
            return self.prior
        from breaker.model.prior import Prior

        return Prior.from_settings(levels.settings["prior"]).sized(self.size or UNIT)

    def prior_log_sds(self, levels: StateNetwork) -> np.ndarray:
        """Return sds of the logarithms of the parameters before any record, ``(p,)``.

        Without a size that of the family's drives is as unknown as their stroke and duration.
        """
        if self.prior is not None:
            return np.asarray(self.prior.log_sds)
        return np.sqrt(np.diag(self._prior_covariance(levels)))

    def _prior_covariance(self, levels: StateNetwork) -> np.ndarray:
        """Covariance of what networks take the logarithms of parameters for, ``(p, p)``."""
        found = np.diag([np.square(levels.settings["prior"][n]["log_sd"]) for n in NAMES])
        if self.size is None:
            found += powers().T @ np.diag(np.square(levels.usual[:, 1])) @ powers()
        return found

    def prior_moments(self, answer: "Estimate") -> tuple[np.ndarray, np.ndarray]:
        """Return mean and covariance of what networks take the logarithms of parameters for.

        Args:
            answer: Of the drive, whose stroke and duration tell its size where it is not given.

        Returns:
            ``(p,)`` and ``(p, p)``.
        """
        prior = replace(self, prior=None).prior_of(answer.levels)
        mean = np.log(prior.medians)
        if self.size is None:
            seen, middle = answer.record.seen, answer.levels.usual[:, 0]
            mean += (np.log([seen.stroke[0], seen.duration[0]]) - middle) @ powers()
        return mean, self._prior_covariance(answer.levels)

    def sample_prior(self, answer: "Estimate", n: int, rng: np.random.Generator) -> np.ndarray:
        """Draw from the prior, ``(n, p)``.

        Without a size, the family's is taken to the size of drives with about this stroke and
        duration, which these tell as well as both are alike in drives of one size.
        """
        theta = self.prior_of(answer.levels).sample(n, rng)
        if self.size is not None:
            return theta
        seen = answer.record.seen
        middle, sd = answer.levels.usual.T
        logs = np.log([seen.stroke[0], seen.duration[0]]) - middle
        return theta * np.exp((logs + sd * rng.standard_normal((n, 2))) @ powers())


@dataclass(frozen=True, eq=False)
class Estimate:
    """What is known of one record.

    Attributes:
        record: The record.
        levels: Network of the family; None of a record that cannot be used.
        match: How the record fits the family.
        misfit: Whether it is out of the family, so that nothing is inferred.
        motions: Motions of the operation whose records the draws are from.
        draws: Draws of the network; none of a misfit, and where hardly one of them is left.
        effective_size: How many of them weights leave.
        unresolved: Why the draws are too few; empty if they are not.
        measured: What the record shows, by name.
        speeds: How speeds are defined.
        prior_share: Of each parameter, the variance of its logarithm over that before the record,
            ``(p,)``: 1 where the record says nothing.
        prior_sds: Of each parameter's median from that of a given prior, in its sds.
        prior_p_value: Share of that prior's drives that are farther out.
        records: How many records it is the mean of.
        contact_known: Whether facts or a prior of the type say how the contact is.
        surprise: Of the contact's time, in sds of what the record leads to expect.
        remarks: What is doubtful, in words.
    """

    record: DriveRecord
    levels: StateNetwork | None = None
    match: Match | None = None
    misfit: bool = False
    motions: tuple[str, ...] = ()
    draws: StateDraws | None = None
    effective_size: float = np.nan
    unresolved: str = ""
    measured: Mapping[str, Measured] = field(default_factory=dict)
    speeds: tuple[Speed, ...] = ()
    prior_share: np.ndarray | None = None
    prior_sds: np.ndarray | None = None
    prior_p_value: float = np.nan
    records: int = 1
    contact_known: bool = False
    surprise: float = np.nan
    remarks: tuple[str, ...] = ()

    @property
    def why_not_inferred(self) -> str:
        """Why there are no draws of a record that can be used; empty if there are."""
        few = f"not resolved: {self.unresolved}" if self.unresolved else ""
        return "out of the family: nothing is inferred" if self.misfit else few

    def why_not(self, name: str) -> str:
        """Why a quantity is not known; empty if it is."""
        known = self.draws is not None
        if known and self.may_slide and not self.alone(name):
            return MAY_SLIDE
        if (known and self.is_inferred(name)) or not (known or self.alone(name)):
            return self.why_not_inferred
        return self.measured.get(name, NOTHING).reason

    @property
    def far_from_prior(self) -> bool:
        """Whether a given prior hardly holds the drive."""
        return self.prior_p_value < _IMPROBABLE

    @property
    def contact(self) -> ContactTimes:
        """The contact of the record, with the inferred touch or separation where none was timed."""
        contact = self.record.raw.contact
        if self.record.timed or self.draws is None or self.may_slide:
            return contact
        switching = self.draws.switching[self.record.motion]
        at = self.record.tenth + float(np.median(switching))
        return contact._replace(time=at, sd=float(switching.std()))

    @property
    def may_slide(self) -> bool:
        """Whether the contact may slide without a spring, so that no travel shows its touch."""
        known = self.record.timed or self.contact_known
        return not known and self.record.shape.stroke > _PRESSED

    @property
    def after_release(self) -> np.ndarray:
        """Time from the release to touch or separation, ``(d,)``, ms."""
        return self.draws.switching[self.record.motion] - self.draws.release[self.record.motion]

    def is_inferred(self, name: str) -> bool:
        """Whether draws tell a quantity, and no reading of the record."""
        return name in NAMES or name in INFERRED

    def alone(self, name: str) -> bool:
        """Whether the record shows a quantity without an inferred touch or separation."""
        of_event = {each.name for each in self.speeds if each.of_event} | _OF_EVENT
        return self.record.timed or name not in of_event | {"spring_compression"}

    def inferred(self, name: str) -> np.ndarray | None:
        """Draws of a parameter, of the wipe, or of a time of touch, separation or release,
        ``(d,)``; None of anything else. From the first motion, times of facts count.
        """
        if name in NAMES:
            return self.draws.theta[:, NAMES.index(name)]
        if name == "spring_compression":
            return self.record.shape.stroke - self.draws.theta[:, NAMES.index(GAP.name)]
        motion, record = self.record.motion, self.record
        event, switching = EVENTS[motion], self.draws.switching[motion]
        times = {f"{event}_from10": switching, f"{event}_after_release": self.after_release}
        times["release_from10"] = self.draws.release[motion]
        times[SWITCHING[motion]] = record.tenth - record.raw.moves + switching
        return times.get(name)

    @property
    def way_to_rest(self) -> np.ndarray:
        """Way of the drive between touch or separation and its closed rest, ``(d,)``, mm."""
        record = self.record
        at = self.draws.switching[record.motion] / record.shape.duration
        way = np.interp(at, SHAPE_TIMES, record.shape.way)
        return record.shape.stroke * (1.0 - way if record.motion == "closing" else way)
