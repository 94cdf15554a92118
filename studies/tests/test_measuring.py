"""Quantities of drives richer than the model, read from their records."""

import numpy as np
import pytest
from scipy.stats import chi2

from breaker.common.randomness import generator
from breaker.configuration.data_files import family_of
from breaker.family.drive_family import Family
from breaker.family.rich_drive import Drive, Elements
from breaker.model.evaluation import evaluate
from breaker.model.parameters import MOTIONS, Size
from breaker.model.quantities import quantities_of, speeds_of
from studies.measuring import measure_drives, own_quantities

SPEEDS = speeds_of(
    {
        "closing_speed_wide": ["3 ms before touch", "1 mm after touch"],
        "closing_speed_mean": ["10 % of stroke", "90 % of stroke"],
        "opening_speed_wide": ["1 mm after separation", "8 ms after separation"],
    }
)


@pytest.mark.parametrize("motion", MOTIONS)
def test_own_quantities_of_a_drive_of_the_model(prior, motion):
    """Read from its motion, integrated in steps, they are those of the exact curve."""
    theta = prior.sample(1, generator(1, "test", "own", motion))[0].tolist()
    drive = Drive(tuple(theta), Elements()).scaled(Size(3.0, 2.0))
    speeds = tuple(speed.sized(Size(3.0, 2.0)) for speed in SPEEDS)
    own = own_quantities(drive, motion, speeds)
    exact = evaluate(list(own), np.array([drive.theta]), motion, speeds)[0]
    assert list(own) == list(quantities_of(motion, SPEEDS))
    for (name, value), expected in zip(own.items(), exact, strict=True):
        if name != "spring_compression":
            assert value == pytest.approx(expected, rel=2e-3, abs=5e-3, nan_ok=True), name


@pytest.mark.parametrize("motion", MOTIONS)
def test_errors_have_the_stated_standard_deviations(prior, motion):
    """Of normal errors a sum of squares is beyond 1.6 times this bound with less than 1e-5; the
    drives' slow approach to rest makes some larger, which the factor allows for.
    """
    rng, family = (
        generator(2, "test", "measured", motion),
        Family(prior, family_of("medium_voltage")),
    )
    result = measure_drives([family.new(rng) for _ in range(20)], motion, rng, speeds=SPEEDS)
    shown = result[result.measured.notna() & result.own.notna()]
    for name, rows in shown.groupby("quantity"):
        square = np.sum(((rows.measured - rows.own) / rows.measured_sd) ** 2)
        assert square < 1.6 * chi2.isf(1e-5, len(rows)), name
    assert (shown.quantity == "stroke").sum() >= 15
