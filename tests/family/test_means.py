"""Means of measured records: the inputs that change networks are trained with."""

import numpy as np
import pytest

from breaker.family import training_records
from breaker.family.bank import GRID
from breaker.family.inputs import Basis, mean_and_change, mean_record, without_onset
from breaker.family.shape import SHAPE_TIMES, Shape
from breaker.family.training_rows import ChangeRows
from breaker.model.parameters import MOTIONS
from tests.raws import raw_of, smooth

DRIVES = 12
BASIS = Basis(np.zeros(SHAPE_TIMES.size), np.eye(SHAPE_TIMES.size)[20:60], np.ones(40))
UNITS = Shape(np.zeros(SHAPE_TIMES.size), SHAPE_TIMES > 9.0, 0.0, 80.0, 5.0, 6.0)


def change_of(before, after):
    first = mean_record(before)
    return mean_and_change(first, mean_record(after, first.units), BASIS)


def test_measured_records_are_seen_as_those_of_the_training(bank, monkeypatch):
    """The test measures the samples of the records that the training makes."""
    samples, true, record = [], training_records._motion_of, training_records._record.py_func

    def written(out, step):
        numbers = true(out, step)
        if 0.2 < numbers[3] < 5.0 and numbers[1] > 0.3:
            samples.append((out.copy(), step, numbers[2] - 1.5 * numbers[3]))
        return numbers

    monkeypatch.setattr(training_records, "_motion_of", written)
    monkeypatch.setattr(training_records, "_record", record)
    rows = ChangeRows(bank.isel(drive=slice(DRIVES)), noise=(3e-4, 3e-3), odd=())
    order = np.array([[0] * DRIVES, [1] * DRIVES])
    motions, rng = np.ones((DRIVES, 2), dtype=bool), np.random.default_rng(2)
    references, changes, _ = rows._records(np.arange(DRIVES), order, motions, rng)
    made, noise = iter(samples), []  # by motion, all before and then all after
    for m, motion in enumerate(MOTIONS):
        before, after = (
            [
                raw_of(rows.stroke[d, c] * out, rows.duration[d, c, m] * step, moves, motion)
                for d, (out, step, moves) in zip(range(DRIVES), made, strict=False)
            ]
            for c in (0, 1)
        )
        for d in range(DRIVES):
            reference, change = change_of([before[d]], [after[d]])
            for seen, trained in ((reference, references[motion]), (change, changes[motion])):
                assert seen.present[0].tolist() == trained.present[d].tolist()
                np.testing.assert_allclose(seen.way[0], trained.way[d], rtol=0, atol=1e-9)
            mean = mean_record([before[d]]).seen  # without the scatter of operations
            noise.append(mean.noise[0] / references[motion].noise[d])
            assert reference.stroke[0] == pytest.approx(references[motion].stroke[d])
            assert reference.duration[0] == pytest.approx(references[motion].duration[d])
    # Noise has an error of 10 % in training, and of some 15 more when estimated from a record.
    assert 0.8 < np.median(noise) < 1.25


def test_samples_of_the_training_are_rounded_to_the_quantum_of_the_sensor():
    curve, step, quantum, out = np.sin(GRID), 0.1, 0.02, np.empty(60)
    rng = np.random.default_rng(1)
    training_records._samples.py_func(curve, rng, 0.0, step, 0.0, 0.0, quantum, out)
    np.testing.assert_allclose(out / quantum, np.round(out / quantum), atol=1e-9)
    off = np.abs(out - np.sin(step * np.arange(out.size)))
    assert 0.25 * quantum < off.max() < 0.51 * quantum


def test_a_mean_has_less_noise_and_neither_onset_nor_gap():
    rng = np.random.default_rng(3)
    one, many = (
        mean_record([smooth(rng, late=0.1 * k, until=60.0 - 3.0 * k) for k in range(n)]).seen
        for n in (1, 9)
    )
    assert many.noise[0] == pytest.approx(one.noise[0] / 3.0, rel=0.2)
    clean = mean_record([smooth(rng, noise=1e-9)], UNITS).seen
    own = mean_record([smooth(rng)] * 2, UNITS)
    there = own.seen.present & clean.present
    left = without_onset(clean.way, own.seen.way, there)
    assert np.abs(left).max() < 5.0 * one.noise[0]
    # Of nine records the fifth ends at 48 ms, and has made 10 % of its way at 23.3 ms.
    last = SHAPE_TIMES[many.present[0]][-1] * many.duration[0]
    assert last == pytest.approx(48.0 - 23.3, abs=0.5)


def test_scatter_of_operations_is_noise_of_their_means():
    rng = np.random.default_rng(4)

    def noise(bump, *counts):
        inspections = [
            [smooth(rng, bump=bump * rng.standard_normal()) for _ in range(n)] for n in counts
        ]
        return [float(seen.noise[0]) for seen in change_of(*inspections)]

    steady, scattering, single = noise(0.0, 6, 6), noise(0.1, 6, 6), noise(0.1, 1, 6)
    assert scattering[0] > 5.0 * steady[0]
    assert scattering[1] == pytest.approx(np.sqrt(2.0) * scattering[0], rel=1e-3)
    # A single operation has the scatter of the six of the other inspection.
    assert single[0] > np.sqrt(6.0) * 5.0 * steady[0]
    assert single[1] == pytest.approx(single[0] * np.sqrt(1.0 + 1.0 / 6.0), rel=0.01)
    # Single records have the usual scatter, hundreds their own.
    assert noise(0.0, 1, 1)[0] == pytest.approx(0.005, rel=0.05)
    assert noise(0.0, 99, 99)[0] < 1e-3 / np.sqrt(99.0)
