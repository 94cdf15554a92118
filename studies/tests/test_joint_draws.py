"""What the study of joint draws takes for granted of its parts."""

import numpy as np
import pytest

from breaker.drive.family.network_inputs import NormalisedRecords
from breaker.reading.records.normalised_shape import SHAPE_TIMES, shape_of
from studies.joint_draws import SHIFTED, common, in_own_units, largest


def test_scatter_that_motions_have_in_common_is_found():
    rng = np.random.default_rng(1)
    one, other, both = rng.standard_normal((3, 2000, 24))
    other[:, 0] = 0.6 * one[:, 0] + 0.8 * both[:, 0]
    assert largest(common([one, other])) == pytest.approx(0.6, abs=0.05)
    assert largest(common([one, np.roll(other, SHIFTED, axis=0)])) < 0.25


def test_a_worn_curve_is_seen_as_a_record_of_it_would_be():
    time = np.arange(0.0, 80.0, 0.1)

    def shape(lasts, like=None):
        way = np.clip((time - 20.0) / lasts, 0.0, 1.0)
        return shape_of(1.1 * way**2 * (3.0 - 2.0 * way), 0.1, like)

    new, worn = shape(20.0), shape(24.0)
    moved = shape(24.0, new).way - new.way
    seen, one = (NormalisedRecords.nothing(1)._replace(way=each[None]) for each in (new.way, moved))
    seen = in_own_units(seen._replace(duration=np.array([new.duration])), one)
    assert seen.duration[0] == pytest.approx(worn.duration, rel=0.01)
    inner = np.abs(SHAPE_TIMES) < 1.5
    assert seen.way[0, inner] == pytest.approx(worn.way[inner], abs=0.005)
    assert np.abs(moved[inner]).max() > 0.05
