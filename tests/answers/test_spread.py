"""Centre and spread of simulated types, whose truth is known: linear, so that tests are quick."""

import numpy as np
import pytest

from breaker.common.randomness import generator
from breaker.drive.answers import type_spread as spread
from breaker.drive.answers.type_spread import TypeFit

TYPES, BREAKERS, P = 40, 4, 7
NORMAL_90 = 1.645


def families(tau):
    """Types of some breakers: centre, fits, and the parameters of one more breaker."""
    for number in range(TYPES):
        rng = generator(8, "test spread", number)
        centre = np.sqrt(1.0 - spread._BETWEEN) * rng.standard_normal(P)
        breakers = centre + tau * rng.standard_normal((BREAKERS + 1, P))
        fits = []
        for z in breakers[:-1]:
            root = rng.standard_normal((P, P)) + 1.5 * np.eye(P)
            matrix = root @ root.T
            seen = z + np.linalg.solve(root.T, rng.standard_normal(P))
            fits.append(TypeFit(matrix, matrix @ seen))
        yield centre, fits, breakers[-1]


@pytest.fixture(scope="module")
def found():
    """What is found of each type, with the truth."""
    rows = []
    for centre, fits, further in families(0.5):
        each = spread.find_spread(fits, np.eye(P), generator(1, "test"))
        rows.append((centre, further, each.centre, each.centre_sd, each.between))
    return [np.array(each) for each in zip(*rows, strict=True)]


def covered(truth, middle, sd):
    return np.mean(np.abs(truth - middle) <= NORMAL_90 * sd)


def test_centres_and_further_breakers_are_in_their_intervals(found):
    """280 parameters, 40 types of dependent ones: 0.9 with an sd of 0.9 * 0.1 / 40 at the most;
    outside of 0.75 to 1 are 3.2 of these sds, with a probability below 1e-3.

    Without the spread between breakers, further ones are not: the planted fault. It is below the
    truth in 10 % of the cases at most.
    """
    centre, further, middle, sd, between = found
    whole = np.hypot(sd, between)
    assert covered(centre, middle, sd) > 0.75
    assert covered(further, middle, whole) > 0.75
    assert covered(further, middle, sd) < 0.75
    assert np.mean(whole < 0.5) <= 0.1


def test_much_spread_is_found():
    rows = [
        spread.find_spread(fits, np.eye(P), generator(1, "test")).between.mean()
        for _, fits, _ in list(families(2.0))[:5]
    ]
    assert np.mean(rows) > 1.4


def test_one_breaker_says_nothing_of_the_spread():
    fit = TypeFit(400.0 * np.eye(P), np.zeros(P))
    alone = spread.find_spread([fit], np.eye(P), generator(1, "test"))
    assert np.all(np.abs(alone.between - 0.97) < 0.25)  # 90 % of its prior on the grid
