"""Two inspections explained by the drive or by its measurement."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest

from breaker.diagnosis.changes import Pair
from breaker.diagnosis.explanations import _MeanChange, explain
from breaker.family.sensitivities import shipped_sensitivities
from breaker.family.shape import SHAPE_TIMES, shape_of
from breaker.model.curves import travel
from breaker.model.parameters import MOTIONS, NAMES
from breaker.records.contacts import ContactTimes
from tests.raws import raw_of

THETA = np.array([2.0, 0.045, 0.040, 0.30, 0.12, 0.75, 10.0])
LEAD, STEP = 8.0, 0.1
TIMES = np.arange(-LEAD, 70.0, STEP)
FAMILY = "medium_voltage"


def inspection(rng, ratio=1.0, rate=1.0, contact=False, **factors):
    """Records of a drive of the model; its parameters scatter by 0.4 %, with noise of 0.1 mm."""
    found = {motion: [] for motion in MOTIONS}
    change = np.array([factors.get(name, 1.0) for name in NAMES])
    for motion, raws in found.items():
        for _ in range(3):
            theta = THETA * change * np.exp(0.004 * rng.standard_normal(len(NAMES)))
            late = 0.3 * rng.standard_normal()
            curve = travel(theta[None], TIMES / rate, motion, onset=late)
            way = ratio * curve.travel[0] + 0.1 * rng.standard_normal(TIMES.size)
            raw = raw_of(way if motion == "closing" else 3.0 - way, STEP, LEAD, motion)
            if contact:
                at = LEAD + rate * (late + curve.switching[0]) + 0.05 * rng.standard_normal()
                raw = replace(raw, contact=ContactTimes(at, 0.05))
            raws.append(raw)
    return found


def explained(seed, **change):
    rng = np.random.default_rng(seed)
    about = {name: change[name] for name in ("contact",) if name in change}
    before, today = inspection(rng, **about), inspection(rng, **change)
    found = explain(Pair.of(before, today), shipped_sensitivities(FAMILY))
    assert sum(each.probability for each in found) == pytest.approx(1.0)
    return {each.cause: each for each in found}


@pytest.mark.parametrize(
    ("change", "cause", "parameter", "amount"),
    [
        ({}, "none", "", None),
        ({"f": 0.92}, "drive", "f", None),
        ({"gamma_a": 1.2}, "drive", "gamma_a", None),
        ({"ratio": 0.94}, "ratio", "", -6.0),
        ({"rate": 0.5}, "rate", "", -50.0),
    ],
)
def test_the_true_cause_is_the_most_probable(change, cause, parameter, amount):
    found = explained(3, **change)
    best = max(found.values(), key=lambda each: each.probability)
    assert (best.cause, best.parameter) == (cause, parameter)
    assert best.probability > (0.95 if change else 0.5)
    if amount is not None:
        assert best.change[1] == pytest.approx(amount, abs=1.5)


def test_a_recorded_contact_tells_a_ratio_from_a_force():
    """A ratio scales the travel at the contact, and a force hardly does."""
    odds = {}
    for contact, ratio in product((False, True), repeat=2):
        found = explained(4, contact=contact, **({"ratio": 0.95} if ratio else {"f": 0.95}))
        drive, other = (found[cause].probability + 1e-300 for cause in ("drive", "ratio"))
        odds[contact, ratio] = np.log(drive / other)
    assert odds[True, False] > odds[False, False] > 0.0
    assert odds[True, True] < odds[False, True] < 0.0


@pytest.mark.parametrize(("contact", "certain"), [(False, False), (True, True)])
def test_a_contact_that_may_slide_leaves_a_ratio_uncertain_unless_it_is_recorded(contact, certain):
    rng = np.random.default_rng(6)
    before, today = (inspection(rng, r, contact=contact) for r in (1.0, 0.94))
    found = explain(Pair.of(before, today), shipped_sensitivities(FAMILY), sliding=0.3)
    drive = next(each for each in found if each.cause == "drive")
    assert (drive.probability < 0.05) == certain


def test_amounts_are_as_uncertain_as_they_say():
    """Mean squared z of 400 amounts, of mean 1; a false alarm in 1 of 1,000."""
    rng, n = np.random.default_rng(2), 60
    root = rng.standard_normal((n, n)) / np.sqrt(n) + 0.3 * np.eye(n)
    way, usual = np.sin(np.linspace(0.0, 3.0, n)), root @ root.T
    z = []
    for _ in range(400):
        truth = 0.5 * rng.standard_normal()
        change = truth * way + root @ rng.standard_normal(n)
        low, middle, high = _MeanChange(way, change, usual).amount()
        z.append((0.01 * middle - truth) / (0.01 * (high - low) / 3.29))
    assert abs(np.mean(np.square(z)) - 1.0) < 3.29 * np.sqrt(2.0 / 400.0)


def test_what_ships_agrees_with_the_exact_curve_of_the_model():
    """Slopes by f and k_a at the medians, within a tenth: the family has many other effects."""
    step, by = 0.05, 0.03
    times = np.arange(-12.0, 110.0, step)
    shapes, slopes, durations = [], [], []
    for motion in MOTIONS:
        sign = 1.0 if motion == "closing" else -1.0
        rows = THETA * np.exp(by * np.concatenate([np.zeros((1, 7)), np.eye(7), -np.eye(7)]))
        curves = sign * travel(rows, times, motion).travel
        like = shape_of(curves[0], step)
        ways = np.array([shape_of(each, step, like).way for each in curves])
        shapes.append(ways[0])
        durations.append(like.duration)
        slopes.append((ways[1:8] - ways[8:]) / (2.0 * by))
    pace = np.log(durations[1] / durations[0])
    found, _ = shipped_sensitivities(FAMILY)[MOTIONS].of(np.concatenate(shapes), pace)
    found = found.reshape(len(NAMES), 2, -1)[:, :, : SHAPE_TIMES.size]
    for name in ("f", "k_a"):
        exact = np.array([each[NAMES.index(name)] for each in slopes])
        left = found[NAMES.index(name)] - exact
        assert np.sqrt(np.mean(np.square(left))) < 0.1 * np.sqrt(np.mean(np.square(exact)))
