"""Where a trend starts: what the first operations agree on, if the model fits, what scatters."""

import numpy as np
import pytest
from scipy.stats import chi2, kstest

from breaker.mechanism.parameters import MOTIONS, NAMES
from breaker.model.fisher import information, pool
from breaker.model.joint import Model
from breaker.model.randomness import generator
from breaker.wear.reference import (
    _common_curve,
    _misfit,
    _spread,
    agreement,
    find_reference,
    modes,
    pooled,
)

P, N = len(NAMES), 40
TRUTH = np.array([0.9, 0.1, 0.2, -0.6, -1.2, -1.1, -0.7])


@pytest.fixture(scope="module")
def models(prior, sensor):
    return {motion: Model(prior, sensor, motion) for motion in MOTIONS}


def simulate(model, z, n, rng, misfit=0.0):
    """Records of a drive, with what the model cannot do, and their outputs, standardised."""
    outputs = np.column_stack([np.tile(z, (n, 1)), rng.standard_normal(n)])
    records = model.sensor.corrupt(model.curves(model.destandardise(outputs)), rng) + misfit
    return records, outputs


def dent(model):
    """Half a millimetre less around 20 ms, after the stroke: five noise sds."""
    return -5 * model.sensor.noise_sd * np.exp(-0.5 * np.square((model.sensor.times - 20.0) / 5.0))


def single_modes(model, records, outputs):
    """Modes of posteriors, each by itself and to the end, ``(n, p)``."""
    return np.array(
        [
            pool({"m": model}, {"m": record[None]}, each[:P], {"m": each[P:]})
            for record, each in zip(records, outputs, strict=True)
        ]
    )


def start_near(found, onsets, rng):
    """Outputs as draws' means would be: near the modes."""
    return np.column_stack([found + 0.1 * rng.standard_normal(found.shape), onsets])


# ---- a drive that the model fits -------------------------------------------------------------


def drives(models, motions, count=4):
    for i in range(count):
        rng = generator(1, "test baseline", *motions, i)
        prior = next(iter(models.values())).prior
        z = prior.standardise(prior.sample(1, rng))[0]
        found = {motion: simulate(models[motion], z, N, rng) for motion in motions}
        yield z, {m: f[0] for m, f in found.items()}, {m: f[1] for m, f in found.items()}


@pytest.mark.parametrize("motions", [["closing"], ["opening"], ["closing", "opening"]])
def test_records_of_the_model_fit(motions, models):
    """False alarm at most 1e-3: p-values count no parameter as fitted, and are too large at that.

    Not far too large: a mean of 4, uniform but for 10 of 151 degrees of freedom, above 0.97
    has less than 1e-3.
    """
    used = {motion: models[motion] for motion in motions}
    p_values = []
    for _, records, outputs in drives(models, motions):
        start = find_reference(used, records, outputs)
        assert start.fits
        assert list(start.p_values) == motions
        p_values += list(start.p_values.values())
    assert min(p_values) > 1e-3 / len(p_values)
    assert np.mean(p_values) < 0.97


def log_density(models, records, outputs, z):
    """Of records and common parameters ``(p,)``, with the best onsets, up to a constant."""
    total, places = -0.5 * z @ z, np.tile(z, (N, 1))
    for motion, model in models.items():
        onset = information(model, records[motion], places, outputs[motion][:, P]).onset
        curves = model.curves(model.destandardise(np.column_stack([places, onset])))
        total -= 0.5 * (model.sensor.chi_square(records[motion], curves) + np.square(onset)).sum()
    return total


@pytest.mark.parametrize("motions", [["closing"], ["closing", "opening"]])
def test_the_start_is_the_mode_of_all_records_and_one_prior(motions, models):
    """By how much it is more probable than the truth: chi-square of 7, false alarm 1e-3.

    Not by distances, for what a weak direction says bends. And nothing near is more probable.
    """
    used, deviance, count = {motion: models[motion] for motion in motions}, 0.0, 0
    for z, records, outputs in drives(models, motions):
        centre = find_reference(used, records, outputs).centre
        best = log_density(used, records, outputs, centre)
        deviance += 2 * (best - log_density(used, records, outputs, z))
        for i in range(P):
            near = centre + 0.05 * (np.arange(P) == i)
            assert log_density(used, records, outputs, near) < best + 1e-6
            assert log_density(used, records, outputs, 2 * centre - near) < best + 1e-6
        count += 1
    law = chi2(P * count)
    assert 2 * min(law.cdf(deviance), law.sf(deviance)) > 1e-3


# ---- whether both motions agree --------------------------------------------------------------


