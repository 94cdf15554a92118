"""Resistance of the contact: planted levels, units, and what is withheld."""

from dataclasses import replace

import numpy as np
import pytest

from breaker.model.parameters import MOTIONS
from breaker.model.quantities import RESISTANCES
from breaker.records.currents import Currents
from breaker.records.rejections import NotShownError
from tests.records.contact_signals import Case, random_case


def planted(case, seed):
    """Medians of the resistance without noise, µΩ: at rest, and between both contacts."""
    case = replace(case, rng=np.random.default_rng(seed), noise=0.0)
    alone = (case.own > case.main) & (case.own < case.arcing)
    rest = case.own < (case.begins - 1.0 if case.motion == "opening" else 25.0)
    exact = 1e3 * case.resistance()
    return [float(np.median(exact[part])) for part in (rest, alone)]


def currents(case, ohms, current=None, size=1e3):
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
        read = currents(case, case.resistance(), case.current() if flows else None)
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
        (RESISTANCES, currents(case, ohms, flows, size=np.nan)),
        (RESISTANCES, currents(case, 0.0 * ohms + 10.0, flows)),
        (RESISTANCES, currents(case, ohms, 0.0 * flows)),
        (["arcing_resistance"], currents(case, beyond, flows)),
    ):
        for name in names:
            with pytest.raises(NotShownError):
                getattr(read, name)()
    assert currents(case, beyond, flows).static_resistance()[0] == pytest.approx(50.0)
