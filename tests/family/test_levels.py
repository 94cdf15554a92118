"""Answers of the networks that ship: exactly as large as the drive, whatever its size."""

import numpy as np
import pytest

from breaker.family import Levels, Seen, open_network
from breaker.mechanism import MOTIONS, Size
from breaker.shipped import model_file


@pytest.fixture(scope="module")
def levels() -> Levels:
    return open_network(model_file("medium_voltage", "levels"))


def record(levels: Levels, motion: str, lengths: float = 1.0, times: float = 1.0) -> Seen:
    """A shape in the middle of the family, of a drive of a size."""
    way = levels.bases[motion].mean[None]
    stroke, duration = np.exp(levels.usual[:, 0])
    numbers = [lengths * stroke, times * duration, 3e-3, 0.0, 0.05]
    return Seen(np.array([True]), way, way > -9.0, *(np.array([each]) for each in numbers))


@pytest.mark.parametrize("motions", [MOTIONS[:1], MOTIONS[1:], MOTIONS])
def test_an_answer_scales_exactly(levels, motions):
    size = Size(lengths=11.6, times=4.25)
    one, other = (
        levels.draw({m: record(levels, m, *each) for m in motions}, 50, np.random.default_rng(1))
        for each in ((1.0, 1.0), (size.lengths, size.times))
    )
    np.testing.assert_allclose(other.theta, one.theta * size.factors, rtol=2e-6)
    for name in ("release", "switching"):
        for motion in motions:
            scaled = size.times * getattr(one, name)[motion]
            np.testing.assert_allclose(getattr(other, name)[motion], scaled, rtol=2e-6)


def test_an_answer_of_a_known_size_scales_with_it(levels):
    size = Size(lengths=11.6, times=4.25)
    one = levels.draw(
        {"closing": record(levels, "closing")}, 50, np.random.default_rng(1), size=Size()
    )
    large = {"closing": record(levels, "closing", size.lengths, size.times)}
    other = levels.draw(large, 50, np.random.default_rng(1), size=size)
    np.testing.assert_allclose(other.theta, one.theta * size.factors, rtol=2e-6)


def test_a_known_size_says_more(levels):
    records = {"closing": record(levels, "closing")}
    widths = [
        np.log(levels.draw(records, 2000, np.random.default_rng(1), size=size).theta).std(axis=0)
        for size in (None, Size())
    ]
    assert widths[1][6] < 0.8 * widths[0][6]  # the gap


def test_two_motions_say_more_than_one(levels):
    widths = [
        np.log(
            levels.draw(
                {m: record(levels, m) for m in motions}, 2000, np.random.default_rng(1)
            ).theta
        ).std(axis=0)
        for motions in (MOTIONS[:1], MOTIONS)
    ]
    assert widths[1].sum() < 0.9 * widths[0].sum()


def test_a_shape_of_no_drive_is_not_of_the_family(levels):
    usual = record(levels, "closing")
    assert levels.match("closing", usual).p_value > 0.05
    way = usual.way + 0.2 * np.sin(6.0 * np.linspace(0.0, 12.0, usual.way.size))
    found = levels.match("closing", usual._replace(way=way))
    assert found.p_value < 1e-3
    assert max(found.parts.values()) > 1.0


def test_a_fault_at_the_end_is_told_at_the_end(levels):
    usual = record(levels, "opening")
    late = np.arange(usual.way.shape[1]) > 80
    found = levels.match("opening", usual._replace(way=usual.way + 0.3 * (late - 0.5) * late))
    assert max(found.parts, key=found.parts.get) == "end"
