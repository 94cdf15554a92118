"""The bank of a family, and its rows: what training sees of drives is what records show."""

import numpy as np
import pytest

from breaker.family.bank import GRID, shapes
from breaker.family.networks import WEARING, open_network
from breaker.family.rich_drive import CONTACTS, ELEMENTS, Drive, Elements
from breaker.family.training_rows import rows_of, sample_rows
from breaker.model.parameters import MOTIONS
from breaker.shipped import KINDS, model_file

DRIVES, BOTH = 160, np.array([[True, True]])


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


@pytest.fixture(scope="module")
def networks():
    return {kind: open_network(model_file("medium_voltage", kind)) for kind in KINDS}


@pytest.fixture(scope="module")
def rows(bank, networks):
    return {kind: rows_of(kind, bank, network) for kind, network in networks.items()}


def test_levels_are_logarithms_in_the_units_of_the_record(rows, bank):
    x, y, there, units = rows["levels"].unscaled(np.arange(DRIVES), np.random.default_rng(1), BOTH)
    assert np.isfinite(x).all()
    assert there.all()
    theta = np.exp(y + units)[:, None, :7]  # of either condition
    off = np.abs(theta / bank.parameters.values - 1.0).max(axis=2)
    assert off.min(axis=1).max() < 1e-9
    events = y[:, 7:11].reshape(-1, 2, 2)
    assert (np.diff(events, axis=2) > 0.0).all()  # contacts switch after the start of motion


def test_without_wear_nothing_changes_and_a_change_back_is_the_reverse(networks, bank):
    y, back = (
        rows_of("changes", bank, networks["changes"], back=back).unscaled(
            np.arange(DRIVES), np.random.default_rng(1)
        )[1]
        for back in (0.0, 1.0)
    )
    np.testing.assert_allclose(y[:, :7], -back[:, :7], atol=1e-12)
    worn = bank.wear.values > 0
    assert (y[~worn] == 0.0).all()
    ratio = bank.parameters.values[:, 1] / bank.parameters.values[:, 0]
    np.testing.assert_allclose(y[:, :7], np.log(ratio), atol=1e-12)
    assert (y[worn, 7:] != 0.0).any()


@pytest.mark.parametrize("source", [*MOTIONS, "both"])
def test_shipped_networks_cover_drives_they_have_not_seen(rows, networks, source):
    """90 % intervals of 160 drives contain at least 80 %: fewer have a probability below 1e-4 each.

    Planted fault: draws of one drive for another.
    """
    rng = np.random.default_rng(4)
    data = sample_rows(networks["levels"], rows["levels"], source, 200, rng)
    draws, truth = data.draws.values, data.truth.values

    def covered(draws):
        low, high = np.quantile(draws, [0.05, 0.95], axis=1)
        return ((truth >= low) & (truth <= high)).mean(axis=0)

    assert (covered(draws) > 0.8).all()
    assert covered(np.roll(draws, 1, axis=0)).min() < 0.75
    data = sample_rows(networks["changes"], rows["changes"], source, 100, rng)
    assert data.sizes["output"] == 7 + (1 if source != "both" else 2) + len(WEARING)
    assert (data.truth.values[:, 1:7] > -50.0).all()
