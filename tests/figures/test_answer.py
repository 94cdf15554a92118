"""The picture of an answer."""

import numpy as np
import pytest
from matplotlib.text import Text

from breaker.answers.drawn import Curve, Shown
from breaker.figures.answer import answer
from breaker.figures.style import WARNING
from tests.figures.drawn import assert_nothing_overlaps

MOTIONS = ["closing", "opening"]


def data(motions=("closing",), *, good=True, inferred=True, file="{}$.csv"):
    rng = np.random.default_rng(1)
    time, none = np.linspace(-2.0, 58.0, 31), np.empty(0)
    curves = {
        motion: Curve(
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


@pytest.mark.parametrize("motions", [["closing"], MOTIONS])
def test_each_motion_has_its_record_and_each_parameter_its_panel(motions):
    figure = answer(data(motions))
    assert len(figure.axes) == 2 * len(motions) + 8
    titles = [axis.get_title(loc="left") for axis in figure.axes]
    for motion in motions:
        assert any(each.startswith(f"{motion} in {motion}") for each in titles)
    assert "touch at" in figure.axes[0].texts[0].get_text()
    said = [each.get_text() for each in figure.findobj(Text)]
    assert any("posterior of " + " and ".join(motions) in each for each in said)


@pytest.mark.parametrize(("good", "colour"), [(True, "black"), (False, WARNING)])
def test_a_misfit_is_red(good, colour):
    figure = answer(data(good=good))
    (title,) = (e for e in figure.axes[0].findobj(Text) if "words of a fit" in e.get_text())
    assert title.get_color() == colour


def test_where_nothing_is_inferred_the_records_are_drawn():
    figure = answer(data(good=False, inferred=False))
    assert not figure.axes[0].texts
    assert "not inferred" in [text.get_text() for text in figure.axes[-1].texts]


def test_long_names_of_files_stay_above_their_panels():
    name = "North_400_kV_Bay_4_circuit_breaker_Q0_after_overhaul_of_drive_and_linkage_{}.csv"
    assert_nothing_overlaps(answer(data(MOTIONS, file=name)))
