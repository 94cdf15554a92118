"""Single operations: probabilities of limits from draws, and chunks that do not hold them all."""

import numpy as np
import pytest
import xarray as xr

from breaker.decisions.conditions import align, condition, usable
from breaker.mechanism.limits import from_list
from breaker.mechanism.parameters import MOTIONS, NAMES
from breaker.mechanism.quantities import evaluate
from breaker.model.randomness import generator

NUMBERS, TIMES, DRAWS = [2, 3, 5, 9], 60, 200
LIMITS = from_list(
    [
        {"name": "slow", "motion": "closing", "upper": {"touch_time": 10.0}},
        {"name": "tired", "motion": "closing", "upper": {"touch_time": 9.8}, "lower": {"f": 0.77}},
        {"name": "wide", "motion": "opening", "upper": {"L": 10.0}},
    ],
    MOTIONS,
)


def chunk(motion, operations, prior):
    """Dataset of one motion as the corrected posteriors are stored: single precision, and more."""
    rng = generator(1, "test condition", motion, operations[0])
    o, each = len(operations), ("operation",)
    theta = prior.destandardise(0.2 * rng.standard_normal((o, DRAWS, len(NAMES))))
    draws = np.concatenate([theta, rng.standard_normal((o, DRAWS, 1))], axis=-1)
    return xr.Dataset(
        {
            "travel": (("operation", "time"), rng.random((o, TIMES)).astype(np.float32)),
            "draws": (("operation", "draw", "output"), draws.astype(np.float32)),
            "accepted": (each, np.ones(o, dtype=bool)),
            "resolved": (each, np.ones(o, dtype=bool)),
            "not_needed": (each, np.zeros(o)),
        },
        {"operation": operations, "time": np.arange(TIMES), "output": [*NAMES, "onset"]},
        {"chunk": operations[0]},
    )


@pytest.fixture(scope="module")
def chunks(prior):
    return {
        motion: [chunk(motion, numbers, prior) for numbers in (NUMBERS[:2], NUMBERS[2:])]
        for motion in MOTIONS
    }


@pytest.fixture(scope="module")
def judged(chunks):
    """Operations 2 to 6: 2 and 5 are whole, 3 has no closing that was accepted, 4 and 6 are not."""
    data = {motion: align(chunks[motion], np.arange(2, 7)) for motion in MOTIONS}
    data["closing"]["accepted"][1] = False
    return condition(data, LIMITS)


# ---- chunks ----------------------------------------------------------------------------------


def test_operations_are_aligned_by_number(chunks):
    """In any chunk or in none, in the order asked for; the rest is left behind."""
    found = align(chunks["closing"], np.array([3, 4, 5, 11]))
    assert found.operation.values.tolist() == [3, 4, 5, 11]
    for name in ("accepted", "resolved"):
        assert found[name].values.tolist() == [True, False, True, False]
        assert found[name].dtype == bool
    first, second = chunks["closing"]
    for i, stored in ((0, first.sel(operation=3)), (2, second.sel(operation=5))):
        for name in ("travel", "draws"):
            np.testing.assert_array_equal(found[name].values[i], stored[name].values)
            assert np.isnan(found[name].values[i + 1]).all()
    assert "not_needed" not in found
    assert usable(found).tolist() == [True, False, True, False]


def test_chunks_that_do_not_fit_are_refused(chunks):
    """Not filled up in silence: another number of samples is another sensor."""
    first, second = chunks["closing"]
    with pytest.raises(ValueError, match="time"):
        align([first, second.isel(time=slice(0, 50))], np.array(NUMBERS))


def test_what_is_not_usable(chunks):
    data = align(chunks["closing"], np.array(NUMBERS)).load()
    data["draws"][1, 7, 3] = np.nan
    data["resolved"][2] = False
    assert usable(data).tolist() == [True, False, False, True]


# ---- probabilities ---------------------------------------------------------------------------


