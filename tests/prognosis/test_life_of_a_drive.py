"""A drive of the family, worn in what is known: what is read of its curves, and what is told."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import xarray as xr

from breaker.configuration.loading import load
from breaker.family.inputs import network_record
from breaker.family.networks import open_network
from breaker.family.rich_drive import Drive, Elements
from breaker.family.shape import shape_of
from breaker.model.limits import Limit
from breaker.model.parameters import MOTIONS, NAMES
from breaker.prognosis.forecast import Future
from breaker.prognosis.life import Life, forecast_of
from breaker.prognosis.readout import Readout
from breaker.prognosis.series import MotionRecords, Series
from breaker.prognosis.states import STATES, states_of
from breaker.prognosis.trend import Follower
from breaker.records.measurements import measure_curve
from breaker.shipped import KINDS, model_file

PLANNING = load()["planning"]
N, NEW, STEP = 160, 30, 0.2
TIMES = np.arange(-8.0, 64.0, STEP)
DRIVE = Drive((2.1, 0.043, 0.042, 0.28, 0.11, 0.78, 10.1), Elements())
LIMITS = [
    Limit("slow", "closing", (("travel_time", 9.0, True),), of="record"),
    Limit("stiff", "", (("gamma_a", 10.0, True),), of="change"),
    Limit("strong", "closing", (("f", 0.5, False),)),
]


@cache  # as many records take seconds; nobody writes into them
def a_series(worn=20.0, seed=1):
    """Records of a drive whose friction rises by so many percent; everything scatters."""
    rng, motions = np.random.default_rng(seed), {}
    place, share = NAMES.index("gamma_a"), np.arange(N) / N
    theta = np.tile(DRIVE.theta, (N, 1))
    theta[:, place] *= 1.0 + worn / 100.0 * share
    theta *= 1.0 + 0.003 * rng.standard_normal(theta.shape)
    for motion in MOTIONS:
        sign, like, rows = (1.0 if motion == "closing" else -1.0), None, []
        for each in theta:
            late = 0.2 * rng.standard_normal()
            record = Drive(tuple(each), Elements()).travel(motion, TIMES - late)
            record = record + 0.05 * rng.standard_normal(TIMES.size)
            like = like or shape_of(sign * record, STEP)
            shape = shape_of(sign * record, STEP, like)
            noise = network_record(shape, 0.05, 0.0, STEP, like).noise[0]
            time = measure_curve(TIMES, record, motion)["travel_time"]
            rows.append((shape.way, shape.present, noise, time.value, time.sd))
        way, present, noise, *time = (np.array(each) for each in zip(*rows, strict=True))
        units, read = (like.stroke, like.duration), ({"travel_time": each} for each in time)
        motions[motion] = MotionRecords(way, present, noise, *units, *read)
    return Series(np.arange(1, N + 1), motions, np.arange(NEW), {})


@pytest.fixture(scope="module")
def families():
    return [tuple(open_network(model_file("medium_voltage", kind)) for kind in KINDS)]


@pytest.fixture(scope="module")
def followed(families):
    """The life that is told of a series."""

    def followed(series, limits=LIMITS, p_value=0.001):
        found = Readout.of(series, families, draws=200, seed=1, misfit_p_value=p_value)
        assert (found.network is None) == (p_value > 1.0)
        path = Follower(series, found.coordinates.blocks(series), 10.0).path()
        return forecast_of(found, path, limits, Future())

    return followed


@pytest.fixture(scope="module")
def life(followed):
    return followed(a_series())


def test_what_wears_is_told_and_nothing_else(life, followed):
    changed = life.changed.isel(asked=-1)
    low, _, high = changed.sel(parameter="gamma_a").values
    true = 100.0 * (1.2 / (1.0 + 0.2 * (NEW / 2.0) / N) - 1.0)
    assert 5.0 < low < true < high
    still = followed(a_series(worn=0.0, seed=2), LIMITS[:1]).changed.isel(asked=-1)
    for found in (changed.sel(parameter=["f", "k_a", "L"]), still):
        low, _, high = found.values.T
        assert (low <= 0.0).all()
        assert (high >= 0.0).all()
    assert np.abs(still.sel(quantile=0.5)).max() < 1.0
    assert life.attrs["family"] == "medium_voltage"
    assert life.attrs["agreement"] > 0.01
    assert not life.sizes["change"]


def test_limits_are_judged_by_what_they_are_read_from(life):
    last = life.isel(asked=-1)
    theta = np.array(DRIVE.theta)
    theta[NAMES.index("gamma_a")] *= 1.2
    worn = Drive(tuple(theta), Elements()).travel("closing", TIMES)
    assert life.part_unit.values.tolist() == ["ms", "%", "mm/ms²"]
    assert last.value.sel(part=0).values[1] == pytest.approx(
        measure_curve(TIMES, worn, "closing")["travel_time"].value, abs=0.05
    )
    assert last.p_exceeded.sel(limit="stiff") > 0.9
    assert last.p_exceeded.sel(limit="strong") < 0.2
    assert life.new.values[0] == pytest.approx(8.4, abs=0.5)
    assert life.new.values[1] == 0.0


def first(count):
    """The first records of a series."""
    series = a_series()
    motions = {}
    for motion, one in series.motions.items():
        arrays = {name: getattr(one, name)[:count] for name in ("way", "present", "noise")}
        for name in ("measured", "stated"):
            arrays[name] = {each: values[:count] for each, values in getattr(one, name).items()}
        motions[motion] = replace(one, **arrays)
    return Series(series.operations[:count], motions, series.new, {})


@pytest.mark.parametrize("count", [NEW, NEW + 49, NEW + 50])
def test_nothing_is_told_before_enough_records(followed, count):
    """Of what is new, and then 50: as many as settle."""
    life = followed(first(count))
    assert life.attrs["needed"] == NEW + 50
    stands = states_of(life, PLANNING)
    unknown = stands.state.values == STATES.index("unknown")
    assert unknown[:-1].all()
    assert unknown[-1].all() == (count < NEW + 50)
    assert (life.attrs["reported_from"] <= life.operation.values[-1]) == (count == NEW + 50)


def test_what_comes_later_changes_nothing_before(followed, life):
    short = followed(first(120))
    np.testing.assert_allclose(short.evidence, life.evidence[:120])
    both = np.intersect1d(short.asked, life.asked)[:-1]
    # Networks read lives as batches, whose sizes round float32 in other ways.
    np.testing.assert_allclose(
        short.changed.sel(asked=both), life.changed.sel(asked=both), rtol=1e-4, atol=1e-4
    )


def test_a_drive_of_no_family_is_measured_only(followed):
    life = followed(a_series(), p_value=1.1)
    assert life.attrs["family"] == ""
    assert np.isnan(life.changed).all()
    assert np.isfinite(life.value.sel(part=0)).all()
    assert np.isnan(life.p_exceeded.sel(limit=["stiff", "strong"])).all()


def test_one_motion_alone_is_followed(followed):
    series = a_series()
    one = Series(series.operations, {"closing": series.motions["closing"]}, series.new, {})
    life = followed(one, LIMITS[:2])
    assert life.attrs["agreement"] == 1.0
    assert life.changed.isel(asked=-1).sel(parameter="gamma_a").values[1] > 5.0


def test_an_operation_is_added_once():
    life = Life(LIMITS, {}, events={}, conditions={})
    one, two = (xr.Dataset(coords={"operation": numbers}) for numbers in ([1, 2], [2, 3]))
    life.update({"closing": one})
    with pytest.raises(ValueError, match="closing 2"):
        life.update({"closing": two})


def test_a_saved_life_has_the_same_states(life, tmp_path):
    kept = Life(LIMITS, {}, events={}, conditions={})
    kept.forecast = life
    kept.save(tmp_path / "life.zarr", seed=1)
    found = Life.load(tmp_path / "life.zarr")
    xr.testing.assert_identical(found.state(PLANNING), kept.state(PLANNING))
