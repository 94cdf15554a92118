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
    records = {motion: [] for motion in MOTIONS}
    change = np.array([factors.get(name, 1.0) for name in NAMES])
    for motion, raws in records.items():
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
    return records


def explained(seed, sliding=0.0, **change):
    """Explanations of a change by their cause."""
    rng = np.random.default_rng(seed)
    before = inspection(rng, contact=change.get("contact", False))
    pair = Pair.of(before, inspection(rng, **change))
    causes = explain(pair, shipped_sensitivities(FAMILY), sliding=sliding)
    assert sum(one.probability for one in causes) == pytest.approx(1.0)
    return {one.cause: one for one in causes}


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
    best = max(explained(3, **change).values(), key=lambda one: one.probability)
    assert (best.cause, best.parameter) == (cause, parameter)
    assert best.probability > (0.95 if change else 0.5)
    if amount is not None:
        assert best.change[1] == pytest.approx(amount, abs=1.5)


def test_a_recorded_contact_distinguishes_a_ratio_from_a_force():
    """A ratio scales the travel at the contact, and a force hardly does. A contact that may slide
    leaves a ratio uncertain unless it is recorded.
    """
    odds = {}
    for contact, ratio in product((False, True), repeat=2):
        causes = explained(4, contact=contact, **({"ratio": 0.95} if ratio else {"f": 0.95}))
        drive, other = (causes[cause].probability + 1e-300 for cause in ("drive", "ratio"))
        odds[contact, ratio] = np.log(drive / other)
    assert odds[True, False] > odds[False, False] > 0.0
    assert odds[True, True] < odds[False, True] < 0.0
    for contact in (False, True):
        drive = explained(6, sliding=0.3, ratio=0.94, contact=contact)["drive"]
        assert (drive.probability < 0.05) == contact


def test_amounts_are_as_uncertain_as_stated():
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


def test_shipped_slopes_agree_with_the_exact_curve_of_the_model():
    """Slopes by f and k_a at the medians, within a tenth: the family has many other effects."""
    step, by = 0.05, 0.03
    times = np.arange(-12.0, 110.0, step)
    shapes, slopes, durations = [], [], []
    for motion in MOTIONS:
        sign = 1.0 if motion == "closing" else -1.0
        rows = THETA * np.exp(by * np.concatenate([np.zeros((1, 7)), np.eye(7), -np.eye(7)]))
        curves = sign * travel(rows, times, motion).travel
        like = shape_of(curves[0], step)
        ways = np.array([shape_of(curve, step, like).way for curve in curves])
        shapes.append(ways[0])
        durations.append(like.duration)
        slopes.append((ways[1:8] - ways[8:]) / (2.0 * by))
    pace = np.log(durations[1] / durations[0])
    shipped, _ = shipped_sensitivities(FAMILY)[MOTIONS].of(np.concatenate(shapes), pace)
    shipped = shipped.reshape(len(NAMES), 2, -1)[:, :, : SHAPE_TIMES.size]
    for place in (NAMES.index("f"), NAMES.index("k_a")):
        exact = np.array([slope[place] for slope in slopes])
        off = np.square(shipped[place] - exact).mean() / np.square(exact).mean()
        assert np.sqrt(off) < 0.1
