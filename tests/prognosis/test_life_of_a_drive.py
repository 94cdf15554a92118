"""A drive of the family, worn in what is known: what is read of its curves, and what is told."""

from functools import cache

import numpy as np
import pytest
import xarray as xr

from breaker.configuration.loading import load
from breaker.family.rich_drive import Drive, Elements
from breaker.model.limits import Limit
from breaker.model.parameters import MOTIONS, NAMES
from breaker.prognosis.life import follow
from breaker.prognosis.limit_states import STATES, states_of
from breaker.records.measurements import measure_curve

PLANNING = load()["planning"]
N, NEW, STEP = 160, 50, 0.2
TIMES = np.arange(-8.0, 64.0, STEP)
THETA, PLACE = np.array([2.1, 0.043, 0.042, 0.28, 0.11, 0.78, 10.1]), NAMES.index("gamma_a")
LIMITS = [
    Limit("slow", "closing", (("travel_time", 9.5, True),), of="record"),
    Limit("stiff", "", (("gamma_a", 10.0, True),), of="change"),
    Limit("strong", "closing", (("f", 0.5, False),)),
]


@cache  # as many records take seconds; nobody writes into them
def records(worn=20.0, seed=1):
    """Records whose damping rises by so many percent, as ``read_curves`` returns them, of a drive
    of which everything scatters. Limits have the time of a closing alone.
    """
    rng, result = np.random.default_rng(seed), {}
    theta = np.tile(THETA, (N, 1)) * (1.0 + 0.003 * rng.standard_normal((N, THETA.size)))
    theta[:, PLACE] *= 1.0 + worn / 100.0 * np.arange(N) / N
    numbers = {"accepted": True, "rate": 1.0 / STEP, "record_noise": 0.05, "record_colour": 0.0}
    for motion in MOTIONS:
        moved = zip(theta, TIMES - 0.2 * rng.standard_normal((N, 1)), strict=True)
        curves = [Drive(tuple(item), Elements()).travel(motion, times) for item, times in moved]
        curves = np.array(curves) + 0.05 * rng.standard_normal((N, TIMES.size))
        measured = np.full((N, 2), np.nan)
        if motion == "closing":
            measured = [measure_curve(TIMES, curve, motion)["travel_time"][:2] for curve in curves]
        data = {name: ("operation", np.full(N, value)) for name, value in numbers.items()}
        data["record"] = ("operation", "sample"), curves
        for name, values in zip(("measured", "measured_sd"), np.transpose(measured), strict=True):
            data[name] = ("operation", "quantity"), values[:, None]
        coords = {"operation": np.arange(1, N + 1), "quantity": ["travel_time"]}
        result[motion] = xr.Dataset(data, coords)
    return result


def first(count):
    return {motion: data.isel(operation=slice(count)) for motion, data in records().items()}


def forecast(data, limits=LIMITS, p_value=0.001):
    """The forecast of a life."""
    settings = {"trend": {"draws": 200, "threshold": 10.0, "horizon": 10000}, "seed": 1}
    settings["endurance"] = {"events": {}, "misfit_p_value": p_value}
    return follow(data, limits, settings, events={}, conditions={})


@pytest.fixture(scope="module")
def life():
    return forecast(records())


def test_what_wears_is_reported_and_nothing_else(life):
    changed = life.changed.isel(asked=-1)
    low, _, high = changed.sel(parameter="gamma_a").values
    true = 100.0 * (1.2 / (1.0 + 0.2 * (NEW / 2.0) / N) - 1.0)
    assert 5.0 < low < true < high
    still = forecast(records(0.0, 2), LIMITS[:1]).changed.isel(asked=-1)
    for result in (changed.sel(parameter=["f", "k_a", "L"]), still):
        low, _, high = result.values.T
        assert (low <= 0.0).all()
        assert (high >= 0.0).all()
    assert np.abs(still.sel(quantile=0.5)).max() < 1.0
    assert life.attrs["family"] == "medium_voltage"
    assert life.attrs["agreement"] > 0.01
    assert not life.sizes["change"]


def test_limits_are_judged_by_what_they_are_read_from(life):
    last, theta = life.isel(asked=-1), THETA.copy()
    theta[PLACE] *= 1.2
    worn = Drive(tuple(theta), Elements()).travel("closing", TIMES)
    time = measure_curve(TIMES, worn, "closing")["travel_time"].value
    assert last.value.sel(part=0).values[1] == pytest.approx(time, abs=0.05)
    assert last.p_exceeded.sel(limit="stiff") > 0.9
    assert last.p_exceeded.sel(limit="strong") < 0.2
    assert life.new.values[:2] == pytest.approx([8.4, 0.0], abs=0.5)


@pytest.mark.parametrize("count", [NEW + 49, NEW + 50])
def test_nothing_is_reported_before_enough_records(count):
    """Of what is new, and then 50: as many as settle."""
    life = forecast(first(count))
    assert life.attrs["needed"] == NEW + 50
    unknown = states_of(life, PLANNING).state.values == STATES.index("unknown")
    assert unknown[:-1].all()
    assert unknown[-1].all() == (count < NEW + 50)
    assert (life.attrs["reported_from"] <= life.operation.values[-1]) == (count == NEW + 50)


def test_what_comes_later_changes_nothing_before(life):
    short = forecast(first(120))
    np.testing.assert_allclose(short.evidence, life.evidence[:120])
    both = np.intersect1d(short.asked, life.asked)[:-1]
    # Networks read lives as batches, whose sizes round float32 in other ways.
    pair = (item.changed.sel(asked=both) for item in (short, life))
    np.testing.assert_allclose(*pair, rtol=1e-4, atol=1e-4)


def test_a_drive_of_no_family_or_of_one_motion_is_followed():
    closing = {"closing": records()["closing"]}
    measured, one = forecast(records(), p_value=1.1), forecast(closing, LIMITS[:2])
    assert measured.attrs["family"] == ""
    assert np.isnan(measured.changed).all()
    assert np.isfinite(measured.value.sel(part=0)).all()
    assert np.isnan(measured.p_exceeded.sel(limit=["stiff", "strong"])).all()
    assert one.changed.isel(asked=-1).sel(parameter="gamma_a").values[1] > 5.0
    both = forecast(closing | {"opening": records(0.0, 2)["opening"]})
    assert both.attrs["agreement"] < 0.01  # one motion is worn, the other is not
    assert (both.attrs["family"], one.attrs["agreement"]) == ("", 1.0)