def agreements(models, shifts, count, n=6, name="f"):
    """p-values of pairs of drives whose parameter ``name`` differs by shares, ``(shift, pair)``."""
    prior, found = models["closing"].prior, []
    one = (np.array(NAMES) == name) / prior.log_sds
    for i in range(count):
        rng = generator(11, "test reference", i)
        z = prior.standardise(prior.sample(1, rng))[0]
        closing, opening = (simulate(models[motion], z, n, rng) for motion in MOTIONS)
        row = []
        for shift in shifts:
            if shift:
                opening = simulate(models["opening"], z + shift * one, n, rng)
            pair = zip(*(closing, opening), strict=True)
            records, outputs = (dict(zip(MOTIONS, each, strict=True)) for each in pair)
            row.append(agreement(models, records, outputs, pooled(models, records, outputs)))
        found.append(row)
    return np.array(found).T


def test_motions_agree_and_disagree(models):
    """p-values of 16 drives, each uniform or larger: false alarm of the distribution 1e-3.

    Planted: drives whose force differs by 2 %, which is found at 0.001 in all but a few.
    """
    same, different = agreements(models, (0.0, 0.02), 16)
    assert kstest(same, "uniform", alternative="greater").pvalue > 1e-3
    assert np.mean(same) < 0.85  # nor are they so large that nothing could be found
    assert np.mean(different < 0.001) > 0.8
    one = {"closing": models["closing"]}
    records, outputs = simulate(models["closing"], TRUTH, 3, generator(12, "test reference"))
    assert find_reference(one, {"closing": records}, {"closing": outputs}).agreement == 1.0


# ---- modes and their spread ------------------------------------------------------------------


@pytest.mark.parametrize("motion", MOTIONS)
def test_modes_are_those_of_single_records(motion, models):
    model, rng = models[motion], generator(3, "test baseline", motion)
    # Gauss-Newton is slower where much is left of a record; 0.2 prior sd is half a posterior's.
    for misfit, allowed in ((0.0, 0.03), (dent(model), 0.2)):
        records, outputs = simulate(model, TRUTH, 12, rng, misfit)
        expected = single_modes(model, records, outputs)
        begin = start_near(expected, outputs[:, P], rng)
        found, matrix = modes({motion: model}, {motion: records}, {motion: begin})
        np.testing.assert_allclose(found, expected, atol=allowed)
        assert matrix.shape == (12, P, P)
        near = information(model, records, found, outputs[:, P]).matrix
        np.testing.assert_allclose(matrix, near, atol=0.01 * np.abs(near).max())


def excess(spread, found):
    """Mean square of modes about their mean by a covariance: 1 if it is theirs."""
    off = found - found.mean(axis=0)
    return np.einsum("ni,ij,nj->", off, np.linalg.inv(spread), off) / (P * (len(found) - 1))


@pytest.mark.parametrize("wrong", [False, True])
@pytest.mark.parametrize("motion", MOTIONS)
def test_spread_is_that_of_new_modes(motion, wrong, models):
    """Of 40 operations, about 14 of them assumed ones, for 280 new values: within a factor of 1.5.

    A covariance of 52 degrees of freedom has a sum of 5 per cent for each of 7 directions and a
    scatter of 10 per cent: 4 of them, false alarm below 1e-3. The fault: a prior sd more.
    """
    model, rng = models[motion], generator(5, "test baseline", motion)
    used = {motion: model}
    records, outputs = simulate(model, TRUTH, N, rng)
    start = find_reference(used, {motion: records}, {motion: outputs})
    new, near = simulate(model, TRUTH, N, rng)
    found, matrix = modes(used, {motion: new}, {motion: near})
    if wrong:
        assert excess(np.linalg.inv(matrix.mean(axis=0)) + np.eye(P), found) < 1 / 1.5
        return
    assert 1 / 1.5 < excess(start.spread, found) < 1.5
    assert np.linalg.eigvalsh(start.spread).min() > 0


def test_a_drift_is_not_spread(models):
    """Modes about their line, with the same noise: a drift of some of their sds leaves no trace."""
    model, rng = models["closing"], generator(6, "test baseline")
    noise = model.sensor.corrupt(np.zeros((N, model.sensor.samples)), rng)
    onset, found = rng.standard_normal(N), []
    for drift in (0.0, 0.03):
        z = TRUTH + drift * np.arange(N)[:, None] * (np.array(NAMES) == "gamma_a")
        outputs = np.column_stack([z, onset])
        records = model.curves(model.destandardise(outputs)) + noise
        start = find_reference({"closing": model}, {"closing": records}, {"closing": outputs})
        found.append(np.sqrt(np.diag(start.spread)))
    ratio = found[1] / found[0]
    assert 0.03 * N / np.sqrt(12) > 2 * found[0][NAMES.index("gamma_a")]
    assert np.all((ratio > 0.8) & (ratio < 1.3)), ratio


@pytest.mark.parametrize("n", [1, 2, 3])
def test_few_operations_are_enough_for_a_spread(n, models):
    model = models["closing"]
    records, outputs = simulate(model, TRUTH, n, generator(7, "test baseline", n))
    start = find_reference({"closing": model}, {"closing": records}, {"closing": outputs})
    sd = np.sqrt(np.diag(start.spread))
    assert np.linalg.eigvalsh(start.spread).min() > 0
    assert np.all((sd > 0.01) & (sd < 1.0))


