"""A richer drive than the model: the two masses of the model, and additional effects.

Forces are per drive mass, mm/ms^2. Without additional effects the drive *is* the model. The effects
occur in real drives; smooth random forces represent unknown effects. Results agree with
``solve_ivp`` to a micrometre (tests/family/test_drive.py), and take a thousandth of the time.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from operator import attrgetter

import numpy as np

from breaker.family.integrator import Contact, closed_rest, follow, sampled
from breaker.model.parameters import NAMES, UNIT, Size

CONTACTS = tuple(kind.name.lower() for kind in Contact)
# Fields of ``Elements`` that are laws of other effects, without a size.
LAWS = ("contact", "stick", "slip", "load", "growth", "drag_power", "friction_speed")


@dataclass(frozen=True)
class Stop:
    """A damper and a bumper at one end of the stroke, which only push back.

    The force of the damper is ``damping * |speed|^power``; it sets in over the first ``depth``.
    """

    reach: float = 0.0
    damping: float = 0.0
    power: float = 1.0
    depth: float = 1.0
    stiffness: float = 0.0
    profile: float = 0.0


@dataclass(frozen=True)
class Waves:
    """A smooth random function: root mean square, as a share of the force that drives the motion,
    and coefficients of sine and cosine of three harmonics, of root mean square 1.
    """

    share: float = 0.0
    harmonics: tuple[float, ...] = (0.0,) * 6


@dataclass(frozen=True)
class Elements:
    """Additional effects of a drive; all absent by default.

    ``shipped/families/medium_voltage.yaml`` has the meaning and the unit of each number. Random
    forces vanish at both rest positions. The transducer reads the pushrod by a lever of the ratio
    1 + ``reading``: its share times ``sum_k c_k cos(k pi x / stroke) / k``; rests stay. The
    law of ``build_up`` is ``1 - exp(-(t / build_up)^growth)``.
    """

    lever_turn: float = 0.0
    lever_lean: float = 0.0
    dry_friction: float = 0.0
    opening_preload: float = 0.0
    contact_preload: float = 0.0
    build_up: float = 0.0
    train_mass: float = 0.0
    train_friction: float = 0.0
    restitution: float = 0.0
    closing_stop: Stop = field(default_factory=Stop)
    opening_stop: Stop = field(default_factory=Stop)
    force_fall: float = 0.0
    drag: float = 0.0
    linkage: float = 0.0
    contact: str = CONTACTS[0]
    way_force: Waves = field(default_factory=Waves)
    time_force: Waves = field(default_factory=Waves)
    speed_force: Waves = field(default_factory=Waves)
    opening_progress: float = 0.0
    stick: float = 0.0
    growth: float = 1.0
    drag_power: float = 2.0
    reading: Waves = field(default_factory=Waves)
    slip: float = 0.08
    load: float = 0.0
    friction_speed: float = 0.02

    @classmethod
    def from_settings(cls, settings: Mapping) -> "Elements":
        """Build from ``{name: number}``, stops and waves ``{name: {...}}``; others are absent."""
        kinds = {field.name: field.type for field in fields(cls) if field.type in (Stop, Waves)}
        parts = {name: kinds[name](**settings[name]) for name in kinds.keys() & settings.keys()}
        return cls(**{**settings, **parts})

    def scaled(self, strength: Mapping[str, float]) -> "Elements":
        """Return the effects with other strengths of some, by name: sizes of forces, no laws."""
        parts = {}
        for name, size in strength.items():
            value = getattr(self, name)
            forces = {Stop: ("damping", "stiffness"), Waves: ("share",)}.get(type(value))
            scaled = {force: size * getattr(value, force) for force in forces or ()}
            parts[name] = replace(value, **scaled) if forces else size * value
        return replace(self, **parts)


SIZES = tuple(field.name for field in fields(Elements) if field.name not in LAWS)
"""Fields of ``Elements`` that have a strength."""

_FORMS = {
    float: float,
    str: int,  # of the kinds of contact
    Stop: np.dtype((np.record, [(field.name, float) for field in fields(Stop)])),
    Waves: np.dtype((np.record, [("share", float), ("harmonics", "6f8")])),
}
_NUMBERS = {name: float for name in NAMES} | {e.name: _FORMS[e.type] for e in fields(Elements)}
_LAYOUT = np.dtype((np.record, [*_NUMBERS.items()]))


def _flat(parts: Elements | Stop | Waves, above: str = "") -> dict[str, float]:
    """Return the numbers by dotted name, in order."""
    numbers = {}
    for name, value in vars(parts).items():
        if isinstance(value, Stop | Waves):
            numbers |= _flat(value, f"{name}.")
        elif isinstance(value, tuple):
            numbers |= {f"{above}{name}.{i}": item for i, item in enumerate(value)}
        else:
            numbers[above + name] = CONTACTS.index(value) if isinstance(value, str) else value
    return numbers


ELEMENTS = tuple(_flat(Elements()))  # names of the numbers of ``Elements``, as ``part.name``


@dataclass(frozen=True)
class Drive:
    """A drive in one condition.

    Attributes:
        theta: The seven parameters, ``(p,)``, in the model's order and units.
        elements: Additional effects, in the units of a drive of size 1.

    Example:
        >>> drive = Drive((2.0, 0.045, 0.040, 0.30, 0.12, 0.75, 10.0), Elements())
        >>> drive.travel("closing", np.array([0.0, 10.0, 60.0])).round(2)
        array([ 0.  , 11.05, 13.53])
    """

    theta: tuple[float, ...]
    elements: Elements
    size: Size = UNIT

    def changed(self, **values) -> "Drive":
        """Return the drive with other parameters or effects, by name; of a stop ``stop.name``."""
        theta, elements = dict(zip(NAMES, self.theta, strict=True)), self.elements
        for name, value in values.items():
            stop, _, part = name.partition(".")
            if name in theta:
                theta[name] = float(value)
            else:
                new = replace(getattr(elements, stop), **{part: value}) if part else value
                elements = replace(elements, **{stop: new})
        return replace(self, theta=tuple(theta.values()), elements=elements)

    def value(self, name: str) -> float:
        """Return a parameter or an effect by its name, as in ``changed``."""
        return self.theta[NAMES.index(name)] if name in NAMES else attrgetter(name)(self.elements)

    def scaled(self, size: Size) -> "Drive":
        """Return a drive of another size with the same shape: ``lengths x(t / times)``."""
        theta = tuple((np.array(self.theta) * size.factors).tolist())
        both = Size(self.size.lengths * size.lengths, self.size.times * size.times)
        return replace(self, theta=theta, size=both)

    @cached_property
    def row(self) -> np.ndarray:
        """Parameters, then effects, of the drive at size 1, ``(p + e,)``."""
        return np.array([*np.array(self.theta) / self.size.factors, *_flat(self.elements).values()])

    @cached_property
    def numbers(self) -> np.record:
        """The same numbers by their names, for compiled code."""
        record = self.row.copy().view(_LAYOUT)[0]
        record.contact = CONTACTS.index(self.elements.contact)  # an integer in the record
        return record

    @cached_property
    def rest(self) -> float:
        """Closed position of the drive at size 1, mm; nan if there is none."""
        return closed_rest(self.numbers)

    @property
    def holds(self) -> bool:
        """Whether there is a closed position, in which the contact is pressed."""
        return bool(np.isfinite(self.rest))

    def travel(self, motion: str, times: np.ndarray) -> np.ndarray:
        """Return the travel, as ``operate``."""
        return self.operate(motion, times)[0]

    def operate(self, motion: str, times: np.ndarray) -> tuple[np.ndarray, float]:
        """Return the travel as the transducer reads it, ``(t,)``, mm, and the time of first contact
        touch or separation, ms after the start of motion; ``inf`` if later than the times.

        Args:
            motion: "closing" or "opening".
            times: Times after the release, ms, rising, ``(t,)``; before 0 the drive rests.

        Raises:
            ValueError: If the drive has no closed position.
            FloatingPointError: If the curve is not finite.
        """
        if not self.holds:
            raise ValueError(f"the closing force does not press the contact: {self}")
        times = np.asarray(times, dtype=np.float64) / self.size.times
        end = max(times[-1], 1e-9)  # all times may be before the start of motion
        pieces, _, switching = follow(self.numbers, self.rest, motion == "closing", end, np.inf)
        if not len(pieces):
            raise FloatingPointError(f"the curve of a drive is not finite: {self}")
        switches = self.size.times * switching if switching <= times[-1] else np.inf
        return self.size.lengths * sampled(pieces, times), switches
