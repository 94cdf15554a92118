"""Single operations: probabilities of limits from draws, and chunks that do not hold them all."""

import numpy as np
import pytest
import xarray as xr

from breaker.decisions.conditions import align, condition, usable
from breaker.decisions.fusion import Pair
from breaker.mechanism.limits import from_list
from breaker.mechanism.parameters import MOTIONS, NAMES
from breaker.mechanism.quantities import evaluate
from breaker.model.randomness import generator
from tests.decisions.test_fusion import fused, models_of, operate, settings_of

NUMBERS = [2, 3, 5, 9]
LIMITS = [
    {"name": "slow", "motion": "closing", "upper": {"touch_time": 10.0}},
    {"name": "tired", "motion": "closing", "upper": {"touch_time": 9.8}, "lower": {"f": 0.77}},
    {"name": "wide", "motion": "opening", "upper": {"L": 10.0}},
]
OWN, BOTH = {"evidence": "own"}, {"evidence": "both"}


def chunk(motion, operations, models):
    """Dataset of one motion as the corrected posteriors are stored: single precision, and more."""
    travel = np.array([each.records[motion] for each in operations.values()])
    draws = np.array([each.draws[motion] for each in operations.values()])
    each = ("operation",)
    return xr.Dataset(
        {
            "travel": (("operation", "time"), travel.astype(np.float32)),
            "draws": (("operation", "draw", "output"), draws.astype(np.float32)),
            "median": (("operation", "output"), np.median(draws, axis=1)),
            "accepted": (each, np.ones(len(draws), dtype=bool)),
            "resolved": (each, np.ones(len(draws), dtype=bool)),
            "misfit": (each, np.zeros(len(draws), dtype=bool)),
            "log_evidence": (each, np.array([one.evidence[motion] for one in operations.values()])),
            "not_needed": (each, np.zeros(len(draws))),
        },
        {
            "operation": list(operations),
            "time": models[motion].sensor.times,
            "output": models[motion].names,
        },
        {"chunk": int(min(operations))},
    )


@pytest.fixture(scope="module")
def models(prior, sensor):
    return models_of(prior, sensor)


@pytest.fixture(scope="module")
def operations(models, prior, defaults):
    """Operations by number: of a drive; the motions of number 5 are of two drives."""
    result = {}
    theta = prior.destandardise(np.array([0.1, 0.3, -0.2, 0.1, -0.1, 0.2, 0.1]))
    stronger = theta * np.where(np.array(NAMES) == "f", 1.3, 1.0)
    for number in NUMBERS:
        rng = generator(1, "test condition", number)
        parts = {"closing": theta, "opening": stronger if number == 5 else theta}
        one = operate(models, parts, settings_of(defaults), rng)
        result[number] = one
    return result


@pytest.fixture(scope="module")
def chunks(operations, models):
    return {
        motion: [
            chunk(motion, {n: operations[n] for n in numbers}, models)
            for numbers in (NUMBERS[:2], NUMBERS[2:])
        ]
        for motion in MOTIONS
    }


@pytest.fixture(scope="module")
def judged(chunks, models, defaults):
    """Operations 2 to 6: 2 is whole, 3 has no closing that was accepted, 4 and 6 do not exist."""
    data = {motion: align(chunks[motion], np.arange(2, 7)) for motion in MOTIONS}
    data["closing"]["accepted"][1] = False
    limits = from_list(LIMITS, MOTIONS)
    return condition(models, data, limits, settings_of(defaults), 1)


# ---- chunks ----------------------------------------------------------------------------------


def test_operations_are_aligned_by_number(chunks, operations):
    """In any chunk or in none, in the order asked for; the rest is left behind."""
    found = align(chunks["closing"], np.array([3, 4, 5, 11]))
    assert found.operation.values.tolist() == [3, 4, 5, 11]
    assert found.accepted.values.tolist() == [True, False, True, False]
    assert found.resolved.values.tolist() == [True, False, True, False]
    for name in ("accepted", "resolved"):
        assert found[name].dtype == bool
    for i, number in enumerate([3, None, 5, None]):
        if number is None:
            for name in ("travel", "draws", "log_evidence"):
                assert np.isnan(found[name].values[i]).all()
            continue
        expected = operations[number]
        np.testing.assert_array_equal(
            found.travel.values[i], expected.records["closing"].astype(np.float32)
        )
        np.testing.assert_array_equal(
            found.draws.values[i], expected.draws["closing"].astype(np.float32)
        )
        assert found.log_evidence.values[i] == expected.evidence["closing"]
    assert "not_needed" not in found
    assert usable(found).tolist() == [True, False, True, False]


def test_chunks_that_do_not_fit_are_refused(chunks):
    """Not filled up in silence: another number of samples is another sensor."""
    first, second = chunks["closing"]
    with pytest.raises(ValueError, match="time"):
        align([first, second.isel(time=slice(0, 50))], np.array(NUMBERS))


def test_a_posterior_that_is_not_finite_is_not_usable(chunks):
    data = align(chunks["closing"], np.array(NUMBERS)).load()
    data["draws"] = data.draws.copy()
    data["draws"][1, 7, 3] = np.nan
    assert usable(data).tolist() == [True, False, True, True]


# ---- probabilities ---------------------------------------------------------------------------


