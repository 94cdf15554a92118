"""Current of the coil, and the resistance of the contact, against planted ones."""

from dataclasses import replace

import numpy as np
import pytest

from breaker.model.parameters import MOTIONS
from breaker.model.quantities import CURRENTS, RESISTANCES
from breaker.records.contacts import ContactTimes
from breaker.records.currents import Currents
from breaker.records.rejections import NotShownError
from tests.records.contact_signals import Case, random_case

STEP = 0.1  # ms
TIME = np.arange(0.0, 120.0, STEP)
TRIGGER, DIP, OFF, PEAK = 10.0, 24.0, 50.0, 3.0  # ms, A


def coil(time=TIME, depth=0.25, peak=PEAK):
    """A current that rises with 6 ms, loses a share of itself from 18 ms to the armature's arrival,
    and is broken with 0.3 ms.
    """
    on = np.clip(time - TRIGGER, 0.0, None)
    rise = 1.0 - np.exp(-on / 6.0)
    moving = np.clip((time - 18.0) / (DIP - 18.0), 0.0, 1.0)
    lost = depth * np.where(time <= DIP, moving**2, np.exp(-(time - DIP) / 4.0))
    fall = np.where(time > OFF, np.exp(-np.clip(time - OFF, 0.0, None) / 0.3), 1.0)
    return peak * (rise - lost) * fall


def currents(values, **more):
    contact = ContactTimes(trigger=TRIGGER, trigger_sd=0.05)
    about = {"sizes": {"trigger": 1.0}, "moves": 30.0, "contact": contact} | more
    return Currents(TIME, {"trigger": values}, **about)


def test_a_coil_is_read_as_its_circuit_made_it():
    """In 100 draws of noise of 1 %, the mean square of the errors of each of three values, in sds,
    is below 2 (chance of more: 1e-9 for normal errors).
    """
    rng, clean, errors = np.random.default_rng(1), coil(), []
    truth = {"coil_current": clean.max()}  # that of the rise, at 50 ms
    truth |= {"coil_dip_time": DIP - TRIGGER, "coil_off_time": OFF - TRIGGER}
    for k in range(100):
        values = clean + 0.01 * PEAK * rng.standard_normal(TIME.size)
        read = currents(0.2 + (-1.0) ** k * values)  # of any sign and offset
        result = {name: getattr(read, name)() for name in truth}
        errors.append([(value - truth[name]) / sd for name, (value, sd) in result.items()])
    assert np.mean(np.square(errors), axis=0).max() < 2.0


NOISE = 0.02 * np.random.default_rng(2).standard_normal(TIME.size)
HELD = np.where(TIME > TRIGGER, coil(peak=2.0)[TIME.searchsorted(49.0)], 0.0)


@pytest.mark.parametrize(
    ("name", "read"),
    [
        ("coil_dip_time", currents(coil(depth=0.0))),
        ("coil_dip_time", currents(coil(depth=0.0) + NOISE)),  # by noise, in one of 1e6 records
        ("coil_off_time", currents(HELD)),
        ("coil_current", currents(NOISE)),
        ("coil_current", currents(coil(), sizes={"trigger": np.nan})),  # it states no unit
        ("coil_current", currents(np.where(TIME < 100.0, np.nan, coil()), inside=slice(900))),
        ("coil_current", currents(coil(), contact=ContactTimes())),
        *[(name, currents(np.nan * TIME)) for name in CURRENTS],
    ],
)
def test_what_a_current_does_not_show_is_withheld(name, read):
    with pytest.raises(NotShownError):
        getattr(read, name)()


# ---- resistances ---------------------------------------------------------------------------------


def planted(case, seed):
    """Medians of the resistance without noise, µΩ: at rest, and between both contacts."""
    case = replace(case, rng=np.random.default_rng(seed), noise=0.0)
    alone = (case.own > case.main) & (case.own < case.arcing)
    rest = case.own < (case.begins - 1.0 if case.motion == "opening" else 25.0)
    exact = 1e3 * case.resistance()
    return [float(np.median(exact[part])) for part in (rest, alone)]


def read_of(case, ohms, current=None, size=1e3):
    channels = {"contact": ohms} | ({} if current is None else {"current": current})
    about = case.motion, slice(None), case.located().moves, case.read(ohms, current)
    return Currents(case.time, channels, {"contact": size, "current": np.nan}, *about)


@pytest.mark.parametrize("flows", [True, False])
def test_planted_resistances_are_found(flows):
    """Of 200 simulated records, the mean square of the errors of either quantity, in sds, is below
    4: eight medians know their own spread to a quarter, and a time of the contact may be off.
    """
    rng, errors = np.random.default_rng(3), {name: [] for name in RESISTANCES}
    for seed in range(200):
        case = random_case(rng)
        truth = dict(zip(RESISTANCES, planted(case, seed), strict=True))
        case.rng = np.random.default_rng(seed)
        read = read_of(case, case.resistance(), case.current() if flows else None)
        for name, value in truth.items():
            try:
                median, sd = getattr(read, name)()
            except NotShownError:
                continue
            errors[name].append((median - value) / max(sd, 0.002 * value))
            assert median == pytest.approx(value, rel=0.2)
    assert min(map(len, errors.values())) > 140
    for error in errors.values():
        assert np.mean(np.square(error)) < 4.0


@pytest.mark.parametrize("motion", MOTIONS)
def test_what_a_resistance_does_not_show_is_withheld(motion):
    """Planted faults: no unit, a lead that is off, no current, and an arcing contact beyond."""
    case = Case(np.random.default_rng(5), motion)
    ohms, flows = case.resistance(), case.current()
    beyond = np.where(case.own < case.main, 0.05, 4.0)
    for names, read in (
        (RESISTANCES, read_of(case, ohms, flows, size=np.nan)),
        (RESISTANCES, read_of(case, 0.0 * ohms + 10.0, flows)),
        (RESISTANCES, read_of(case, ohms, 0.0 * flows)),
        (["arcing_resistance"], read_of(case, beyond, flows)),
    ):
        for name in names:
            with pytest.raises(NotShownError):
                getattr(read, name)()
    assert read_of(case, beyond, flows).static_resistance()[0] == pytest.approx(50.0)
