"""Answers of the networks that ship: exactly as large as the drive, whatever its size."""

from dataclasses import replace

import numpy as np
import pytest

from breaker.common.tensor_file import ModelFileError
from breaker.family.inputs import NormalisedRecords
from breaker.family.networks import EFFECTS, EVENTS, StateNetwork, effect_outputs
from breaker.model.parameters import MOTIONS, NAMES, UNIT, Size


def record(levels: StateNetwork, motion: str, size: Size = UNIT) -> NormalisedRecords:
    """A shape in the middle of the family, of a drive of a size."""
    way = levels.bases[motion].mean[None]
    stroke, duration = np.exp(levels.usual[:, 0])
    numbers = [size.lengths * stroke, size.times * duration, 3e-3, 0.0, 0.05]
    return NormalisedRecords(
        np.array([True]), way, way > -9.0, *(np.array([each]) for each in numbers)
    )


@pytest.mark.parametrize("known", [False, True])
@pytest.mark.parametrize("motions", [MOTIONS[:1], MOTIONS[1:], MOTIONS])
def test_an_answer_scales_exactly(levels, motions, known):
    large = Size(lengths=11.6, times=4.25)
    one, other = (
        levels.draw(
            *({m: record(levels, m, size) for m in motions}, 50, np.random.default_rng(1)),
            size=size if known else None,
        )
        for size in (UNIT, large)
    )
    np.testing.assert_allclose(other.theta, one.theta * large.factors, rtol=2e-6)
    for name in ("release", "switching"):
        for motion in motions:
            scaled = large.times * getattr(one, name)[motion]
            np.testing.assert_allclose(getattr(other, name)[motion], scaled, rtol=2e-6)


def test_mechanisms_are_told_in_the_units_of_the_drive(levels):
    large = Size(lengths=11.6, times=4.25)
    one, other = (
        levels.draw({"closing": record(levels, "closing", size)}, 50, np.random.default_rng(1))
        for size in (UNIT, large)
    )
    assert [*one.effects] == [*EFFECTS]
    for name, draws in one.effects.items():
        factor = large.times if name == "build_up" else 1.0
        np.testing.assert_allclose(other.effects[name], factor * draws, rtol=2e-6)
        assert 0.0 < np.mean(draws == 0.0) < 1.0 or name == "sliding_contact"
    assert not one.effects["sliding_contact"].any()  # no drive of medium voltage has one
    sizes = {name: draws for name, draws in one.effects.items()}
    assert effect_outputs(sizes, np.ones(50)).shape == (50, len(EFFECTS))


def test_a_draw_beyond_all_drives_is_replaced_and_many_are_no_answer(levels, monkeypatch):
    """Planted fault: one such draw in a million left a record without an answer."""
    sample, seen = type(levels.network).sample, {"closing": record(levels, "closing")}
    usual = levels.draw(seen, 100, np.random.default_rng(1))

    def draw(count, of=100, **given):
        def beyond(*args):
            found = sample(*args)
            found[0, :count, 3] = 1e6
            return found

        monkeypatch.setattr(type(levels.network), "sample", beyond)
        return levels.draw(seen, of, np.random.default_rng(1), **given)

    one = draw(1)
    assert np.isfinite(one.theta).all()
    assert np.log(one.theta) == pytest.approx(np.log(usual.theta), abs=5.0)
    for count, of in ((2, 100), (1, 1)):  # many, and the only one
        with pytest.raises(ModelFileError, match="no sizes of a drive"):
            draw(count, of)
    with pytest.raises(ModelFileError, match="the size that is given is far"):
        draw(2, size=Size())


def test_draws_are_as_much_wider_as_said(levels):
    """About the same medians, and less correlated; of one motion, and not of both.

    Bounds are six standard errors of 4,000 draws or more: false alarm below 1e-6.
    """
    factors = np.linspace(1.0, 2.0, len(NAMES) + len(EVENTS))
    wide = replace(levels, widening={1: factors})
    seen = {motion: record(levels, motion) for motion in MOTIONS}
    bare = replace(levels, widening={})
    for motions in (MOTIONS[:1], MOTIONS):
        some = {motion: seen[motion] for motion in motions}
        one, other = (
            np.log(each.draw(some, 4000, np.random.default_rng(1)).theta) for each in (bare, wide)
        )
        factor = factors[: len(NAMES)] if len(motions) == 1 else np.ones(len(NAMES))
        middles = (np.median(each, axis=0) for each in (one, other))
        assert np.all(np.abs(np.subtract(*middles)) <= 0.15 * one.std(axis=0) * (factor > 1.0))
        np.testing.assert_allclose(other.std(axis=0) / one.std(axis=0), factor, rtol=0.05)
        shared = np.sqrt(1.0 + 0.75 * (factor**2 - 1.0)) / factor  # of what outputs have in common
        expected = np.corrcoef(one.T) * np.outer(shared, shared)
        np.fill_diagonal(expected, 1.0)
        np.testing.assert_allclose(np.corrcoef(other.T), expected, atol=0.1)


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
