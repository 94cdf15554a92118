"""Coordinates of a drive: white while it is new, exact back, and linear in what is measured."""

from dataclasses import replace

import numpy as np
import pytest

from breaker.family.inputs import Basis
from breaker.family.shape import SHAPE_TIMES
from breaker.prognosis.coordinates import Coordinates
from breaker.prognosis.series import MotionRecords, Series

N, G = 400, SHAPE_TIMES.size
DIRECTIONS = np.linalg.qr(np.random.default_rng(0).standard_normal((G, 30)))[0].T
BASES = {"closing": Basis(np.zeros(G), DIRECTIONS, np.geomspace(0.05, 0.002, 30) ** 2)}


def a_series(sd=0.0, gap=()):
    """Records that scatter along the components of the family, and a quantity that they show."""
    rng = np.random.default_rng(1)
    sizes = 0.3 * np.sqrt(BASES["closing"].variances) * rng.standard_normal((N, 30))
    sizes[:, 6:] = 0.0  # operations scatter in less than drives wear
    way = np.clip(SHAPE_TIMES / 3.0, 0.0, 1.0) + sizes @ DIRECTIONS
    way, present = way + 0.003 * rng.standard_normal((N, G)), np.ones((N, G), dtype=bool)
    present[list(gap)] = False
    time = 9.0 + 40.0 * sizes[:, 0] + 0.01 * rng.standard_normal(N)
    time[7] = np.nan
    measured, stated = {"travel_time": time}, {"travel_time": np.full(N, sd)}
    motion = MotionRecords(way, present, np.full(N, 0.003), 14.0, 4.0, measured, stated)
    return Series(np.arange(N), {"closing": motion}, np.arange(200), {})


@pytest.fixture(scope="module")
def seen():
    series = a_series(gap=[3])
    return series.motions["closing"], Coordinates.of(series, BASES).curves["closing"]


def test_scatter_is_white_and_the_first_coordinates_are_those_of_wear(seen):
    motion, curve = seen
    values = curve.project(motion.way, motion.present)
    assert np.isnan(values[3]).all()
    cov = np.cov(values[200:].T)  # records that the map has not seen
    # 200 records, in directions that were estimated from 200 others.
    assert np.abs(np.diag(cov) - 1.0).max() < 0.9
    assert np.abs(cov - np.diag(np.diag(cov))).max() < 0.5
    raw = (motion.way[200:] @ DIRECTIONS.T).var(axis=0)
    assert np.ptp(np.log(raw)) > 2.0  # components themselves are far from white
    assert (np.diff(curve.variance) <= 1e-9).all()
    assert curve.variance[0] > 2.0 * curve.variance[20]
    family = np.diag(BASES["closing"].variances[: curve.variance.size])
    result = curve.forward.T @ family @ curve.forward
    np.testing.assert_allclose(result, np.diag(curve.variance), atol=1e-9 * curve.variance[0])


@pytest.mark.parametrize(("count", "sd"), [(200, 0.0), (4, 0.05), (4, 3.0), (1, 0.05)])
def test_a_measured_quantity_is_in_units_of_its_scatter(count, sd):
    """The fewer readings, the more is it what is usual and stated with them."""
    series = replace(a_series(sd=sd), new=np.arange(count))
    coordinates, key = Coordinates.of(series, BASES), ("closing", "travel_time")
    reading = coordinates.readings[key]
    curve, block = coordinates.blocks(series)
    times = series.motions["closing"].measured["travel_time"]
    np.testing.assert_allclose(reading.mean + reading.scatter * block.values[:, 0], times)
    assert not block.sought  # as the curve shows it
    assert coordinates.places[key] == slice(curve.variance.size, coordinates.size)
    own, usual = times[:count], sd**2 + (0.005 * reading.mean) ** 2
    steps = np.diff(own[np.isfinite(own)]) / np.sqrt(2.0)
    expected = (steps @ steps + 20.0 * usual) / (steps.size + 20.0)
    assert reading.scatter == pytest.approx(np.sqrt(expected))
    assert reading.common == sd


def test_records_of_an_inspection_share_an_error():
    series = replace(a_series(sd=0.05), inspections=np.arange(N) // 4)
    coordinates = Coordinates.of(series, BASES)
    curve, block = coordinates.blocks(series)
    (reading,) = coordinates.readings.values()
    shared = np.square(0.0035 * reading.mean / reading.scatter)
    assert block.noise == pytest.approx(1.0 / 4.0 + shared)
    assert (curve.noise > 1.0 / 4.0).all()
    monitored = coordinates.blocks(replace(series, inspections=None))
    assert all((item.noise == 1.0).all() for item in monitored)
