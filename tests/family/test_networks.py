"""The networks that ship: estimates as large as the drive, membership, and what a file may be."""

import json
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from safetensors import safe_open

from breaker.common.tensor_file import ModelFileError, write_model
from breaker.family.inputs import NormalisedRecords
from breaker.family.membership import Match, choose_family
from breaker.family.networks import EFFECTS, EVENTS, StateNetwork, open_network
from breaker.model.parameters import MOTIONS, NAMES, UNIT, Size
from breaker.shipped import KINDS, model_file


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


# ---- membership ----------------------------------------------------------------------------------


def family(name, closing, opening, evidence=0.0):
    """One in which records of each motion have p-values, and give evidence together."""
    return SimpleNamespace(name=name, closing=closing, opening=opening, evidence=evidence)


def matched(family):
    p_values = family.closing, family.closing / 10.0, family.closing, family.opening
    half = family.evidence / 2.0
    matches = [Match(p, {"start": 1.0 / p, "end": float("nan")}, None, half) for p in p_values]
    return list(zip(["closing"] * 3 + ["opening"], matches, strict=True))


@pytest.mark.parametrize(
    ("first", "second", "name", "fit"),
    [
        ((0.2, 0.1), (0.9, 0.9, 9.0), "first", True),  # no other one is looked at
        ((0.2, 1e-5), (0.01, 0.01), "second", True),
        ((0.2, 0.05), (0.9, 0.05, 2.0), "second", True),  # at the edge of the first: foreign to it
        ((0.2, 0.05), (0.9, 0.9, -2.0), "first", True),
        ((0.2, 0.05), (0.9, 5e-4, 9.0), "first", True),
        ((1e-4, 0.9), (1e-5, 0.9, 9.0), "first", False),
        ((1e-4, 1e-5), (1e-5, 1e-5), "first", False),
    ],
)
def test_the_family_of_most_evidence_counts_that_fits_every_motion_or_the_nearest(
    first, second, name, fit
):
    families = (family(*item) for item in (("first", *first), ("second", *second)))
    chosen, matches, fits = choose_family(families, matched, 1e-3)
    assert (chosen.name, fits) == (name, fit)
    assert len(matches) == 4


# ---- files ---------------------------------------------------------------------------------------


@pytest.fixture(scope="module", params=KINDS)
def parts(request):
    """Settings and tensors of a network that ships."""
    with safe_open(str(model_file("any", request.param)), framework="numpy") as file:
        settings = json.loads(file.metadata()["settings"])
        return settings, {name: file.get_tensor(name) for name in list(file.keys())}


def reading(folder, settings, tensors):
    """Read a file of these, written as if it was right."""
    write_model(folder / "m.safetensors", settings, tensors)
    return open_network(folder / "m.safetensors")


def test_a_file_is_read_with_all_tensors_and_settings_of_a_drive_only(parts, tmp_path):
    settings, tensors = parts
    assert reading(tmp_path, settings, tensors).settings == settings
    for name in ("usual", "bases.closing.mean", "network.inference.leave"):
        left = {key: tensor for key, tensor in tensors.items() if key != name}
        with pytest.raises(ModelFileError):
            reading(tmp_path, settings, left)

    for value in (None, "x", -1, [], {}):
        prior = {"prior": settings["prior"] | {"L": value}}
        for wrong in ({"kind": value}, {"prior": value}, prior):
            with pytest.raises(ModelFileError):
                reading(tmp_path, settings | wrong, tensors)
