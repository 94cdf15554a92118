"""The picture of an answer."""

import numpy as np
import pytest

from breaker.drive.answers.picture_data import PictureCurve, Shown
from breaker.figures.answer import answer
from tests.figures.drawn import assert_drawn

MOTIONS = ["closing", "opening"]


def data(motions=("closing",), *, good=True, inferred=True, file="{}$.csv"):
    rng = np.random.default_rng(1)
    time, none = np.linspace(-2.0, 58.0, 31), np.empty(0)
    curves = {
        motion: PictureCurve(
            *(file.format(motion), "words of a fit", good),
            *(time, rng.normal(size=31), time, rng.normal(size=31)),
            *(rng.normal(size=31), np.ones(31)),
            10.0 + rng.random(60) if inferred else none,
        )
        for motion in motions
    }
    theta = [1.0 + 0.1 * rng.random((60, 7)) for _ in range(2)]
    switching = {motion: [10.0 + rng.random(60)] for motion in motions}
    posteriors = {" and ".join(motions): theta}
    prior = 1.0 + rng.random((60, 7))
    return Shown(
        *("Title_1$", curves, posteriors if inferred else {}, prior),
        switching if inferred else {},
    )


NAME = "North_400_kV_Bay_4_circuit_breaker_Q0_after_overhaul_of_drive_and_linkage_{}.csv"
CASES = {
    "a closing": {},
    "both motions": {"motions": MOTIONS, "file": NAME},
    "a misfit": {"good": False},
    "nothing inferred": {"good": False, "inferred": False},
}


@pytest.mark.parametrize("case", CASES)
def test_an_answer_is_drawn_as_it_was(case):
    """Each motion has its record, each parameter its panel; long names stay above theirs."""
    assert_drawn(answer(data(**CASES[case])), f"answer, {case}")
