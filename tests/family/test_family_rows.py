"""Rows of a family's bank: what training sees of drives is what their records show."""

import numpy as np
import pytest

from breaker.configuration.definitions import family_of
from breaker.configuration.loading import load
from breaker.family.bank import GRID, shapes, simulate_family
from breaker.family.drive_family import Family
from breaker.family.network_files import open_network
from breaker.family.networks import WEARING
from breaker.family.training_records import _samples, _Sensor
from breaker.family.training_rows import rows_of, sample_rows
from breaker.model.parameters import MOTIONS
from breaker.model.prior import Prior
from breaker.shipped import model_file


@pytest.fixture(scope="module")
def bank():
    config = load()
    family = Family(Prior.from_settings(config["prior"]), family_of(config["family"]["name"]))
    return simulate_family(family, 160, np.random.default_rng(2))


@pytest.fixture(scope="module")
def levels(bank):
    return rows_of("levels", bank, open_network(model_file("medium_voltage", "levels")))


@pytest.fixture(scope="module")
def changes(bank):
    return rows_of("changes", bank, open_network(model_file("medium_voltage", "changes")))


def test_levels_are_logarithms_in_the_units_of_the_record(levels, bank):
    drives = np.arange(40)
    condition = np.zeros(40, dtype=int)
    x, y, there, units = levels.unscaled(drives, np.random.default_rng(1), condition=condition)
    assert np.isfinite(x).all()
    np.testing.assert_allclose(np.exp(y + units)[:, :7], bank.parameters.values[:40, 0])
    assert there[:, :7].all()
    assert 0 < there[:, 7:].sum() < there[:, 7:].size


def test_touch_comes_after_the_release(levels):
    both = np.ones((160, 2), dtype=bool)
    _, y, _, _ = levels.unscaled(np.arange(160), np.random.default_rng(1), motions=both)
    events = y[:, 7:11].reshape(-1, 2, 2)
    assert (np.diff(events, axis=2) > 0.0).all()


def test_readings_come_in_their_steps(bank):
    curve, out = shapes(bank["shape"].values)[0, 0, 0], np.empty(30)
    sensor = _Sensor(begin=-1.0, step=0.1, noise=0.0, colour=0.0, quantum=0.25)
    _samples(curve, np.random.default_rng(1), sensor, out)
    exact = np.interp(-1.0 + 0.1 * np.arange(30), GRID, curve)
    assert np.abs(out - exact).max() < 0.5 * 0.25 + 0.01
    np.testing.assert_array_equal(out % 0.25, 0.0)


def test_what_has_not_worn_has_not_changed_and_a_change_back_is_the_other_way_round(changes, bank):
    y, back = (
        changes.unscaled(np.arange(160), np.random.default_rng(1), back=back)[1]
        for back in (0.0, 1.0)
    )
    np.testing.assert_allclose(y[:, :7], -back[:, :7], atol=1e-12)
    worn = bank.wear.values > 0
    assert (y[~worn] == 0.0).all()
    ratio = bank.parameters.values[:, 1] / bank.parameters.values[:, 0]
    np.testing.assert_allclose(y[:, :7], np.log(ratio), atol=1e-12)
    assert (y[worn, 7:] != 0.0).any()


def test_a_curve_that_no_record_shows_is_not_there(levels, bank):
    strange = bank.isel(drive=slice(4)).copy(deep=True)
    strange["shape"][1, :, 0] = 14564  # at rest from end to end
    rows = rows_of("levels", strange, open_network(model_file("medium_voltage", "levels")))
    both = np.ones((4, 2), dtype=bool)
    x, _, there, _ = rows.unscaled(np.arange(4), np.random.default_rng(1), motions=both)
    assert np.isfinite(x).all()
    assert not there[1, 7:9].any()
    assert there[1, 9:].all()
    assert there[[0, 2, 3]].all()


@pytest.mark.parametrize("source", [*MOTIONS, "both"])
def test_networks_that_ship_know_drives_they_have_not_seen(levels, changes, source):
    """90 % intervals of 160 drives hold at least 80 %: fewer have a probability below 1e-4 each.

    Planted fault: draws of one drive for another.
    """
    rng = np.random.default_rng(4)
    network = open_network(model_file("medium_voltage", "levels"))
    data = sample_rows(network, levels, source, 200, rng)
    draws, truth = data.draws.values, data.truth.values

    def held(draws):
        low, high = np.quantile(draws, [0.05, 0.95], axis=1)
        return ((truth >= low) & (truth <= high)).mean(axis=0)

    assert (held(draws) > 0.8).all()
    assert held(np.roll(draws, 1, axis=0)).min() < 0.75
    network = open_network(model_file("medium_voltage", "changes"))
    data = sample_rows(network, changes, source, 100, rng)
    assert data.sizes["output"] == 7 + (1 if source != "both" else 2) + len(WEARING)
    assert (data.truth.values[:, 1:7] > -50.0).all()