def by_hand(draws):
    """Shares of draws ``(d, q)`` beyond each limit, and products of the marginal ones."""
    theta = np.asarray(draws, dtype=np.float64)[:, : len(NAMES)]
    touch, f = evaluate(["touch_time", "f"], theta, "closing").T
    wide = np.mean(theta[:, NAMES.index("L")] > 10.0)
    joint = [np.mean(touch > 10.0), np.mean((touch > 9.8) & (f < 0.77)), wide]
    marginal = [joint[0], np.mean(touch > 9.8) * np.mean(f < 0.77), wide]
    return joint, marginal


def test_probabilities_are_shares_of_the_draws_of_the_limits_motion(judged, chunks):
    for number, k in ((2, 0), (5, 1)):
        one = judged.sel(operation=number)
        parts = [by_hand(chunks[m][k].draws.sel(operation=number).values) for m in MOTIONS]
        for name, (closing, opening) in zip(
            ("probability", "marginal"), zip(*parts, strict=True), strict=True
        ):
            np.testing.assert_allclose(one[name].values, [*closing[:2], opening[2]], rtol=1e-12)
            assert abs(closing[2] - opening[2]) > 0.001  # the other motion would be noticed
        assert np.all(one.undefined.values == 0)
    tired = judged.sel(operation=2, limit="tired")
    assert 0.02 < tired.probability < 0.98
    assert tired.probability != tired.marginal


def test_what_is_missing_stays_missing(judged):
    """Of an operation with one motion, the limits of this motion alone are judged."""
    for name in ("probability", "marginal", "undefined"):
        assert np.isfinite(judged[name].values).tolist() == [
            [True, True, True],
            [False, False, True],
            [False, False, False],
            [True, True, True],
            [False, False, False],
        ]


def test_a_result_does_not_depend_on_the_chunks(judged, chunks):
    data = {motion: align(chunks[motion][:1], np.array([2])) for motion in MOTIONS}
    xr.testing.assert_identical(condition(data, LIMITS), judged.sel(operation=[2]))


def test_limits_on_measured_quantities(chunks):
    """From the record alone: of records without a posterior, too, but none that was rejected."""
    data = align(chunks["closing"], np.array([2, 3, 5, 9])).load()
    values = np.array([[9.9, 13.0], [10.1, np.nan], [10.2, 13.0], [10.0, 13.0]])
    data = data.assign(
        measured=(("operation", "quantity"), values),
        measured_sd=(("operation", "quantity"), np.full((4, 2), 0.1)),
    ).assign_coords(quantity=["travel_time", "stroke"])
    data["resolved"][0] = data["accepted"][3] = False
    entry = {"name": "slow", "motion": "closing", "of": "record", "upper": {"travel_time": 10.0}}
    short = {"name": "short", "motion": "closing", "of": "record", "lower": {"stroke": 13.1}}
    found = condition({"closing": data}, from_list([entry, short], MOTIONS))
    expected = [[0.159, 0.841], [0.841, np.nan], [0.977, 0.841], [np.nan, np.nan]]
    np.testing.assert_allclose(found.probability, expected, atol=1e-3)
    assert found.words.values[0] == "measured travel_time above 10 ms"
    without = data.drop_vars(["measured", "measured_sd", "quantity"])
    assert np.isnan(condition({"closing": without}, from_list([entry], MOTIONS)).probability).all()


def test_quantities_that_do_not_exist_are_counted(chunks):
    """Draws without a wipe have no over-travel: of 200 draws, 20 without are a tenth."""
    data = {"closing": align(chunks["closing"], np.array([2])).load()}
    data["closing"]["draws"][0, :20, NAMES.index("k_a")] = 0.2
    limit = {"name": "far", "motion": "closing", "upper": {"over_travel": 1.0}}
    one = condition(data, from_list([limit], MOTIONS)).sel(operation=2, limit="far")
    assert one.undefined == 0.1
    assert one.probability >= 0.1
    assert one.marginal == one.probability
