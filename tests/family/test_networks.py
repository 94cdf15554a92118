"""The state networks that ship: estimates as large as the drive, widening and membership."""

from dataclasses import replace

import numpy as np
import pytest

from breaker.common.tensor_file import ModelFileError
from breaker.family.inputs import NormalisedRecords
from breaker.family.networks import EFFECTS, EVENTS, StateNetwork
from breaker.model.parameters import MOTIONS, NAMES, UNIT, Size


def record(levels: StateNetwork, motion: str, size: Size = UNIT) -> NormalisedRecords:
    """A shape in the middle of the family, of a drive of a size."""
    way = levels.bases[motion].mean[None]
    stroke, duration = np.exp(levels.usual[:, 0])
    numbers = [size.lengths * stroke, size.times * duration, 3e-3, 0.0, 0.05]
    return NormalisedRecords(
        np.array([True]), way, way > -9.0, *(np.array([number]) for number in numbers)
    )


@pytest.mark.parametrize(
    ("motions", "known"), [(MOTIONS[:1], False), (MOTIONS[1:], True), (MOTIONS, False)]
)
def test_an_estimate_scales_with_the_drive(levels, motions, known):
    large = Size(lengths=11.6, times=4.25)
    one, other = (
        levels.draw(
            *({m: record(levels, m, size) for m in motions}, 50, np.random.default_rng(1)),
            size=size if known else None,
        )
        for size in (UNIT, large)
    )
    np.testing.assert_allclose(other.theta, one.theta * large.factors, rtol=2e-6)
    for motion in motions:
        for small, scaled in ((one.release, other.release), (one.switching, other.switching)):
            np.testing.assert_allclose(scaled[motion], large.times * small[motion], rtol=2e-6)
    assert [*one.effects] == [*EFFECTS]
    for name, draws in one.effects.items():
        factor = large.times if name == "build_up" else 1.0
        np.testing.assert_allclose(other.effects[name], factor * draws, rtol=2e-6)
        assert 0.0 < np.mean(draws == 0.0) < 1.0 or name == "sliding_contact"
    assert not one.effects["sliding_contact"].any()  # no drive of medium voltage has one


def test_a_draw_beyond_all_drives_is_replaced_and_many_are_an_error(levels, monkeypatch):
    """Planted fault: one such draw in a million left a record without an estimate."""
    sample, seen = type(levels.network).sample, {"closing": record(levels, "closing")}
    usual = levels.draw(seen, 100, np.random.default_rng(1))

    def draw(count, of=100, **given):
        def beyond(*args):
            outputs = sample(*args)
            outputs[0, :count, 3] = 1e6
            return outputs

        monkeypatch.setattr(type(levels.network), "sample", beyond)
        return levels.draw(seen, of, np.random.default_rng(1), **given)

    assert np.log(draw(1).theta) == pytest.approx(np.log(usual.theta), abs=5.0)
    for count, of in ((2, 100), (1, 1)):  # many, and the only one
        with pytest.raises(ModelFileError):
            draw(count, of, size=Size())


def test_factors_widen_draws_about_their_medians(levels):
    """Less correlated, and of one motion only.

    Bounds are six standard errors of 4,000 draws or more: false alarm below 1e-6.
    """
    factors = np.linspace(1.0, 2.0, len(NAMES) + len(EVENTS))
    for motions in (MOTIONS[:1], MOTIONS):
        some = {motion: record(levels, motion) for motion in motions}
        one, other = (
            np.log(network.draw(some, 4000, np.random.default_rng(1)).theta)
            for network in (replace(levels, widening=by) for by in ({}, {1: factors}))
        )
        factor = factors[: len(NAMES)] if len(motions) == 1 else np.ones(len(NAMES))
        moved = np.median(other, axis=0) - np.median(one, axis=0)
        assert np.all(np.abs(moved) <= 0.15 * one.std(axis=0) * (factor > 1.0))
        np.testing.assert_allclose(other.std(axis=0) / one.std(axis=0), factor, rtol=0.05)
        shared = np.sqrt(1.0 + 0.75 * (factor**2 - 1.0)) / factor  # that outputs have in common
        expected = np.corrcoef(one.T) * np.outer(shared, shared)
        np.fill_diagonal(expected, 1.0)
        np.testing.assert_allclose(np.corrcoef(other.T), expected, atol=0.1)


def test_a_shape_of_no_drive_is_outside_the_family_where_it_differs(levels):
    usual = record(levels, "opening")
    assert levels.match("opening", usual).p_value > 0.05
    late = np.arange(usual.way.shape[1]) > 80
    match = levels.match("opening", usual._replace(way=usual.way + 0.3 * (late - 0.5) * late))
    assert match.p_value < 1e-3
    assert max(match.parts, key=match.parts.get) == "end"
    assert match.parts["end"] > 1.0
