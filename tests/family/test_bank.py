"""The bank of a family: every number of it against the drive that it is of."""

import numpy as np
import pytest

from breaker.configuration.definitions import family_of
from breaker.family.bank import GRID, shapes, simulate_family
from breaker.family.drive_family import Family
from breaker.family.rich_drive import CONTACTS, ELEMENTS, Drive, Elements
from breaker.model.parameters import MOTIONS

DRIVES = 300


@pytest.fixture(scope="module")
def family(prior) -> Family:
    return Family(prior, family_of("medium_voltage"))


@pytest.fixture(scope="module")
def bank(family):
    return simulate_family(family, DRIVES, np.random.default_rng(1))


def drive_of(row) -> Drive:
    """A drive, put together from the names of its elements."""
    settings = {"contact": CONTACTS[int(row.elements.sel(element="contact"))]}
    for name, value in zip(ELEMENTS, row.elements.values.tolist(), strict=True):
        part, _, of = name.partition(".")
        if of.startswith("harmonics"):
            settings[part]["harmonics"] = (*settings[part].get("harmonics", ()), value)
        elif of:
            settings.setdefault(part, {})[of] = value
        else:
            settings.setdefault(part, value)
    return Drive(tuple(row.parameters.values.tolist()), Elements.from_settings(settings))


@pytest.mark.parametrize("number", range(2))
def test_a_curve_is_that_of_the_drive(bank, number):
    """Put together again from shape, stroke and duration; and its events."""
    for condition in range(2):
        row = bank.isel(drive=number, condition=condition)
        drive, curves = drive_of(row), shapes(row["shape"].values)
        for m, motion in enumerate(MOTIONS):
            one, stroke = row.isel(motion=m), float(row.stroke)
            times = float(one.duration) * (GRID - float(one.release))
            curve, switches = drive.operate(motion, times)
            begin = 0.0 if motion == "closing" else stroke
            np.testing.assert_allclose(abs(curve - begin), abs(stroke * curves[m]), atol=2e-3)
            if switches < np.inf:
                later = float(one.duration) * float(one.switching - one.release)
                assert later == pytest.approx(switches, abs=1e-4)
            levels = np.interp([0.0, 1.0], GRID, curves[m])
            np.testing.assert_allclose(levels, [0.1, 0.5], atol=1e-3)
            assert curves[m][float(one.release) > GRID] == pytest.approx(0.0, abs=1e-4)