# ---- a drive that it does not fit ------------------------------------------------------------


@pytest.fixture(scope="module")
def dented(models):
    """Closings with a dent that no parameters make; their posterior modes; the baseline."""
    model, rng = models["closing"], generator(8, "test baseline")
    records, outputs = simulate(model, TRUTH, N, rng, dent(model))
    single = single_modes(model, records, outputs)
    begin = start_near(single, outputs[:, P], rng)
    return records, begin, single


def test_an_onset_far_off_is_a_misfit(models):
    """A record without noise, its onset two prior sds late: nearly its square, and no residual."""
    for model in models.values():
        record = model.curves(model.destandardise(np.append(TRUTH, 2.0)[None]))
        assert 3.5 < _misfit(model, record, TRUTH, np.zeros(1)) <= 4.0


def test_a_lone_operation_scatters_as_its_record_and_its_prior_say():
    """An error of variance 1 / j, seen through a prior of variance 1, moves a mode by j / (1 + j)
    of it: not at all where the record says nothing, and hardly where it says everything."""
    known = np.array([0.0, 0.3, 1.0, 4.0, 9.0, 1e2, 1e4])
    spread = _spread(np.zeros((1, P)), np.diag(known)[None])
    np.testing.assert_allclose(spread, np.diag(known / (1 + known) ** 2 + 0.01**2), atol=1e-12)


def test_a_misfit_that_single_records_hide_is_found(models):
    """A third of the noise of a sample: chi-square of one record has 27 of it, its sd is 17."""
    model, rng = models["closing"], generator(9, "test baseline")
    wave = 0.03 * np.where(np.arange(model.sensor.samples) % 2, 1.0, -1.0)
    records, outputs = simulate(model, TRUTH, N, rng, wave)
    start = find_reference({"closing": model}, {"closing": records}, {"closing": outputs})
    assert not start.fits
    one = find_reference({"closing": model}, {"closing": records[:1]}, {"closing": outputs[:1]})
    assert one.fits


def test_a_misfit_of_one_motion_is_a_misfit(models, dented):
    closing, begin, _ = dented
    opening, outputs = simulate(models["opening"], TRUTH, N, generator(10, "test baseline"))
    used = {"opening": models["opening"]}
    alone = find_reference(used, {"opening": opening}, {"opening": outputs})
    assert alone.fits
    both = {"closing": closing, "opening": opening}
    start = find_reference(models, both, {"closing": begin, "opening": outputs})
    assert not start.fits
    assert start.p_values["closing"] < 1e-100


def test_effective_values_stay_where_pooling_runs_away(models, dented):
    """Pooled over 40 records the dent drives two parameters far beyond what is possible; modes of
    single ones stay, and scatter as the spread says (factor 1.5: as above)."""
    records, begin, single = dented
    model = models["closing"]
    start = find_reference({"closing": model}, {"closing": records}, {"closing": begin})
    assert not start.fits
    found, _ = modes({"closing": model}, {"closing": records}, {"closing": begin})
    np.testing.assert_allclose(found.mean(axis=0), single.mean(axis=0), atol=0.02)
    gap = NAMES.index("L")
    assert abs(start.centre[gap] - TRUTH[gap]) > 4.0
    assert abs(found.mean(axis=0)[gap] - TRUTH[gap]) < 2.0
    assert 1 / 1.5 < excess(start.spread, single) < 1.5


def test_a_common_curve_of_records_with_missing_samples(sensor):
    """Its statistic is that of generalised least squares with every covariance written out."""
    rng = generator(1, "test", "common curve")
    residuals = sensor.corrupt(np.zeros((9, 12)), rng)
    whole = _common_curve(sensor, residuals)
    gone = rng.random(residuals.shape) < 0.3
    gone[:, 5] = True
    residuals[gone] = np.nan
    precision, total = np.zeros((12, 12)), np.zeros(12)
    for record in residuals:
        there = np.flatnonzero(~np.isnan(record))
        t = there.size
        inverse = np.linalg.inv(sensor.noise_sd**2 * np.eye(t) + sensor.zero_sd**2)
        precision[np.ix_(there, there)] += inverse
        total[there] += inverse @ record[there]
    seen = np.delete(np.arange(12), 5)
    solved = np.linalg.solve(precision[np.ix_(seen, seen)], total[seen])
    expected = chi2.sf(total[seen] @ solved, df=11)
    assert _common_curve(sensor, residuals) == pytest.approx(expected, rel=1e-9)
    assert 1e-3 < whole < 1 - 1e-3
    # A curve in common is seen, with samples missing as without.
    assert _common_curve(sensor, residuals + np.linspace(-0.3, 0.3, 12)) < 1e-6
