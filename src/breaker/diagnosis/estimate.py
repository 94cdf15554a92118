"""Records of a drive, knowledge that a user supplies with them, and the estimate of each record."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from breaker.diagnosis.sentences import say
from breaker.family.inputs import NormalisedRecords
from breaker.family.membership import Match
from breaker.family.networks import StateDraws, StateNetwork
from breaker.family.shape import Shape
from breaker.model.parameters import GAP, MOTIONS, NAMES, Size, powers
from breaker.model.prior import Prior
from breaker.model.quantities import AFTER_RELEASE, ANSWERED, EVENTS, INFERRED, Speed
from breaker.records.contacts import ContactTimes
from breaker.records.header import Header
from breaker.records.measurements import Measured
from breaker.records.operations import Operation
from breaker.records.record import Record

SWITCHING = {"closing": "touch_time", "opening": "separation_time"}
"""Quantity of the time of contact touch or separation, by motion."""

KNOWN_VALUES = (*NAMES, "spring_compression", *SWITCHING.values())
"""Quantities whose values a user may supply."""

NOTHING = Measured(np.nan, np.nan, "the record was rejected")
"""Measurement of a record that cannot be used."""

_AT_CONTACT = {*SWITCHING.values(), *(f"{m}_{name}" for m in MOTIONS for name in ("time", "wipe"))}
_NEED_CONTACT = _AT_CONTACT | ANSWERED - {"release_from10"} | {GAP.name, "spring_compression"}
_PRESSED = 60.0  # mm; longer strokes are puffers', whose travel does not show a sliding contact


@dataclass(frozen=True, eq=False)
class DriveRecord:
    """One motion of an operation.

    Attributes:
        motion: "closing" or "opening".
        stated: Statements above the samples of the file.
        reason: Reason why the record cannot be used; empty if it can.
        raw, shape, seen: Record as it is in the file, normalised, and as input of networks with its
            noise; None if it cannot be used.
    """

    operation: Operation
    motion: str
    stated: Header
    reason: str = ""
    raw: Record | None = None
    shape: Shape | None = None
    seen: NormalisedRecords | None = None

    @property
    def timed(self) -> bool:
        """Whether the record has a time of contact touch or separation."""
        return bool(np.isfinite(self.raw.contact.time))

    @property
    def tenth(self) -> float:
        """Time of 10 % of the stroke, from which networks count times, ms of the file."""
        return float(self.raw.time[self.raw.segment.begin]) + self.shape.origin

    @property
    def switched(self) -> float:
        """Recorded contact touch or separation, ms after 10 % of the stroke; nan if not timed."""
        return self.raw.contact.time - self.tenth


@dataclass(frozen=True, eq=False)
class Given:
    """Knowledge that a user supplies with the records.

    Attributes:
        size: Scale factors of the drive relative to the family; None if unknown.
        prior: User's prior, at that size; None for the family's.
        known: Known values, ``{name: [value, sd]}``, of ``KNOWN_VALUES``.
    """

    size: Size | None = None
    prior: Prior | None = None
    known: Mapping[str, Sequence[float]] = field(default_factory=dict)

    @property
    def restricts(self) -> bool:
        """Whether a prior or known values weight posterior draws."""
        return self.prior is not None or bool(self.known)

    def family_prior(self, estimate: "Estimate") -> Prior:
        """Return the family's prior at the given size, or else at the size of the record."""
        size = self.size
        if size is None:
            seen, usual = estimate.record.seen, np.exp(estimate.levels.usual[:, 0])
            size = Size(float(seen.stroke[0] / usual[0]), float(seen.duration[0] / usual[1]))
        return Prior.from_settings(estimate.levels.settings["prior"]).sized(size)

    def _spread(self, estimate: "Estimate") -> np.ndarray:
        """Return log-sds ``(2, p)`` of parameters due to an unknown stroke and duration."""
        return (0.0 if self.size else estimate.levels.usual[:, 1:]) * powers()

    def prior_variance(self, estimate: "Estimate") -> np.ndarray:
        """Return prior variances of the logarithms of parameters, ``(p,)``."""
        if self.prior is not None:
            return np.square(self.prior.log_sds)
        family = np.square(self.family_prior(estimate).log_sds)
        return family + np.square(self._spread(estimate)).sum(axis=0)

    def sample_prior(self, estimate: "Estimate", n: int, rng: np.random.Generator) -> np.ndarray:
        """Draw parameters from the prior, ``(n, p)``."""
        if self.prior is not None:
            return self.prior.sample(n, rng)
        theta = self.family_prior(estimate).sample(n, rng)
        return theta * np.exp(rng.standard_normal((n, 2)) @ self._spread(estimate))


