"""Drives drawn from the family: their ranges, their parameters, their wear."""

from dataclasses import asdict, replace

import numpy as np
import pytest

from breaker.configuration.data_files import family_of
from breaker.family.drive_family import Family
from breaker.family.rich_drive import SIZES


@pytest.fixture(scope="module")
def family(prior, defaults) -> Family:
    return Family(prior, family_of("medium_voltage"))


@pytest.fixture(scope="module")
def drives(family):
    rng = np.random.default_rng(1)
    return [family.new(rng) for _ in range(1000)]


def flat(section, above=""):
    """Values by dotted name."""
    result = {}
    for name, value in section.items():
        inner = flat(value, f"{above}{name}.") if isinstance(value, dict) else {above + name: value}
        result |= inner
    return result


def test_an_effect_that_no_drive_has_is_refused(family):
    effects = {**family.settings["effects"], "drog": [0.0, 1.0]}
    with pytest.raises(ValueError, match=r"unknown effects: drog\. .*drag"):
        replace(family, settings={**family.settings, "effects": effects})


def test_elements_are_drawn_from_their_ranges(family, drives):
    """Uniform, or uniform in the logarithm where the range has no 0; forces times a strength, and
    in half of the drives none.
    """
    elements = (drive.elements for drive in drives)
    drawn = [flat(asdict(e)) for e in elements if e.contact == "elastic"]  # held: other preloads
    for name, (low, high) in flat(family.settings["effects"]).items():
        values = np.array([item.get(name, item.get(f"{name}.share")) for item in drawn])
        if name in SIZES or name.endswith(("damping", "stiffness")):
            assert np.abs(values).max() <= family.settings["strength"][1] * max(high, -low)
            assert (values == 0.0).mean() == pytest.approx(0.5, abs=0.1), name
            continue
        share = (values - low) / (high - low)
        if low > 0:
            share = np.log(values / low) / np.log(high / low)
        assert share.min() >= 0
        assert share.max() <= 1
        # A mean of 650 uniforms is 0.5 within 0.05 but for 1e-5; the redraws of drives that hold
        # no closed position move it by less than 0.005.
        assert share.mean() == pytest.approx(0.5, abs=0.05)


def test_parameters_are_draws_of_the_prior_in_which_drives_hold(prior, drives):
    z = prior.standardise(np.array([drive.theta for drive in drives]))
    # Means and sds of 1000 draws are within 0.2 and 15 % but for 3e-10 and 2e-11; the condition on
    # a closed position moves them by less than half of that.
    np.testing.assert_allclose(z.mean(0), 0.0, atol=0.2)
    np.testing.assert_allclose(z.std(0), 1.0, atol=0.15)
    assert all(drive.holds for drive in drives)


def test_a_worn_drive_changes_by_shares_and_still_works(family, drives):
    rng = np.random.default_rng(6)
    for drive in drives[:100]:
        worn = family.worn(drive, rng, "sparse")
        assert worn.holds
        assert family.prior.supported(np.array(worn.theta))
        changed = [n for n in family.settings["wear"]["change"] if worn.value(n) != drive.value(n)]
        assert changed
        for name in changed:
            low, high = family.settings["wear"]["change"][name]
            share = worn.value(name) / drive.value(name) - 1
            assert min(low, 0.0) - 1e-12 <= share <= max(high, 0.0) + 1e-12
        rest = drive.changed(**{name: worn.value(name) for name in changed})
        assert rest == worn
