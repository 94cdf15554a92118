"""The richer drive: the model where it has nothing more, and an independent solver elsewhere."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from breaker.family.rich_drive import SIZES, Drive, Elements, Stop, Waves
from breaker.model.curves import travel
from breaker.model.parameters import MOTIONS, Size

TIMES = np.linspace(-2.0, 58.0, 151)
THETA = (2.0, 0.045, 0.040, 0.30, 0.12, 0.75, 10.0)
QUICK = (1.5, 0.035, 0.055, 0.18, 0.06, 0.85, 9.5)
FAMILY = Elements(
    lever_turn=0.4,
    lever_lean=0.2,
    dry_friction=0.02,
    opening_preload=0.02,
    contact_preload=0.03,
    build_up=0.3,
    train_mass=0.1,
    train_friction=0.12,
    restitution=0.2,
    closing_stop=Stop(reach=1.0, damping=1.5, power=2.0, depth=0.3, stiffness=0.1),
    opening_stop=Stop(reach=3.0, damping=0.3, power=1.5, depth=0.3, stiffness=0.1),
)
SHARP = Elements(
    dry_friction=0.03,
    restitution=0.25,
    closing_stop=Stop(reach=0.3, damping=3.0, power=1.0, depth=0.1, stiffness=0.3),
    opening_stop=Stop(reach=5.0, damping=0.6, power=3.0, depth=0.1, stiffness=0.3),
)
WILD = Elements(
    linkage=0.2,
    build_up=0.4,
    way_force=Waves(0.05, (0.5, -0.6, 0.4, 0.7, -0.7, 0.4)),
    time_force=Waves(0.05, (0.3, 0.9, -0.5, 0.3, 0.8, -0.1)),
    speed_force=Waves(0.05, (-0.9, 0.2, 0.4, -0.6, 0.3, 0.7)),
)
LAWS = replace(
    FAMILY,
    force_fall=0.1,
    drag=0.05,
    drag_power=1.5,
    growth=2.5,
    stick=1.0,
    slip=0.3,
    load=0.7,
    opening_progress=0.1,
    reading=Waves(0.1, (0.6, -0.5, 0.8, -0.3, 0.5, -0.6)),
    closing_stop=replace(FAMILY.closing_stop, profile=2.0),
    opening_stop=replace(FAMILY.opening_stop, profile=-1.5),
)
FLYING = Elements(contact="held", contact_preload=0.05, build_up=0.1)
HELD = replace(FAMILY, contact="held", contact_preload=0.2, lever_turn=0.2)
SLIDING = replace(WILD, contact="sliding", train_mass=0.3, linkage=0.0)
SETS = {
    "family": FAMILY,
    "sharp": SHARP,
    "wild": WILD,
    "laws": LAWS,
    "laws on a linkage": replace(LAWS, linkage=1.5),
    "friction from rest on": replace(LAWS, friction_speed=0.001),
    "held": HELD,
    "flying": FLYING,
    "sliding": SLIDING,
}


class Reference:
    """The same mechanics by ``solve_ivp``, written anew from the description of the elements."""

    def __init__(self, drive: Drive, motion: str) -> None:
        self.mu, self.k_a, self.k_b, self.gamma_a, self.gamma_b, self.f, self.gap = drive.theta
        self.has, self.closing = drive.elements, motion == "closing"
        self.rest, self.switches = np.inf, np.inf
        low, high = 0.0, 50.0
        for _ in range(100):
            middle = 0.5 * (low + high)
            pull = self.forces(1e9, [middle, 0.0, self.gap, 0.0], self.f)[0]
            low, high = (middle, high) if pull > 0 else (low, middle)
        self.rest = low

    def lever(self, arc):
        has = self.has
        if not has.lever_turn:
            return arc * np.cos(has.lever_lean), np.cos(has.lever_lean)
        radius = 10.0 / has.lever_turn
        turn = arc / radius - has.lever_lean
        return radius * (np.sin(turn) + np.sin(has.lever_lean)), np.cos(turn)

    @staticmethod
    def stop(stop, beyond, speed):
        damper = 0.0
        if beyond > -stop.reach:
            grows = min(1.0, (beyond + stop.reach) / stop.depth)
            share = min(1.0, (beyond + stop.reach) / stop.reach) if stop.reach else 1.0
            grows *= np.exp(stop.profile * share) / max(1.0, np.exp(stop.profile))
            damper = stop.damping * grows * np.sign(speed) * np.abs(speed) ** stop.power
        return max(0.0, stop.stiffness * max(0.0, beyond) + damper)

    @staticmethod
    def waves(waves, angle):
        a = np.reshape(waves.harmonics, (3, 2))
        turns = angle * np.arange(1, 4)
        return waves.share * float((a[:, 0] * np.sin(turns) + a[:, 1] * np.cos(turns)).sum())

    def read(self, x):
        """What the transducer shows of a travel, and the slope of that."""
        has, stroke, k = self.has.reading, self.lever(self.rest)[0], np.arange(1, 7)
        turns, sizes = np.multiply.outer(x, k * np.pi / stroke), has.share * np.array(has.harmonics)
        way = (sizes / k**2 * np.sin(turns)).sum(axis=-1) * stroke / np.pi
        return x + way, 1.0 + (sizes / k * np.cos(turns)).sum(axis=-1)

    def random(self, time, arc, speed):
        way, in_time, by_speed = (
            getattr(self.has, f"{name}_force") for name in ("way", "time", "speed")
        )
        built = 1.0 - self.left(time)
        total = built * self.waves(in_time, time / 4.0) * time / 4.0 * np.exp(1.0 - time / 4.0)
        if 0 < arc < self.rest:
            angle = np.pi * arc / self.rest
            total += np.sin(angle) ** 2 * self.waves(way, angle)
        total += speed**2 / (1 + speed**2) * self.waves(by_speed, np.pi / 2 * abs(speed))
        return total * (self.f if self.closing else self.k_a * self.rest)

    def left(self, time):
        """Share of the closing force that is left after the release of an opening."""
        has = self.has
        return np.exp(-((max(0.0, time) / has.build_up) ** has.growth)) if has.build_up else 0.0

    def forces(self, time, state, force=None, held=True):
        has = self.has
        arc, speed, contact, contact_speed = state[:4]
        x, ratio = self.lever(arc)
        over = x - contact
        if has.contact == "elastic" or held == "flying":
            spring = self.k_b * over + self.gamma_b * (ratio * speed - contact_speed)
            smooth = 1.0 if held == "flying" else np.tanh(over / 0.3)
            spring += has.contact_preload * smooth
        else:
            pressed = self.k_b * (x - self.gap) + self.gamma_b * ratio * speed + has.contact_preload
            spring = pressed if has.contact == "held" and held else 0.0
        if force is None:
            left = self.left(time)
            force = self.f * ((1.0 - left) if self.closing else left)
        total = force * (1.0 - has.force_fall * x / 10.0) - ratio * spring
        total -= self.k_a * arc * (1.0 + has.opening_progress * arc / 10.0)
        dry = has.dry_friction * (1.0 + has.stick * np.exp(-abs(speed) / has.slip))
        load = min((self.k_a * abs(arc) + abs(spring)) / self.f, 1.5)
        dry *= 1.0 - has.load + has.load * load
        dry *= np.tanh(speed / has.friction_speed)
        total -= has.opening_preload * np.tanh(arc / 0.3) + dry
        total -= self.gamma_a * (1.0 + has.train_friction * self.closing) * speed
        total -= has.drag * np.sign(speed) * abs(speed) ** has.drag_power
        if np.isfinite(self.rest):
            total += self.random(time, arc, speed)
            total -= self.stop(has.closing_stop, arc - self.rest, speed)
            total += self.stop(has.opening_stop, -arc, -speed)
        return total, spring

    def acceleration(self, time, s, held):
        """Of the drive, and of an elastic contact."""
        total, spring = self.forces(time, s, held=held)
        mass = 1.0 + self.has.train_mass * self.closing
        if self.has.contact == "held" and not held:  # contact and drive move as one
            step = 1e-5
            slopes = [self.lever(s[0] + way)[1] for way in (-step, step)]
            ratio, bend = np.mean(slopes), (slopes[1] - slopes[0]) / (2 * step)
            return (total - ratio * bend * s[1] ** 2 / self.mu) / (mass + ratio**2 / self.mu), 0.0
        return total / mass, self.mu * spring

    def switched(self, state, held):
        """The state after a touch or a separation, and whether the contact stays closed."""
        kind, mass = self.has.contact, 1.0 + self.has.train_mass * self.closing
        if kind == "held" and held:
            x, ratio = self.lever(state[0])
            if held is True and x > self.gap + 1e-6:  # no force is left: the contact flies
                return state, "flying"
            both = mass * state[1] + ratio * state[3] / self.mu
            state[1], state[2] = both / (mass + ratio**2 / self.mu), self.gap
            return state, False
        back = -self.has.restitution * state[3] if kind == "elastic" and not held else 0.0
        bounces = back < -0.02
        state[2], state[3] = self.gap, back if bounces else 0.0
        return state, not held and not bounces

    def travel(self, times):
        kind = self.has.contact
        x0 = 0.0 if self.closing else self.rest
        y0 = self.lever(x0)[0]
        state = np.array([x0, 0.0, 0.0 if self.closing else self.gap, 0.0, y0, 0.0])
        result, now, held = np.full(len(times), y0), 0.0, not self.closing
        while now < times[-1]:

            def rates(time, s, held=held):
                accelerations = self.acceleration(time, s, held)
                x, ratio = self.lever(s[0])
                x, slope = self.read(x)
                ratio = ratio * slope
                rate = 2 * np.pi / self.has.linkage if self.has.linkage else 1.0
                ringing = rate**2 * (x - s[4]) + 0.1 * rate * (ratio * s[1] - s[5])
                free = held == "flying" or (kind == "elastic" and not held)
                moves = (s[3], accelerations[1]) if free else (0.0, 0.0)
                return [s[1], accelerations[0], *moves, s[5], ringing]

            def leaves(time, s, held=held):
                if kind == "elastic":
                    return self.forces(time, s)[1] if held else self.gap - s[2]
                x = self.lever(s[0])[0]
                if held == "flying":
                    return x - s[2]
                if held:
                    force = self.forces(time, s)[1] if kind == "held" else np.inf
                    return min(x - self.gap, force)
                return self.gap - x

            leaves.terminal, leaves.direction = True, -1
            watched = bool(held) != self.closing or (kind == "held" and (self.closing or held))
            part = solve_ivp(
                rates,
                (now, times[-1]),
                state,
                method="DOP853",
                rtol=1e-9,
                atol=1e-10,
                max_step=0.5,
                events=leaves if watched else None,
                dense_output=True,
            )
            here = (times > now) & (times <= part.t[-1])
            if here.any():
                arcs = part.sol(times[here])
                travel = self.read(self.lever(arcs[0])[0])[0]
                result[here] = arcs[4] if self.has.linkage else travel
            now, state = part.t[-1], part.y[:, -1].copy()
            if part.status == 1:
                self.switches = min(self.switches, now)
                state, held = self.switched(state, held)
        return result


@pytest.mark.parametrize("motion", MOTIONS)
def test_without_elements_it_is_the_model(motion):
    result, plain = travel(np.array([QUICK]), TIMES, motion), Drive(QUICK, Elements())
    exact, (switching,) = result.travel[0], result.switching
    curve, switches = plain.operate(motion, TIMES)
    np.testing.assert_allclose(curve, exact, atol=1e-6)
    assert switches == pytest.approx(switching, abs=1e-5)
    assert plain.operate(motion, TIMES[switching > TIMES])[1] == np.inf  # too short
    none = Drive(QUICK, FAMILY.scaled(dict.fromkeys(SIZES, 0.0)))
    np.testing.assert_allclose(none.travel(motion, TIMES), exact, atol=1e-6)


@pytest.mark.parametrize("motion", MOTIONS)
@pytest.mark.parametrize("name", SETS)
def test_it_agrees_with_another_solver_to_a_micrometre(motion, name):
    """The contact, too, by its first touch or its separation."""
    drive = Drive(QUICK, SETS[name])
    reference = Reference(drive, motion)
    curve, switches = drive.operate(motion, TIMES)
    np.testing.assert_allclose(curve, reference.travel(TIMES), rtol=0, atol=1e-3)
    assert switches == pytest.approx(reference.switches, abs=1e-3)


@pytest.mark.parametrize("name", ["laws on a linkage", "held", "sliding"])
def test_a_drive_of_another_size_moves_alike(name):
    drive, size = Drive(THETA, SETS[name]), Size(lengths=12.0, times=3.0)
    for motion in MOTIONS:
        curve, switches = drive.operate(motion, TIMES)
        large, later = drive.scaled(size).operate(motion, 3.0 * TIMES)
        np.testing.assert_allclose(large, 12.0 * curve, atol=1e-6)
        assert later == pytest.approx(3.0 * switches)


@pytest.mark.parametrize("period", [1e-3, 0.2])
def test_no_linkage_is_too_stiff(period):
    rigid = Drive(THETA, SHARP).travel("closing", TIMES)
    reads = Drive(THETA, replace(SHARP, linkage=period)).travel("closing", TIMES)
    # Of an acceleration a it is behind by a (period / 2 pi)^2; none here is above 15 mm/ms^2.
    np.testing.assert_allclose(reads, rigid, rtol=0, atol=30.0 * (period / (2 * np.pi)) ** 2)


def test_a_drive_that_holds_no_closed_position_is_refused():
    assert Drive(THETA, FAMILY).holds
    halfway = Waves(0.8, (-1.0, 0.0, 0.0, 0.0, 0.0, 0.0))  # against the closing
    for refused in (
        Drive((2.0, 0.045, 0.040, 0.30, 0.12, 0.4, 10.0), Elements()),  # weak
        Drive(THETA, Elements(way_force=halfway)),
        Drive(THETA, Elements(lever_turn=1.4)),  # past the dead centre of its lever
        Drive(THETA, Elements(contact="held", contact_preload=0.31)),  # more than f - k_a L
    ):
        assert not refused.holds
        with pytest.raises(ValueError, match="press"):
            refused.travel("opening", TIMES)
    stiff = Stop(reach=1.0, damping=1e308, power=3.0, depth=0.1)
    with pytest.raises(FloatingPointError):
        Drive(THETA, Elements(closing_stop=stiff)).travel("closing", TIMES)
