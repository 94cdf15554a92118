"""A synthetic endurance test: a richer mechanism than the model, wearing out.

Stands in for the paper's endurance test, which is not public (paper, Sec. 7). The rig is what the
two-mass model leaves out: a rotary lever whose ratio changes along the stroke, dry friction, and
at both ends of the stroke a damper, with a return spring, that acts one way. Closing also moves the
closing train (spring, shaft and cam), whose mass and friction opening is free of. It is
integrated with ``solve_ivp``, wears out over its life, has a sensor of its own and writes the CSV
files of an instrument. Its rates of wear are assumptions.

Units: kg, mm, ms, hence kN, kN/mm and kN ms/mm.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import cos, sin, tanh
from pathlib import Path

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from tqdm import tqdm

from breaker.model import generator
from breaker.records import write_curve

__all__ = ["Lever", "Mechanism", "Rig", "Stop"]

_TOLERANCES = {"rtol": 1e-8, "atol": 1e-9}


@dataclass(frozen=True)
class Stop:
    """A damper at one end of the stroke, pushing back only.

    Attributes:
        position: Where on the lever's arc it begins to act, mm.
        stiffness: Its return spring, kN/mm.
        damping: Its force at 1 mm/ms, kN.
        depth: Way over which the damping comes in, mm.
        power: Power of the speed with which the damping grows: 1 viscous, 2 an orifice, more a
            throttle that closes with the flow.

    Example:
        >>> Stop(position=13.0, stiffness=0.5, damping=2.0, depth=0.1).force(way=1.0, speed=3.0)
        6.5
    """

    position: float
    stiffness: float
    damping: float
    depth: float
    power: float = 1.0

    def force(self, way: float, speed: float) -> float:
        """Force against going further in, kN; ``way`` mm beyond the position, ``speed`` inwards."""
        if way <= 0.0:
            return 0.0
        damper = self.damping * min(1.0, way / self.depth) * speed * abs(speed) ** (self.power - 1)
        return max(0.0, self.stiffness * way + damper)


@dataclass(frozen=True)
class Lever:
    """The lever between main shaft and pushrod.

    Attributes:
        radius: Length of its arm, mm.
        angle: Angle of the open breaker before the horizontal, rad.
    """

    radius: float
    angle: float

    def travel(self, arc):
        """Travel of the pushrod's drive end, mm, where the arm's end has moved along its arc."""
        return self.radius * (np.sin(arc / self.radius - self.angle) + np.sin(self.angle))

    def ratio(self, arc: float) -> float:
        """Travel per arc, at one point."""
        return cos(arc / self.radius - self.angle)


@dataclass(frozen=True)
class Mechanism:
    """The rig in one condition.

    Attributes:
        drive_mass, contact_mass: Masses, kg, that of the drive taken at the end of the arm.
        opening_spring, contact_spring: kN/mm.
        drive_friction, contact_friction: Viscous, kN ms/mm.
        dry_friction: Of the drive, kN, fully there above ``dry_speed`` mm/ms.
        closing_force: kN, along the arc.
        gap: Contact gap, mm.
        lever: The lever.
        closing_stop, opening_stop: The dampers, on the arc.
        closing_mass, closing_friction: Of the closing train, kg and kN ms/mm: added to those of
            the drive while closing.
    """

    drive_mass: float
    contact_mass: float
    opening_spring: float
    contact_spring: float
    drive_friction: float
    contact_friction: float
    dry_friction: float
    dry_speed: float
    closing_force: float
    gap: float
    lever: Lever
    closing_stop: Stop
    opening_stop: Stop
    closing_mass: float = 0.0
    closing_friction: float = 0.0

    def closed_arc(self) -> float:
        """Arc at rest in the closed position, held by the closing force, mm."""
        rates = self._rates(closed=True, closing=True)

        def acceleration(arc: float) -> float:
            return rates(0.0, np.array([arc, 0.0, self.gap, 0.0]))[1]

        return float(brentq(acceleration, 0.0, self.lever.radius))

    def travel(self, motion: str, times: np.ndarray) -> np.ndarray:
        """Return the travel of the drive, ``(t,)``, mm, at times after the first motion, ms.

        Before 0 the drive rests. Contacts touch and part as in the model: inelastic, and where
        the contact force falls to zero.
        """
        closing = motion == "closing"
        state = [0.0, 0.0, 0.0, 0.0] if closing else [self.closed_arc(), 0.0, self.gap, 0.0]
        arc, begin, end = np.full(len(times), state[0]), 0.0, float(times[-1])
        first = np.searchsorted(times, 0.0, side="right")
        leaves = self._touching if closing else self._parting
        for closed, event in ((not closing, leaves), (closing, None)):
            part = solve_ivp(
                self._rates(closed, closing),
                (begin, end),
                state,
                method="LSODA",
                events=event,
                dense_output=True,
                **_TOLERANCES,
            )
            now = slice(first, np.searchsorted(times, part.t[-1], side="right"))
            if now.start < now.stop:
                arc[now] = part.sol(times[now])[0]
            first, begin, state = now.stop, part.t[-1], part.y[:, -1].tolist()
            if begin >= end:
                break
            state[2], state[3] = self.gap, 0.0
        return self.lever.travel(arc)

    def _parting(self, _: float, state: np.ndarray) -> float:
        """Contact force, kN; ends the closed mode."""
        arc, speed = state[0], state[1]
        over = float(self.lever.travel(arc)) - self.gap
        return self.contact_spring * over + self.contact_friction * self.lever.ratio(arc) * speed

    _parting.terminal = True
    _parting.direction = -1

    def _touching(self, _: float, state: np.ndarray) -> float:
        """How far the contact is past the gap, mm; ends the free mode."""
        return state[2] - self.gap

    _touching.terminal = True
    _touching.direction = 1

    def _rates(self, closed: bool, closing: bool):
        """Right-hand side on plain floats, several times faster than on arrays."""
        force = self.closing_force if closing else 0.0
        mass = self.drive_mass + (self.closing_mass if closing else 0.0)
        friction = self.drive_friction + (self.closing_friction if closing else 0.0)
        radius, angle, low = self.lever.radius, self.lever.angle, sin(self.lever.angle)

        def rates(_: float, state: np.ndarray) -> tuple[float, float, float, float]:
            arc, speed, contact, contact_speed = state.tolist()
            turn = arc / radius - angle
            ratio, travel = cos(turn), radius * (sin(turn) + low)
            push = self.contact_spring * (contact - travel) + self.contact_friction * (
                contact_speed - ratio * speed
            )
            total = (
                force
                - self.opening_spring * arc
                - friction * speed
                - self.dry_friction * tanh(speed / self.dry_speed)
                + ratio * push
                - self.closing_stop.force(arc - self.closing_stop.position, speed)
                + self.opening_stop.force(self.opening_stop.position - arc, -speed)
            )
            if closed:
                return speed, total / mass, 0.0, 0.0
            return speed, total / mass, contact_speed, -push / self.contact_mass

        return rates


@dataclass(frozen=True)
class Rig:
    """The rig, its wear and its sensor.

    Attributes:
        new: The mechanism in new condition.
        settings: The section ``rig`` of the configuration.
        seed: Seed of the configuration.
    """

    new: Mechanism
    settings: Mapping
    seed: int

    @classmethod
    def from_settings(cls, settings: Mapping, seed: int) -> "Rig":
        """Build the rig from the section ``rig`` of the configuration."""
        parts = dict(settings["mechanism"])
        parts["lever"] = Lever(**parts["lever"])
        for stop in ("closing_stop", "opening_stop"):
            parts[stop] = Stop(**parts[stop])
        return cls(Mechanism(**parts), settings, seed)

    def worn(self, operation: int, *, scatter: bool = True) -> Mechanism:
        """Return the mechanism at an operation, counted from 1.

        Each worn setting changes linearly up to the knee, and ``faster`` times as fast after it,
        to its change at the end of life. Operations scatter around that.
        """
        wear = self.settings["wear"]
        life = operation / self.settings["operations"]
        knee, faster = wear["knee"], wear["faster"]
        way = min(life, knee) + faster * max(0.0, life - knee)
        share = way / (knee + faster * (1.0 - knee))
        rng = generator(self.seed, "rig wear", operation)
        changed = {}
        for name, change in wear["change"].items():
            noise = wear["scatter"] * rng.standard_normal() if scatter else 0.0
            changed[name] = getattr(self.new, name) * ((1.0 + change * share) * (1.0 + noise))
        return replace(self.new, **changed)

    def record(self, motion: str, operation: int) -> tuple[np.ndarray, np.ndarray]:
        """Return an operation as the rig's sensor records it: times, ms, and travel, mm."""
        sensor = self.settings["sensor"]
        rng = generator(self.seed, "rig sensor", motion, operation)
        samples = round((sensor["lead"] + sensor["length"]) * sensor["rate"])
        times = np.arange(samples) / sensor["rate"]
        moves = sensor["lead"] + sensor["trigger_sd"] * rng.standard_normal()
        travel = self.worn(operation).travel(motion, times - moves)
        zero = sensor["zero_sd"] * rng.standard_normal()
        return times, travel + zero + sensor["noise_sd"] * rng.standard_normal(samples)

    def run(self, motion: str, folder: str | Path) -> None:
        """Write the curve files of all operations of one motion."""
        Path(folder).mkdir(parents=True, exist_ok=True)
        operations = range(1, self.settings["operations"] + 1)
        for operation in tqdm(operations, desc=f"rig {motion}", mininterval=5, unit="operation"):
            times, travel = self.record(motion, operation)
            file = Path(folder, f"{motion}_{operation:05d}.csv")
            write_curve(file, times, travel, motion=motion, operation=operation)
