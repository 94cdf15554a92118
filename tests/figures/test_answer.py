"""The picture of an answer."""

import numpy as np
import pytest

from breaker.diagnosis.curves import PictureCurve, Shown
from breaker.figures import style
from breaker.figures.records import answer
from tests.figures.drawn import assert_drawn, line_of

MOTIONS = ["closing", "opening"]


def data(motions=("closing",), *, good=True, inferred=True, file="{}$.csv"):
    rng = np.random.default_rng(1)
    time, none = np.linspace(-2.0, 58.0, 31), np.empty(0)
    curves = {
        motion: PictureCurve(
            *(file.format(motion), "words of a fit", good),
            *(time, rng.normal(size=31), time, rng.normal(size=31)),
            rng.normal(size=31),
            10.0 + rng.random(60) if inferred else none,
        )
        for motion in motions
    }
    theta = [1.0 + 0.1 * rng.random((60, 7)) for _ in range(2)]
    posteriors = {" and ".join(motions): theta}
    prior = 1.0 + rng.random((60, 7))
    return Shown(curves, posteriors if inferred else {}, prior)


NAME = "North_400_kV_Bay_4_circuit_breaker_Q0_after_overhaul_of_drive_and_linkage_{}.csv"
CASES = {
    "a closing": {},
    "both motions": {"motions": MOTIONS, "file": NAME},
    "a misfit": {"good": False},
    "nothing inferred": {"good": False, "inferred": False},
}


@pytest.mark.parametrize("case", CASES)
def test_each_motion_has_its_record_and_each_parameter_its_panel(case):
    found = data(**CASES[case])
    figure = answer(found)
    assert_drawn(figure)
    assert len(figure.axes) == 2 * len(found.curves) + 8
    for axis, curve in zip(figure.axes, found.curves.values(), strict=False):
        np.testing.assert_array_equal(line_of(axis, style.MEASURED).get_ydata(), curve.travel)