def by_hand(draws):
    """Shares of draws ``(d, q)`` beyond each limit, and products of the marginal ones."""
    theta = np.asarray(draws, dtype=np.float64)[:, : len(NAMES)]
    touch, f = evaluate(["touch_time", "f"], theta, "closing").T
    wide = np.mean(theta[:, NAMES.index("L")] > 10.0)
    joint = [np.mean(touch > 10.0), np.mean((touch > 9.8) & (f < 0.77)), wide]
    marginal = [joint[0], np.mean(touch > 9.8) * np.mean(f < 0.77), wide]
    return joint, marginal


def test_own_probabilities_are_shares_of_the_motions_draws(judged, operations):
    for number in (2, 5):
        one = judged.sel(operation=number, **OWN)
        parts = [by_hand(operations[number].draws[m].astype(np.float32)) for m in MOTIONS]
        for k, name in enumerate(("probability", "marginal")):
            closing, opening = (part[k] for part in parts)
            expected = [*closing[:2], opening[2]]
            np.testing.assert_allclose(one[name].values, expected, rtol=1e-12)
        assert np.all(one.undefined.values == 0)
    assert 0.02 < judged.probability.sel(operation=2, limit="tired", **OWN) < 0.98


def test_both_probabilities_are_shares_of_the_fused_draws(
    judged, chunks, operations, models, defaults
):
    """From the records as they are stored, and by the operation's own random numbers."""
    operation = operations[2]
    single = {m: align(chunks[m], np.array([2])) for m in MOTIONS}
    stored = type(operation)(
        operation.theta,
        {m: single[m].travel.values[0].astype(np.float64) for m in MOTIONS},
        {m: single[m].draws.values[0].astype(np.float64) for m in MOTIONS},
        operation.evidence,
    )
    expected = fused(Pair(models), stored, settings_of(defaults), generator(1, "fusion", 2))
    found = judged.sel(operation=2)
    joint, marginal = by_hand(expected.draws)
    np.testing.assert_allclose(found.probability.sel(**BOTH), joint, rtol=1e-12)
    np.testing.assert_allclose(found.marginal.sel(**BOTH), marginal, rtol=1e-12)
    np.testing.assert_allclose(found["median"], np.median(expected.draws, axis=0))
    assert found.log_agreement == expected.log_agreement > 0
    assert found.agree
    assert found.why_not_fused == ""


def test_what_was_not_fused_says_why(judged):
    assert judged.operation.values.tolist() == [2, 3, 4, 5, 6]
    assert judged.why_not_fused.values.tolist() == [
        "",
        "not both motions are there",
        "not both motions are there",
        "the motions have different parameters",
        "not both motions are there",
    ]
    assert judged.agree.values.tolist() == [True, False, False, False, False]
    assert judged.agree.dtype == bool
    assert np.isnan(judged.log_agreement.values[1:]).all()
    assert np.isnan(judged["median"].values[1:]).all()
    assert np.isfinite(judged.apart.values).tolist() == [True, False, False, True, False]
    assert judged.apart.values[3] > 60


def test_what_is_missing_stays_missing(judged):
    """Of an operation with one motion, the limits of this motion alone are judged."""
    there = np.isfinite(judged.probability.values)  # (operation, limit, evidence)
    assert there[..., 0].tolist() == [
        [True, True, True],
        [False, False, True],
        [False, False, False],
        [True, True, True],
        [False, False, False],
    ]
    assert there[..., 1].any(axis=1).tolist() == [True, False, False, False, False]
    for name in ("marginal", "undefined"):
        np.testing.assert_array_equal(np.isfinite(judged[name].values), there)


def test_limits_and_their_words(judged):
    assert judged.limit.values.tolist() == ["slow", "tired", "wide"]
    assert judged.words.values.tolist() == [
        "touch_time above 10 ms",
        "touch_time above 9.8 ms and f below 0.77 mm/ms²",
        "L above 10 mm",
    ]


def test_a_result_does_not_depend_on_the_chunks(judged, chunks, models, defaults):
    data = {motion: align(chunks[motion][:1], np.array([2])) for motion in MOTIONS}
    found = condition(models, data, from_list(LIMITS, MOTIONS), settings_of(defaults), 1)
    xr.testing.assert_identical(found, judged.sel(operation=[2]))


def test_one_motion_only(chunks, models, defaults):
    """Nothing is fused, nor is it tried."""
    data = {"opening": align(chunks["opening"], np.array([2, 3]))}
    limits = from_list(LIMITS, ["opening"])
    found = condition({"opening": models["opening"]}, data, limits, settings_of(defaults), 1)
    assert found.limit.values.tolist() == ["wide"]
    assert np.isfinite(found.probability.sel(**OWN)).all()
    assert np.isnan(found.probability.sel(**BOTH)).all()
    assert not found.agree.any()
    assert set(found.why_not_fused.values) == {"not both motions are there"}


def test_quantities_that_do_not_exist_are_counted(chunks, models, defaults):
    """Draws without a wipe have no over-travel: of 600 draws, 60 without are a tenth."""
    data = {m: align(chunks[m], np.array([2])).load() for m in MOTIONS}
    draws = data["closing"].draws.values.copy()
    draws[0, :60, NAMES.index("k_a")] = 0.2
    data["closing"]["draws"] = (data["closing"].draws.dims, draws)
    data["opening"]["accepted"][:] = False
    limit = {"name": "far", "motion": "closing", "upper": {"over_travel": 1.0}}
    found = condition(models, data, from_list([limit], MOTIONS), settings_of(defaults), 1)
    one = found.sel(operation=2, limit="far", **OWN)
    assert one.undefined == 0.1
    assert one.probability >= 0.1
    assert one.marginal == one.probability
