"""The prior of a type: from drives whose medians and spread are known."""

import shutil
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from breaker.common.randomness import generator
from breaker.configuration.definitions import family_of
from breaker.diagnosis.estimate import Given
from breaker.diagnosis.session import Diagnosis
from breaker.diagnosis.type_prior import (
    DrawnType,
    fit_type,
    list_type,
    warnings_of,
)
from breaker.model.parameters import MOTIONS, Size
from breaker.shipped import HELD_BACK
from tests.diagnosis.drives import breakers_of, type_of, write_breakers

SPREAD, NOISE = 0.03, 0.02
USUAL = np.array([0.2, 0.15, 0.2, 0.2, 0.4, 0.1, 0.05])
TYPES, BREAKERS, FURTHER = 3, 3, 3

pytestmark = pytest.mark.usefixtures("a_quarter_of_the_draws")


# ---- the model -----------------------------------------------------------------------------------


def learned(seed, n=30, deviating=()):
    """A type of drives with three operations each, and with an error that all of them share."""
    rng = np.random.default_rng(seed)
    own = 0.5 + SPREAD * rng.standard_normal((n, 7))
    own[list(deviating), 3] += 0.5
    means = own[:, None] + NOISE * rng.standard_normal((n, 3, 7))
    logs = means[:, :, None] + 0.15 * rng.standard_normal((n, 3, 100, 7))
    return DrawnType.of(np.exp(logs), USUAL)


def test_deviating_drives_do_not_widen_the_type():
    found, alike = learned(1, deviating=[0, 1, 2]), learned(1)
    assert found.log_sds == pytest.approx(alike.log_sds, rel=0.1)
    assert np.log(found.medians) == pytest.approx(np.full(7, 0.5), abs=0.04)


def test_one_drive_shows_no_spread():
    assert (learned(1, n=1).log_sds > USUAL).all()


# ---- records -------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def asked(defaults, levels):
    return Diagnosis(defaults, families=lambda: [levels])


@pytest.fixture(scope="module")
def drives(prior):
    rng = generator(6, "test recorded")
    return breakers_of(type_of(prior, rng), family_of(HELD_BACK), 2, rng)


@pytest.fixture(scope="module")
def written(tmp_path_factory, drives):
    return write_breakers(tmp_path_factory.mktemp("type"), drives, 2, generator(1, "test files"))


@pytest.fixture(scope="module")
def fitted(written, asked):
    return fit_type(list_type([written], MOTIONS), asked)


def counts(fitted):
    return {name: len(estimates) for name, estimates in fitted.estimates.items()}


def test_breakers_of_a_table(fitted):
    assert counts(fitted) == {"Q0": 4, "Q1": 4}
    assert {e.motions for e in fitted.estimates["Q0"]} == {MOTIONS}  # of an operation, together
    assert (fitted.rejected, fitted.names) == ([], ["Q0", "Q1"])
    assert fitted.sensor.noise_sd == pytest.approx(0.1, rel=0.15)
    assert fitted.size.lengths == pytest.approx(1.0, abs=0.3)
    assert [remark.code for remark in warnings_of(fitted)] == []


def test_breakers_that_are_left_out_are_warnings(fitted):
    outside = [replace(e, draws=None, misfit=True) for e in fitted.estimates["Q0"]]
    for estimates, names, codes in (
        (outside, ["Q1"], {"type-one-breaker", "type-left-out"}),
        ([*outside[1:], fitted.estimates["Q0"][0]], ["Q0", "Q1"], {"type-outside"}),
    ):
        new = {"Q0": estimates, "Q1": fitted.estimates["Q1"]}
        new = replace(fitted, estimates=new, names=names)
        assert {remark.code for remark in warnings_of(new)} == codes
    any_levels = SimpleNamespace(usual=fitted.levels.usual, settings={"family": "any"})
    damped = replace(fitted, levels=any_levels)  # openings of drives with dampers
    assert [remark.code for remark in warnings_of(damped)] == ["type-damped"]


