"""Priors of types whose medians and spread are known, from drives of the family."""

from dataclasses import replace

import numpy as np
import pytest

from breaker.common.randomness import generator
from breaker.configuration.definitions import family_of
from breaker.configuration.loading import UNLIKE
from breaker.diagnosis.estimate import Given
from breaker.diagnosis.session import Diagnosis
from breaker.diagnosis.type_model import TypeDraws
from breaker.diagnosis.type_prior import fit_type, wear_allowance
from breaker.diagnosis.type_records import list_breakers, read_breakers
from breaker.model.parameters import Size
from breaker.shipped import HELD_BACK
from tests.diagnosis.drives import breakers_of, type_of, write_breakers

MOTIONS = ("closing", "opening")
TYPES, BREAKERS, FURTHER = 4, 3, 3

pytestmark = pytest.mark.usefixtures("a_quarter_of_the_draws")


@pytest.fixture(scope="module")
def assessment(defaults, levels):
    return Diagnosis(defaults, families=lambda: [levels])


@pytest.fixture(scope="module")
def types(defaults, prior, assessment, tmp_path_factory):
    """A fitted prior of each of some types, its truth, and further breakers with their records."""
    found = []
    for number in range(TYPES):
        rng = generator(4, "test type", number)
        drawn = type_of(prior, rng)
        drives = breakers_of(drawn, family_of(HELD_BACK), BREAKERS + FURTHER, rng)
        folder = write_breakers(tmp_path_factory.mktemp("type"), drives, 2, rng)
        recorded = read_breakers(list_breakers([folder], MOTIONS), assessment)
        names = list(recorded.answers)
        some = {name: recorded.answers[name] for name in names[:BREAKERS]}
        room = wear_allowance(family_of(HELD_BACK)["wear"]["change"])
        fitted = fit_type(replace(recorded, answers=some), room)
        further = [[e.record for e in recorded.answers[n]] for n in names[BREAKERS:]]
        found.append((drawn, fitted, list(zip(drives[BREAKERS:], further, strict=True))))
    return found


@pytest.fixture(scope="module")
def covered(assessment):
    """Infers a drive under a prior: which parameters are in their 90 % interval, and its width;
    none are where the draws do not resolve it.
    """

    def covered(drive, records, prior):
        given = Given() if prior is None else Given(Size(), prior)
        (answer,) = replace(assessment, given=given).infer(records[:1])
        if answer.draws is None:
            return np.zeros(7, bool), np.full(7, np.nan)
        theta = np.log(answer.draws.theta)
        low, high = np.quantile(theta, [0.05, 0.95], axis=0)
        truth = np.log(drive.theta)
        return (low <= truth) & (truth <= high), high - low

    return covered


def test_medians_are_recovered_and_log_sds_are_not_too_small(types):
    """28 medians of 4 types, each in 3.5 sds; 28 log-sds, of which 10 % may be below the truth."""
    for drawn, fitted, _ in types:
        learned = fitted.learned
        off = np.log(learned.medians / drawn.medians)
        assert np.all(np.abs(off) < 3.5 * np.hypot(learned.known, learned.shared))
    below = [fitted.prior.log_sds < drawn.log_sds for drawn, fitted, _ in types]
    assert np.mean(below) <= 0.1


def test_further_breakers_are_inferred_right_and_better(types, covered):
    """84 parameters of 12 breakers, 90 % of them in their intervals: with an effective number of
    24 independent ones, less than 70 % has a probability below 1e-3. A prior that is four times
    too narrow fails: the planted fault.
    """
    inside, faulty, ratio = [], [], []
    for _, fitted, further in types:
        narrow = replace(fitted.prior, log_sds=fitted.prior.log_sds / 4.0)
        for drive, records in further:
            held, width = covered(drive, records, fitted.prior)
            inside.append(held)
            faulty.append(covered(drive, records, narrow)[0])
            ratio.append(width / covered(drive, records, None)[1])
    assert np.mean(inside) > 0.7
    assert np.mean(faulty) < 0.7
    assert np.nanmedian(ratio) < 0.8


@pytest.fixture(scope="module")
def recorded(types, assessment, tmp_path_factory, defaults, prior):
    """Records of two breakers of a type."""
    rng = generator(5, "test type")
    drives = breakers_of(type_of(prior, rng), family_of(HELD_BACK), 2, rng)
    folder = write_breakers(tmp_path_factory.mktemp("two"), drives, 1, rng)
    return read_breakers(list_breakers([folder], MOTIONS), assessment)


def test_a_breaker_of_which_nothing_is_inferred_is_left_out(recorded):
    def misfits(*names):
        answers = {
            name: [replace(e, draws=None, misfit=True) if name in names else e for e in each]
            for name, each in recorded.answers.items()
        }
        return fit_type(replace(recorded, answers=answers), np.zeros(7))

    found = misfits("Q0")
    assert (found.names, found.unfit, found.alone) == (("Q1",), ("Q0",), True)
    said = r"no record of Q0, Q1 is of a family of drives \(.*: closing p = "
    with pytest.raises(ValueError, match=said):
        misfits("Q0", "Q1")


def test_a_median_that_would_be_refused_is_bounded(recorded, prior, monkeypatch):
    found = TypeDraws.of([[np.tile(prior.medians * [1, 1, 1, 1e-4, 1, 1, 1], (500, 1))]])
    monkeypatch.setattr(TypeDraws, "of", lambda drives: found)
    fitted = fit_type(recorded, np.zeros(7))
    assert fitted.unlike == ("gamma_a",)
    ratio = fitted.prior.medians / prior.sized(recorded.size).medians
    assert ratio[3] == pytest.approx(1.0 / (0.99 * UNLIKE))
    assert fitted.prior.medians[[0, 6]] == pytest.approx(prior.medians[[0, 6]])


def test_a_prior_is_as_wide_as_it_is_accepted(types):
    _, fitted, _ = types[0]

    def refuse(most):
        def check(found):
            if found.prior.log_sds.max() > most:
                raise ValueError("too wide")

        return check

    assert fitted.accepted(refuse(9.0)).prior.log_sds.tolist() == fitted.spread_seen.tolist()
    bounded = fitted.accepted(refuse(0.1))
    wide = fitted.spread_seen > 0.1
    assert 0 < wide.sum() < len(wide)  # those alone are bounded
    assert (bounded.prior.log_sds[wide] <= 0.1).all()
    assert bounded.prior.log_sds[~wide].tolist() == fitted.spread_seen[~wide].tolist()
    with pytest.raises(ValueError, match="too wide"):
        fitted.accepted(refuse(0.01))
