"""How far the model can be trusted: sizes against a planted difference, widths against matrices."""

import numpy as np
import pytest
from scipy.linalg import block_diag

from breaker.mechanism.limits import from_list
from breaker.mechanism.parameters import MOTIONS, NAMES
from breaker.mechanism.quantities import evaluate
from breaker.model.discrepancy import Discrepancy
from breaker.model.randomness import generator
from breaker.wear.learned import Learned, by_phase
from breaker.wear.series import Series
from breaker.wear.trend import Follower
from breaker.wear.trust import trust_in

P, RECORDS = len(NAMES), 20
LIMITS = [
    {"name": "slow", "motion": "closing", "upper": {"touch_time": 12.0}, "lower": {"f": 0.7}},
    {"name": "wide", "motion": "opening", "upper": {"L": 11.5}},
]


@pytest.fixture(scope="module")
def learned(sensor):
    """Two components per motion, of 0.5 mm: a bump early in the motion and one late."""
    t = sensor.times
    basis = np.stack([np.exp(-0.5 * np.square((t - c) / 3.0)) for c in (8.0, 35.0)])
    mean = Discrepancy(0.1 * basis[1], np.zeros((P, len(t))), np.zeros((0, len(t))))
    new = 0.25 * np.eye(4)
    wear = block_diag(np.eye(P), new)
    return Learned(dict.fromkeys(MOTIONS, basis), dict.fromkeys(MOTIONS, mean), new, wear, 0.01)


def followed(models, settings, learned, difference):
    """A follower, its state before the first operation, and the true curves' differences."""
    rng, z = generator(1, "test trust"), np.zeros((RECORDS, P))
    records, outputs, left_out = {}, {}, {}
    for k, (motion, model) in enumerate(models.items()):
        onset = rng.standard_normal((RECORDS, 1))
        outputs[motion] = np.column_stack([z, onset])
        curves = model.curves(model.destandardise(outputs[motion]))
        left_out[motion] = np.zeros(model.sensor.samples)
        if learned is not None:
            part = difference[2 * k : 2 * k + 2] @ learned.basis[motion]
            left_out[motion] = learned.mean_of[motion].mean + part
        records[motion] = model.sensor.corrupt(curves + left_out[motion], rng)
    settings = settings | {"baseline": RECORDS, "lines": 2}
    follower = Follower.from_settings(models, from_list(LIMITS, MOTIONS), settings, 1, learned)
    series = Series(np.arange(1, RECORDS + 1), records, outputs)
    return follower, follower.begin(series), left_out


def test_sizes_of_a_planted_difference_and_of_the_family(models, learned, defaults):
    """By 90 % intervals twice as wide: false alarm below 1e-3 for each of six phases."""
    planted = np.array([0.9, -0.6, 0.5, 1.0])
    wear_model = defaults["wear_model"]
    follower, state, left_out = followed(models, wear_model, learned, planted)
    found = trust_in(follower, state, generator(2, "test trust"))
    z = np.zeros((1, P))
    for motion, model in models.items():
        curve = model.curves(model.destandardise(np.column_stack([z, [0.0]])))[0]
        true = by_phase(left_out[motion], curve, model.sensor.times, motion)
        rows = [f"{motion} {phase}" for phase in ("start", "main motion", "end")]
        low, middle, high = found.drive.sel(phase=rows, quantile=[0.05, 0.5, 0.95]).values.T
        assert np.all(np.abs(true - middle) < 2 * (high - low) + 0.02)
        # Of the family: shares of the mean and the components in a phase, in closed form.
        draws = generator(3, "test trust").standard_normal((20_000, 2)) * 0.5
        sizes = learned.mean_of[motion].mean + draws @ learned.basis[motion]
        sizes = [by_phase(each, curve, model.sensor.times, motion) for each in sizes[:2000]]
        usual = found.family.sel(phase=rows, quantile=0.5)
        np.testing.assert_allclose(usual, np.median(sizes, axis=0), rtol=0.25, atol=0.01)
    assert list(found.phase.values) == [
        f"{m} {p}" for m in MOTIONS for p in ("start", "main motion", "end")
    ]
    # The fault: a model that is taken for right, without a look at the records.
    assert found.drive.sel(phase="opening end", quantile=0.05) > 0.1


def test_widths_are_those_of_the_joint_posterior(models, learned, defaults):
    follower, state, _ = followed(models, defaults["wear_model"], learned, np.zeros(4))
    found = trust_in(follower, state, generator(2, "test trust"))
    assert found.part_limit.values.tolist() == ["slow", "slow", "wide"]
    assert found.part_quantity.values.tolist() == ["touch_time", "f", "L"]
    assert found.part_unit.values.tolist() == ["ms", "mm/ms²", "mm"]
    reference = state.reference
    assert reference.records == RECORDS
    told = RECORDS / (1 + RECORDS * learned.rough) * reference.matrix
    cov = np.linalg.inv(block_diag(np.eye(P), np.linalg.inv(learned.new)) + told)
    draws = generator(3, "test trust").multivariate_normal(reference.centre, cov[:P, :P], 4000)
    theta = models["closing"].prior.destandardise(draws)
    values = evaluate(["touch_time", "f"], theta, "closing")
    ends = np.quantile(values, [0.05, 0.95], axis=0)
    np.testing.assert_allclose(found.half_width[:2], np.diff(ends, axis=0)[0] / 2, rtol=0.1)
    assert (found.half_width > 1.2 * found.half_width_if_right).all()
    # With a difference that is known to be next to nothing, nothing is lost.
    tiny = Learned(learned.basis, learned.mean_of, 1e-12 * learned.new, learned.wear, 0.0)
    follower, state, _ = followed(models, defaults["wear_model"], tiny, np.zeros(4))
    found = trust_in(follower, state, generator(2, "test trust"))
    np.testing.assert_allclose(found.half_width, found.half_width_if_right, rtol=1e-6)


def test_without_a_difference_or_a_reference(models, learned, defaults):
    follower, state, _ = followed(models, defaults["wear_model"], None, None)
    found = trust_in(follower, state, generator(2, "test trust"))
    assert (found.drive == 0).all()
    assert (found.family == 0).all()
    assert np.isnan(found.half_width).all()
    follower, state, _ = followed(models, defaults["wear_model"], learned, np.zeros(4))
    nothing = Series(
        np.arange(1, 3),
        *(
            {m: np.full((2, n), np.nan) for m in MOTIONS}
            for n in (models["closing"].sensor.samples, P + 1)
        ),
    )
    found = trust_in(follower, follower.begin(nothing), generator(2, "test trust"))
    assert all(np.isnan(each).all() for each in found.data_vars.values())
