"""Records with missing samples, completed by those that are there."""

import numpy as np

from breaker.model.randomness import generator
from breaker.posterior.missing import completed, expected
from tests.networks_fixtures import frozen, simulated


def test_completed_records_are_those_of_the_prior():
    """Completed samples have the moments of records that lost nothing.

    Of 400 records, each sample of which is about normal; the mean of their standardised squared
    errors has an sd of sqrt(2 / 400), and half as many samples are independent as there are. False
    alarm 1e-3 for the mean over samples; records are not quite normal, so 0.1 more is allowed.
    Planted fault: the covariance that is left is forgotten.
    """
    posterior = frozen(curves=64)
    model, exact = posterior.model, simulated(posterior, 400)[1]
    records = model.sensor.corrupt(exact, generator(1, "test missing", "c"))
    lost = np.zeros(31, bool)
    lost[[3, 8, 9, 10, 11, 20]] = True
    squares = {"drawn": [], "expected": []}
    for record in records:
        lacking = np.where(lost, np.nan, record)
        many, middle = completed(model, lacking, 60), expected(model, lacking)
        np.testing.assert_array_equal(many[:, ~lost], np.tile(record[~lost], (60, 1)))
        sd = many[:, lost].std(axis=0)
        squares["drawn"].append(np.square((record - middle)[lost] / sd))
        squares["expected"].append(np.square((record - middle)[lost] / model.sensor.noise_sd))
    assert abs(np.mean(squares["drawn"]) - 1.0) < 3.3 * np.sqrt(2 / 400) + 0.1
    assert np.mean(squares["expected"]) > 2.0