def test_operations_of_one_type_are_chosen_and_a_copy_counts_once(tmp_path, written, asked):
    """A record of Q0 that was saved again as one of Q1, a folder twice, and a damaged file."""
    folder = shutil.copytree(written, tmp_path / "type")
    (folder / "closing_1_1.csv").write_bytes((folder / "closing_0_1.csv").read_bytes() + b"\n")
    (folder / "closing_1_2.csv").write_text("time,travel\n0,1\n", encoding="utf-8")
    again = shutil.copytree(folder, tmp_path / "again")
    fitted = fit_type(list_type([folder, again], ["closing"]), asked)
    assert counts(fitted) == {"Q0": 2}
    assert len(fitted.rejected) == 2 + 4
    table = folder / "operations.csv"
    head, *rows = table.read_text(encoding="utf-8").splitlines()
    rows = [f"{row},{'GL 314' if 'Q1' in row else 'GL318'}" for row in rows]
    table.write_text("\n".join([f"{head},type", *rows]), encoding="utf-8")
    own = list_type([folder], MOTIONS, "gl-314")
    assert {e.breaker for operations in own.values() for e in operations} == {"Q1"}
    for choice, code in (("GL31", "type-choose"), ("", "type-choose")):
        with pytest.raises(ValueError, match=r"GL 314, GL318") as caught:
            list_type([folder], MOTIONS, choice)
        assert caught.value.args[0].code == code
    with pytest.raises(FileNotFoundError) as caught:
        list_type([folder, tmp_path / "nowhere"], MOTIONS)  # not left out in silence
    assert caught.value.args[0].code == "type-no-operation"


# ---- the prior -----------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def types(prior, asked, tmp_path_factory):
    """Fitted priors of some types, their truth, and further breakers with their records."""
    found = []
    for number in range(TYPES):
        rng = generator(4, "test type", number)
        true = type_of(prior, rng)
        drives = breakers_of(true, family_of(HELD_BACK), BREAKERS + FURTHER, rng)
        folder = write_breakers(tmp_path_factory.mktemp("type"), drives, 2, rng)
        listed = list_type([folder], MOTIONS)
        some = [
            {m: [e for e in every if (int(e.breaker[1:]) < BREAKERS) == first] for m, every in of}
            for of, first in ((listed.items(), True), (listed.items(), False))
        ]
        fitted, records = fit_type(some[0], asked), asked.read(some[1])
        further = [
            (drive, [r for r in records if r.operation.breaker == f"Q{k}"])
            for k, drive in enumerate(drives)
        ][BREAKERS:]
        found.append((true, fitted, further))
    return found


@pytest.mark.slow
def test_medians_are_recovered_and_further_breakers_are_inferred_better(types, asked):
    """63 parameters of 9 breakers, 90 % of them in their intervals: with an effective number of
    24 independent ones, less than 70 % has a probability below 1e-3. A prior that is four times
    too narrow fails: the planted fault.
    """
    inside, ratios, below = {"fitted": [], "narrow": []}, [], []
    for true, fitted, further in types:
        off = np.log(fitted.drawn.medians / true.medians)
        assert np.all(np.abs(off) < 3.5 * fitted.drawn.log_sds)
        below.append(fitted.prior.log_sds < true.log_sds)
        narrow = replace(fitted.prior, log_sds=fitted.prior.log_sds / 4.0)
        priors = {"none": None, "fitted": fitted.prior, "narrow": narrow}
        for drive, records in further:
            widths = {}
            for name, own in priors.items():
                given = Given() if own is None else Given(Size(), own)
                estimate = replace(asked, given=given).infer(records[:1])[0]
                theta = np.full((1, 7), np.nan) if estimate.draws is None else estimate.draws.theta
                low, high = np.quantile(np.log(theta), [0.05, 0.95], axis=0)
                widths[name] = high - low
                contains = (low <= np.log(drive.theta)) & (np.log(drive.theta) <= high)
                inside.setdefault(name, []).append(contains)
            ratios.append(widths["fitted"] / widths["none"])
    assert np.mean(below) <= 0.1
    assert np.mean(inside["fitted"]) > 0.7
    assert np.mean(inside["narrow"]) < 0.7
    assert np.nanmedian(ratios) < 0.8
