"""A family whose drives move by a simulator of another distribution: parameters in, curves out.

The entry point ``breaker.families`` names an object, such as a module, with

- ``curve(parameters, beside, motion)``: times from the first motion at 0 on, rising, ms; the travel
  then, mm, dense enough for a smooth line through it, until the drive rests; and the time at which
  the contact touches, or parts, ms. It raises ``FloatingPointError`` of a drive that does not work,
  which is then drawn again;
- ``beside(rng)``, if it has more than the seven parameters: numbers by name, which a drive keeps.
  Of those that are named as in ``rich_drive.ELEMENTS``, such as ``contact_preload``, networks tell
  the size; what any other means is known to the simulator alone.

- ``WEAR``, if any of these numbers wears: least and most change of it, as a share, by name.

Parameters come from the ``prior``, and wear as ``family.wear`` of the configuration says.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from breaker.common.plugins import FAMILIES, FAULTS, Plugin, plugin_of
from breaker.drive.simulation.drive_family import Family
from breaker.drive.simulation.rich_drive import ELEMENTS, Drive, Elements
from breaker.mechanism.prior import Prior
from breaker.quantities.parameters import MOTIONS, NAMES

_LONG = 1e4  # ms, of the rest after a curve
_FEWEST = 8  # samples of a curve


def family_of(prior: Prior, settings: Mapping[str, Any]) -> Family:
    """Return the configured family: of the equations here, or of a simulator that is installed.

    Args:
        settings: The section ``family`` of the configuration.

    Raises:
        PluginError: If no installed distribution has the simulator, or it cannot be used.

    Example:
        >>> type(family_of(Prior([1.0] * 7, [0.1] * 7), {"simulator": ""})).__name__
        'Family'
    """
    if not (name := settings.get("simulator", "")):
        return Family(prior, settings)
    plugin = plugin_of(FAMILIES, name)
    if not callable(getattr(plugin.load(), "curve", None)):
        raise plugin.failed("has no function curve")
    return OwnFamily(prior, settings, plugin)


@dataclass(frozen=True)
class OwnDrive(Drive):
    """A drive with numbers of its simulator.

    Attributes:
        beside: What it has beside the parameters, by name.
    """

    beside: Mapping[str, float] = field(default_factory=dict)

    def changed(self, **values) -> "OwnDrive":
        """Return the drive with other numbers, by name."""
        theta = tuple(values.get(n, old) for n, old in zip(NAMES, self.theta, strict=True))
        beside = {name: values.get(name, old) for name, old in self.beside.items()}
        return replace(self, theta=theta, beside=beside)

    def value(self, name: str) -> float:
        """Return a number by its name."""
        return self.beside[name] if name in self.beside else super().value(name)

    @property
    def holds(self) -> bool:
        """Whether it works, which its simulator says when it moves."""
        return True

    @cached_property
    def numbers(self) -> np.ndarray:
        """Parameters, and elements as far as it has them, ``(p + e,)``."""
        absent = dict(zip(ELEMENTS, self.elements.numbers, strict=True))
        return np.array([*self.theta, *(self.beside.get(n, each) for n, each in absent.items())])


@dataclass(frozen=True, eq=False)
class OwnFamily(Family):
    """The family.

    Attributes:
        plugin: The simulator.
    """

    plugin: Plugin

    def new(self, rng: np.random.Generator) -> OwnDrive:
        """Draw a drive in new condition.

        Raises:
            PluginError: If the simulator fails.
        """
        theta = tuple(self.prior.sample(1, rng)[0].tolist())
        simulator = self.plugin.load()
        try:
            drawn = simulator.beside(rng) if hasattr(simulator, "beside") else {}
            beside = {str(name): float(value) for name, value in drawn.items()}
        except FAULTS as error:
            raise self.plugin.failed("cannot draw what a drive has beside", error) from error
        return OwnDrive(theta, Elements(), beside=beside)

    def worn(self, drive: OwnDrive, rng: np.random.Generator, kind: str = "") -> OwnDrive:
        """Draw a worn condition of a drive: as ``Family.worn``, of what the drive has."""
        wear = dict(self.settings["wear"])
        try:
            stated = dict(getattr(self.plugin.load(), "WEAR", {}))
            own = {name: (float(least), float(most)) for name, (least, most) in stated.items()}
        except (TypeError, ValueError) as error:
            raise self.plugin.failed("has WEAR that is no range by name", error) from error
        if unknown := own.keys() - drive.beside.keys():
            raise self.plugin.failed(
                f"has WEAR of {', '.join(sorted(unknown))}, which beside lacks"
            )
        wear["change"] = {n: each for n, each in wear["change"].items() if n in NAMES} | own
        wear["kinds"] = {
            name: {**each, "elements": [min(count, len(own)) for count in each["elements"]]}
            for name, each in wear["kinds"].items()
        }
        return Family(self.prior, {**self.settings, "wear": wear}).worn(drive, rng, kind)

    def followed(
        self, drive: OwnDrive, end: float, beyond: float
    ) -> list[tuple[np.ndarray, float]]:
        """Return the motions of a drive, as its simulator ends them: see ``Family.followed``.

        Raises:
            FloatingPointError: If the simulator says that the drive does not work.
            PluginError: If it raises anything else, or returns no curve.
        """
        parameters, found = dict(zip(NAMES, drive.theta, strict=True)), []
        for motion in MOTIONS:
            try:
                curve = self.plugin.load().curve(parameters, dict(drive.beside), motion)
                time, travel, switching = curve
                found.append((_steps(time, travel), float(switching)))
            except FloatingPointError:
                raise
            except FAULTS as error:
                raise self.plugin.failed(f"returns no curve of {motion}", error) from error
        return found


def _steps(time: Sequence[float], travel: Sequence[float]) -> np.ndarray:
    """Samples ``(t,)`` as steps ``(t, 8)`` of ``integrator.follow``, by a spline between rests.

    Raises:
        ValueError: If they are no curve from a first motion at 0 on.
    """
    from scipy.interpolate import CubicSpline

    time, travel = (np.asarray(each, dtype=np.float64) for each in (time, travel))
    if time.ndim != 1 or time.shape != travel.shape or time.size < _FEWEST:
        raise ValueError(f"times {time.shape} and travel {travel.shape}: {_FEWEST} or more of each")
    if not (time[0] == 0.0 and np.all(np.diff(time) > 0.0) and np.isfinite(time[-1])):
        raise ValueError("its times do not rise from 0")
    if not np.isfinite(travel).all():
        raise ValueError("its travel is not finite")
    line = CubicSpline(time, travel, bc_type="clamped")
    ends = np.column_stack([travel, line(time, 1), line(time, 2)])
    moving = np.column_stack([time[:-1], np.diff(time), ends[:-1], ends[1:]])
    rest = np.array([time[-1], _LONG, travel[-1], 0.0, 0.0, travel[-1], 0.0, 0.0])
    return np.vstack([moving, rest])
