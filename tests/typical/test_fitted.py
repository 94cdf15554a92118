"""Priors of types whose medians and spread are known, from drives that the model does not fit."""

from dataclasses import replace

import numpy as np
import pytest

from breaker.mechanism.parameters import NAMES
from breaker.mechanism.size import Size
from breaker.model.randomness import generator
from breaker.model.reference import reference_model
from breaker.typical.fits import fit_breaker
from breaker.typical.fitted import fit_type, room_for_wear
from tests.typical.drives import breakers_of, records_of, type_of, with_prior

MOTIONS = ("closing", "opening")
TYPES, BREAKERS, FURTHER = 4, 3, 3


def fitted_types(defaults, prior):
    """A fitted prior of each of some types, its truth, and records of further breakers."""
    models = {motion: reference_model(motion) for motion in MOTIONS}
    wide = {m: each.sized(Size(), 0.3) for m, each in models.items()}
    for number in range(TYPES):
        rng = generator(4, "test type", number)
        drawn = type_of(prior, rng)
        drives = breakers_of(drawn, defaults["rigs"], BREAKERS + FURTHER, rng)
        records = [{m: records_of(d, models[m], 2, rng) for m in MOTIONS} for d in drives]
        named = {f"Q{i}": each for i, each in enumerate(records[:BREAKERS])}
        room = room_for_wear(defaults["rigs"]["wear"]["change"], wide["closing"].prior)
        fitted = fit_type(wide, named, room, seed=1)
        yield drawn, fitted, wide, drives[BREAKERS:], records[BREAKERS:]


@pytest.fixture(scope="module")
def types(defaults, prior):
    return list(fitted_types(defaults, prior))


def covered(models, drive, records):
    """Which parameters are in their 90 % interval under the models' prior, by one record of each
    motion, and the widths of these intervals.
    """
    found = []
    for motion, model in models.items():
        fit = fit_breaker({motion: model}, {motion: records[motion][:1]}, np.zeros((1, 7)))
        mean, cov = fit.posterior(model.prior.precision)
        sd = np.sqrt(cov.diagonal())
        off = model.prior.standardise(np.array(drive.theta)) - mean
        found.append((np.abs(off) < 1.645 * sd, model.prior.log_sds * sd))
    return np.array([each[0] for each in found]), np.array([each[1] for each in found])


def test_medians_are_recovered_and_log_sds_are_not_too_small(types):
    """28 medians of 4 types, each in 3.5 sds; 28 log-sds, of which 10 % may be below the truth."""
    for drawn, fitted, *_ in types:
        z = fitted.reference.standardise(drawn.medians) - fitted.spread.centre
        assert np.all(np.abs(z) < 3.5 * np.hypot(fitted.spread.centre_sd, fitted.design))
    below = [fitted.prior.log_sds < drawn.log_sds for drawn, fitted, *_ in types]
    assert np.mean(below) <= 0.1


def test_further_breakers_are_inferred_right_and_better(types, defaults):
    """168 parameters of 12 breakers, 90 % of them in their intervals: with an effective number of
    24 independent ones, less than 70 % has a probability below 1e-3. A prior that is four times
    too narrow fails: the planted fault.
    """
    inside, faulty, ratio = [], [], []
    for _, fitted, wide, drives, records in types:
        prior = fitted.prior
        narrow = replace(prior, log_sds=prior.log_sds / 4.0)
        right, wrong = (
            {motion: with_prior(defaults, motion, each) for motion in MOTIONS}
            for each in (prior, narrow)
        )
        for drive, each in zip(drives, records, strict=True):
            held, width = covered(right, drive, each)
            inside.append(held)
            faulty.append(covered(wrong, drive, each)[0])
            ratio.append(width / covered(wide, drive, each)[1])
    assert np.mean(inside) > 0.7
    assert np.mean(faulty) < 0.7
    assert np.median(ratio) < 1.0


def test_one_breaker_alone_makes_a_wider_prior(types):
    _, fitted, *_ = types[0]
    alone = fitted
    for name in ("Q1", "Q2"):
        alone = alone.without(name, generator(1, "test without"))
    assert alone.alone
    assert not fitted.alone
    assert np.all(alone.prior.log_sds > fitted.reference.log_sds)
    assert np.mean(alone.prior.log_sds / fitted.prior.log_sds) > 1.0


def test_room_for_wear(defaults, prior):
    room = room_for_wear(defaults["rigs"]["wear"]["change"], prior)
    by_name = dict(zip(NAMES, room * prior.log_sds, strict=True))
    assert by_name["mu"] == 0.0
    assert by_name["f"] == pytest.approx(-np.log(0.88) / 3.0)
    assert by_name["gamma_a"] == pytest.approx(np.log(1.3) / 3.0)


def test_data_of_the_figure(types):
    _, fitted, *_ = types[0]
    data = fitted.to_dataset()
    assert data.sizes == {"kind": 2, "parameter": 7, "breaker": BREAKERS}
    np.testing.assert_allclose(data["median"].sel(kind="fitted"), fitted.prior.medians)
    assert bool((data.low < data.middle).all() & (data.middle < data.high).all())
