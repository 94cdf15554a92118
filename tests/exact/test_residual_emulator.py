"""What an emulator learns of residuals, its slopes, and from where it starts."""

import numpy as np
import pytest

from breaker.common.randomness import generator
from breaker.drive.exact import residual_emulator
from breaker.drive.exact.residual_emulator import ResidualEmulator, _forward

_DRIVES, _TRIED = 2000, 300


@pytest.fixture(autouse=True)
def small(monkeypatch):
    monkeypatch.setattr(residual_emulator, "_HIDDEN", (32, 32))


def drives(n, name, where=0.0, sd=1.0):
    """Numbers of drives ``(n, 4)``: two of either sign, one that is above 0 and varies as widely as
    a parameter does, and one that is the same for all.
    """
    scores = where + sd * generator(1, "emulator", name).standard_normal((n, 3))
    return np.column_stack([scores[:, :2], np.exp(0.4 * scores[:, 2]), np.full(n, 3.0)])


def residuals(numbers):
    """Smooth residuals, ``(n, 5)``, some units large."""
    first, second, size, _ = numbers.T
    whole = [np.sin(first) + 0.5 * second, first * second, 2.5 * np.log(size), size, first + 1.0]
    return 2.0 * np.column_stack(whole)


def log_likelihood(numbers):
    return -0.5 * np.square(residuals(numbers)).sum(axis=1)


def learned(steps, *, seed=2, before=None, **where):
    numbers = drives(_DRIVES, "learned", **where)
    rng = generator(seed, "emulator, training")
    given = numbers, residuals(numbers).astype(np.float32), 1.0, steps, rng
    return ResidualEmulator.fit(*given, before)


def off(emulator, **where):
    """Root mean square error of log likelihoods of drives that are near, nats."""
    numbers = drives(_TRIED, "tried", **where)
    true = log_likelihood(numbers)
    near = true > np.median(true) - 5.0
    return float(np.sqrt(np.square(emulator.log_likelihood(numbers) - true)[near].mean()))


def test_more_steps_learn_more_of_a_smooth_function():
    none, much = (off(learned(steps)) for steps in (0, 1000))
    assert much < 0.5 * none
    assert much < 0.1  # nats, where log likelihoods differ by several


def test_a_number_that_never_varies_is_no_input():
    emulator = learned(0)
    assert emulator.used.tolist() == [True, True, True, False]
    inputs = emulator.inputs(drives(_DRIVES, "learned"))
    assert np.allclose(inputs.mean(axis=0), 0.0, atol=1e-9)
    assert np.allclose(inputs.std(axis=0), 1.0)


def test_slopes_are_those_of_the_log_likelihood():
    emulator = learned(100)
    numbers = drives(_TRIED, "tried")
    numbers = numbers[(np.abs(emulator.inputs(numbers)) < 3.0).all(axis=1)]
    log, slopes = emulator.slopes(numbers)
    assert log.shape == (len(numbers),)
    assert not slopes[:, 3].any()
    for j in range(3):
        by = 1e-2 * np.eye(4)[j]  # float32: smaller steps are lost in its digits
        by = by * numbers if j == 2 else by
        there = numbers + by, numbers - by
        found = np.subtract(*map(emulator.log_likelihood, there))
        expected = 2.0 * (slopes * by).sum(axis=1)
        assert np.allclose(found, expected, atol=0.02 * np.abs(expected).max()), j


def test_slopes_and_log_likelihoods_are_of_one_function():
    emulator, numbers = learned(100), drives(_TRIED, "tried")
    assert np.array_equal(emulator.slopes(numbers)[0], emulator.log_likelihood(numbers))


def test_far_beyond_what_was_learned_nothing_changes():
    emulator = learned(100)
    far = np.array([[7.0, 7.0, np.exp(7.0), 3.0]])
    log, slopes = emulator.slopes(far)
    assert not slopes.any()
    assert log == emulator.slopes(far + 1.0)[0]


def test_an_emulator_starts_where_the_one_before_was():
    """Also where the drives, and so the middle and the scale of the inputs, are others."""
    before, near = learned(1000), {"where": 0.8, "sd": 0.5}
    for steps in (0, 100):
        told = off(learned(steps, before=before, **near), **near)
        assert told < 0.7 * off(learned(steps, **near), **near)
    new, numbers = learned(0, before=before, **near), drives(_TRIED, "tried")
    there = (_forward(e.layers[:-2], e.inputs(numbers))[0] for e in (before, new))
    assert np.allclose(next(there), next(there), atol=1e-4)


def test_same_seed_same_bytes():
    first, again, other = learned(30), learned(30), learned(30, seed=3)
    assert [e.tobytes() for e in first.layers] == [e.tobytes() for e in again.layers]
    assert first.linear.tobytes() == again.linear.tobytes()
    assert first.layers[0].tobytes() != other.layers[0].tobytes()


def test_what_no_component_shows_is_in_the_rest():
    """Residuals that are the same for all drives count, though none is learned."""
    numbers = drives(_DRIVES, "learned")
    more = np.column_stack([residuals(numbers), np.full(_DRIVES, 3.0)]).astype(np.float32)
    rng = generator(2, "emulator, training")
    emulator = ResidualEmulator.fit(numbers, more, 1.0, 30, rng)
    assert emulator.linear.shape == (3, 5)
    assert emulator.rest == pytest.approx(9.0, rel=1e-4)
