"""Priors of types whose medians and spread are known, from drives of the family."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from breaker.common.randomness import generator
from breaker.configuration.magnitudes import UNLIKE
from breaker.drive.answers.assessment import Assessment
from breaker.drive.answers.type_prior import fit_type, precision_of, wear_allowance
from breaker.drive.answers.type_records import Recorded, list_breakers, read_breakers
from breaker.drive.answers.type_spread import Spread, fit_breaker
from breaker.drive.family.membership import Match
from tests.answers.drives import breakers_of, type_of, write_breakers

MOTIONS = ("closing", "opening")
TYPES, BREAKERS, FURTHER = 4, 3, 3
LEAST = 1e-3


@pytest.fixture(scope="module")
def types(defaults, prior, levels, tmp_path_factory):
    """A fitted prior of each of some types, its truth, and draws of further breakers."""
    found, assessment = [], Assessment(defaults, families=lambda: [levels])
    for number in range(TYPES):
        rng = generator(4, "test type", number)
        drawn = type_of(prior, rng)
        drives = breakers_of(drawn, defaults["rigs"], BREAKERS + FURTHER, rng)
        folder = write_breakers(tmp_path_factory.mktemp("type"), drives, 2, rng)
        recorded = read_breakers(list_breakers([folder], MOTIONS), assessment)
        room = wear_allowance(defaults["rigs"]["wear"]["change"], prior)
        names = list(recorded.operations)
        some = {name: recorded.operations[name] for name in names[:BREAKERS]}
        fitted = fit_type(replace(recorded, operations=some), room, 1, LEAST)
        draws = [levels.draw(recorded.operations[n][0], 500, rng).theta for n in names[BREAKERS:]]
        fits = [fit_breaker(theta, fitted.reference) for theta in draws]
        found.append((drawn, fitted, list(zip(drives[BREAKERS:], fits, strict=True))))
    return found


def covered(drive, fit, own, reference):
    """Which parameters are in their 90 % interval under a prior, and the sds of these."""
    precision = np.diag((reference.log_sds / own.log_sds) ** 2)
    cov = np.linalg.inv(fit.matrix + precision)
    mean = cov @ (fit.weighted + precision @ reference.standardise(own.medians))
    sd = np.sqrt(cov.diagonal())
    return np.abs(reference.standardise(np.array(drive.theta)) - mean) < 1.645 * sd, sd


def test_medians_are_recovered_and_log_sds_are_not_too_small(types):
    """28 medians of 4 types, each in 3.5 sds; 28 log-sds, of which 10 % may be below the truth."""
    for drawn, fitted, _ in types:
        z = fitted.reference.standardise(drawn.medians) - fitted.spread.centre
        assert np.all(np.abs(z) < 3.5 * np.hypot(fitted.spread.centre_sd, fitted.design))
    below = [fitted.prior.log_sds < drawn.log_sds for drawn, fitted, _ in types]
    assert np.mean(below) <= 0.1


def test_further_breakers_are_inferred_right_and_better(types):
    """84 parameters of 12 breakers, 90 % of them in their intervals: with an effective number of
    24 independent ones, less than 70 % has a probability below 1e-3. A prior that is four times
    too narrow fails: the planted fault.
    """
    inside, faulty, ratio = [], [], []
    for _, fitted, further in types:
        narrow = replace(fitted.prior, log_sds=fitted.prior.log_sds / 4.0)
        for drive, fit in further:
            held, width = covered(drive, fit, fitted.prior, fitted.reference)
            inside.append(held)
            faulty.append(covered(drive, fit, narrow, fitted.reference)[0])
            _, cov = fit.posterior(precision_of(fitted.reference))
            ratio.append(width / np.sqrt(cov.diagonal()))
    assert np.mean(inside) > 0.7
    assert np.mean(faulty) < 0.7
    assert np.median(ratio) < 1.0


def test_an_operation_of_which_a_motion_is_out_of_the_family_is_left_out(levels, records):
    operations = {"Q0": [{each.motion: each.seen for each in records[::3]}]}
    operations["Q1"] = [{"closing": records[1].seen}]

    def fit(**p_values):
        given = SimpleNamespace(draw=levels.draw, settings=levels.settings, usual=levels.usual)
        given.match = lambda motion, seen: Match(p_values[motion], {"start": 0.5, "end": 3.0}, seen)
        tried = {"of two": [(motion, given.match(motion, None)) for motion in p_values]}
        recorded = Recorded(given, tried, operations, (), 0, {})
        return fit_type(recorded, np.zeros(7), 1, LEAST)

    found = fit(closing=0.5, opening=1e-4)
    assert (list(found.fits), found.unfit) == (["Q1"], ("Q0",))
    said = r"no record of Q0, Q1 is of a family of drives \(of two: closing p = 0.0001, .*end, 3"
    with pytest.raises(ValueError, match=said):
        fit(closing=1e-4, opening=1e-4)


def test_a_median_that_would_be_refused_is_bounded(levels, records, prior, monkeypatch):
    far = Spread(np.array([0.0, 0.0, 0.0, -40.0, 0.0, 0.0, 0.0]), np.ones(7), np.ones(7))
    monkeypatch.setattr("breaker.drive.answers.type_prior.find_spread", lambda *_: far)
    operations = {"Q0": [{"closing": records[0].seen}]}
    recorded = Recorded(levels, {"this": []}, operations, (), 0, {})
    fitted = fit_type(recorded, np.zeros(7), 1, LEAST)
    assert fitted.unlike == ("gamma_a",)
    ratio = fitted.prior.medians / prior.sized(recorded.size).medians
    assert ratio == pytest.approx([1.0] * 3 + [1.0 / (0.99 * UNLIKE)] + [1.0] * 3)


def test_a_prior_is_as_wide_as_it_is_accepted(types):
    _, fitted, _ = types[0]

    def refuse(most):
        def check(found):
            if found.prior.log_sds.max() > most:
                raise ValueError("too wide")

        return check

    assert fitted.accepted(refuse(9.0)).prior.log_sds.tolist() == fitted.spread_seen.tolist()
    bounded = fitted.accepted(refuse(0.3))
    wide = fitted.spread_seen > 0.3
    assert 0 < wide.sum() < len(wide)  # those alone are bounded
    assert (bounded.prior.log_sds[wide] <= 0.3).all()
    assert bounded.prior.log_sds[~wide].tolist() == fitted.spread_seen[~wide].tolist()
    with pytest.raises(ValueError, match="too wide"):
        fitted.accepted(refuse(0.01))
