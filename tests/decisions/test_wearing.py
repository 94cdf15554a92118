"""What wears: told once it is sure, and until it is not."""

import numpy as np
import xarray as xr

from breaker.decisions.wearing import drifts, rates, wearing, with_measured
from breaker.mechanism.parameters import MOTIONS, NAMES
from breaker.model.randomness import generator
from tests.decisions.made_up import NAN, trend_of

NUMBERS = np.arange(1, 201)


def sloping(motions=MOTIONS, **slopes):
    """A trend with slopes in sds of their error, which is 1 % in 1,000 operations."""
    trend = trend_of(list(motions), NUMBERS)
    for name, z in slopes.items():
        trend["slope"][:, NAMES.index(name)] = z
    trend["slope_interval"][:] = trend.slope.values[..., None] + 1.645 * np.array([-1, 1])
    return trend


def test_a_drift_is_told_once_it_is_sure_and_until_it_has_not_been_for_long():
    """At 2.69 sds for seven parameters together; below 1.645, for one, for 100 operations."""
    f = np.repeat([2.6, -2.8, -1.7, -1.6], [20, 20, 20, 140])
    trend = sloping(f=f, L=2.7)
    found = drifts({"both": trend}, NUMBERS)["both"]
    place = NAMES.index("f")
    assert np.flatnonzero(np.diff(found[:, place])).tolist() == [19, 158]
    assert found[[0, 20, 158, 159], place].tolist() == [0, -1, -1, 0]
    assert set(found[:, NAMES.index("L")]) == {1}
    assert not found[:, NAMES.index("mu")].any()
    told = wearing({"both": trend}, {"both": found})
    assert [told[i] for i in (0, 20, 159)] == [
        f"both: {each}" for each in ("L rises", "f falls, L rises", "L rises")
    ]


def test_a_known_event_ends_what_wears():
    trend = sloping(f=np.repeat([-5.0, 0.0], 100))
    trend["event"] = "operation", np.where(NUMBERS == 101, "greased", "")
    found = drifts({"both": trend}, NUMBERS)["both"][:, NAMES.index("f")]
    assert found[99:102].tolist() == [-1, 0, 0]


def test_noise_about_the_threshold_changes_what_wears_rarely():
    rng = generator(1, "test", "wears")
    z = 2.69 + 0.3 * rng.standard_normal(200)
    assert np.diff(z > 2.69).sum() > 60
    found = drifts({"both": sloping(f=z)}, NUMBERS)["both"]
    assert np.abs(np.diff(found, axis=0)).sum() <= 2


def test_a_drift_that_turns_is_another():
    found = drifts({"both": sloping(f=np.repeat([5.0, -5.0], 100))}, NUMBERS)["both"]
    assert found[[99, 100], NAMES.index("f")].tolist() == [1, -1]


def test_operations_without_a_trend_change_nothing():
    trend = sloping(f=5.0)
    trend["slope"][50:60] = NAN
    later = trend.isel(operation=slice(20, None))
    found = drifts({"closing": later}, NUMBERS)["closing"][:, NAMES.index("f")]
    assert found.tolist() == [0] * 20 + [1] * 180


def test_rates_are_told_steepest_first():
    trend = sloping(gamma_a=12.34, f=-3.0, L=4.25, mu=2.0, k_a=3.5)
    found = drifts({"both": trend}, NUMBERS)
    assert rates({"both": trend}, found) == "both: gamma_a +12 %, L +4.2 %, k_a +3.5 %"
    apart = {"closing": sloping(["closing"]), "opening": sloping(["opening"], f=-3.0)}
    assert rates(apart, drifts(apart, NUMBERS)) == "opening: f -3 %"


def test_measured_quantities_wear_in_percent_of_their_first_level():
    level = np.full((200, 2), [8.0, 14.0])
    level[0] = np.nan  # nothing was read at first
    slope = np.full((200, 2), [0.8, 0.0])  # ms and mm in 1,000 operations
    ends = slope[..., None] + 0.1 * np.array([-1, 1])
    record = xr.Dataset(
        {
            "level": (("operation", "followed"), level),
            "slope": (("operation", "followed"), slope),
            "slope_interval": (("operation", "followed", "bound"), ends),
            "event": ("operation", np.full(200, "")),
        },
        {"operation": NUMBERS, "followed": ["closing travel_time", "closing stroke"]},
    )
    trends = with_measured({"both": sloping()}, record)
    found = drifts(trends, NUMBERS)
    assert wearing(trends, found)[-1] == "measured: closing travel_time rises"
    assert rates(trends, found) == "measured: closing travel_time +10 %"
    assert with_measured({}, None) == {}