@dataclass(frozen=True, eq=False)
class Estimate:
    """Estimate of the drive from one record.

    Attributes:
        record: The record.
        levels: State network of the family; None if the record cannot be used.
        match: Distance of the record from the family.
        misfit: Whether the record is outside the family, so that nothing is inferred.
        speeds: Definitions of speeds.
        motions: Motions of the operation whose records the posterior draws use.
        draws: Posterior draws; None outside the family, or if too few are effective.
        stroke: Draws of the stroke between the rest positions, ``(d,)``, mm, from the record of the
            operation that shows it best; None if no record reaches its rest position.
        effective_size: Effective number of weighted draws.
        unresolved: Reason why draws are too few; empty if they are not.
        contact_given: Whether known values or a user's prior restrict the contact.
        contact_used: Whether the inference uses the recorded contact.
        surprise: Recorded contact minus the one that the travel predicts, sds; nan if not timed.
        prior_share: Variance of the logarithm of each parameter over its prior variance, ``(p,)``:
            about 1 if the record does not constrain the parameter.
        measured: Quantities measured in the record, by name.
        remarks: Doubts about the record and its estimate.
    """

    record: DriveRecord
    levels: StateNetwork | None = None
    match: Match | None = None
    misfit: bool = False
    speeds: tuple[Speed, ...] = ()
    motions: tuple[str, ...] = ()
    draws: StateDraws | None = None
    stroke: np.ndarray | None = None
    effective_size: float = np.nan
    unresolved: str = ""
    contact_given: bool = False
    contact_used: bool = False
    surprise: float = np.nan
    prior_share: np.ndarray | None = None
    measured: Mapping[str, Measured] = field(default_factory=dict)
    remarks: tuple[str, ...] = ()

    @property
    def why_not_inferred(self) -> str:
        """Reason why a usable record has no draws; empty if it has draws."""
        return say("outside-family") if self.misfit else self.unresolved

    def why_not(self, name: str) -> str:
        """Return the reason why a parameter or quantity has no value; empty if it has one."""
        inferred = self.is_inferred(name)
        if not self.measured_directly(name):
            if self.draws is None:
                return self.why_not_inferred
            if self.contact_unknown and (name in _NEED_CONTACT or not inferred):
                return say("contact-may-slide", gap=GAP.name)
        if inferred:
            lacks_stroke = name == "spring_compression" and self.stroke is None
            return self.measured["stroke"].reason if lacks_stroke else ""
        return self.measured.get(name, NOTHING).reason

    def is_inferred(self, name: str) -> bool:
        """Return whether a value comes from posterior draws, not from a measurement."""
        return name in NAMES or name in INFERRED

    def measured_directly(self, name: str) -> bool:
        """Return whether a quantity is measured without an inferred contact touch or separation."""
        at_contact = _AT_CONTACT | {speed.name for speed in self.speeds if speed.of_event}
        return not self.is_inferred(name) and (self.record.timed or name not in at_contact)

    @property
    def contact_unknown(self) -> bool:
        """Whether the contact may slide, so that the travel does not show its touch."""
        return not (self.contact_used or self.contact_given) and self.record.shape.stroke > _PRESSED

    @property
    def contact(self) -> ContactTimes:
        """Times of the contact: recorded, or the inferred touch or separation if not timed."""
        contact = self.record.raw.contact
        if self.record.timed or self.draws is None or self.contact_unknown:
            return contact
        switching = self.draws.switching[self.record.motion]
        time = self.record.tenth + float(np.median(switching))
        return contact._replace(time=time, sd=float(switching.std()))

    def inferred(self, name: str) -> np.ndarray | None:
        """Return draws ``(d,)`` of a parameter, the spring compression, or a time of the start of
        motion, contact touch or separation; None for other quantities.
        """
        if name in NAMES:
            return self.draws.theta[:, NAMES.index(name)]
        if name == "spring_compression":
            return None if self.stroke is None else self.stroke - self.inferred(GAP.name)
        motion, record = self.record.motion, self.record
        switching, release = self.draws.switching[motion], self.draws.release[motion]
        times = {"release_from10": release, f"{EVENTS[motion]}_from10": switching}
        times[AFTER_RELEASE[motion]] = switching - release
        times[SWITCHING[motion]] = record.tenth - record.raw.moves + switching
        return times.get(name)
