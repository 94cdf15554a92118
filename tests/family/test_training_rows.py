"""Rows of a family's bank: what training sees of drives is what their records show."""

import numpy as np
import pytest

from breaker.configuration.definitions import family_of
from breaker.configuration.loading import load
from breaker.family.bank import simulate_family
from breaker.family.drive_family import Family
from breaker.family.networks import WEARING, open_network
from breaker.family.training_rows import rows_of, sample_rows
from breaker.model.parameters import MOTIONS
from breaker.model.prior import Prior
from breaker.shipped import KINDS, model_file

DRIVES, BOTH = 160, np.array([[True, True]])


@pytest.fixture(scope="module")
def bank():
    config = load()
    family = Family(Prior.from_settings(config["prior"]), family_of(config["family"]["name"]))
    return simulate_family(family, DRIVES, np.random.default_rng(2))


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
