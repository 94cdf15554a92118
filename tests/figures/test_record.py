"""The figure of an inspected record: motions, rests, first motions, doubts and noise."""

import numpy as np
import pytest

from breaker.configuration.definitions import simulated_test
from breaker.family.curve_file import write_curve
from breaker.family.endurance import EnduranceTest
from breaker.figures import style
from breaker.figures.records import record
from breaker.records.proposal import inspect_file
from tests.figures.drawn import line_of, words

SENSOR = {"start": -2.0, "stop": 58.0, "samples": 151, "noise_sd": 0.1}


@pytest.fixture(scope="module")
def both(defaults):
    """Close and open in one record, 100 ms apart: times, ms, and travel, mm."""
    drive = EnduranceTest.from_settings(simulated_test(defaults), 1).new
    time = np.arange(0.0, 220.0, 0.1)
    exact = np.where(
        time < 120.0, drive.travel("closing", time - 20.0), drive.travel("opening", time - 120.0)
    )
    return time, exact + 0.05 * np.random.default_rng(1).standard_normal(time.size)


def proposal_of(folder, time, travel):
    file = folder / "record_1.csv"
    write_curve(file, time, travel, motion="closing", operation=1)
    return inspect_file(file, SENSOR)


@pytest.fixture(scope="module")
def proposal(both, tmp_path_factory):
    time, travel = both
    travel = travel.copy()
    travel[300] = 40.0  # doubtful
    return proposal_of(tmp_path_factory.mktemp("record"), time, travel)


@pytest.fixture(scope="module")
def figure(proposal):
    return record(proposal)


def test_the_record_is_drawn_without_its_doubtful_samples(figure, both):
    drawn = line_of(figure.axes[0], style.MEASURED).get_ydata()
    expected = both[1].round(3)
    expected[300] = np.nan
    np.testing.assert_allclose(drawn, expected, atol=1e-9)
    marked = line_of(figure.axes[0], style.WARNING, "x")
    assert marked.get_xdata() == pytest.approx([30.0])


def test_first_motions_are_marked_where_they_are(figure, proposal):
    moves = [each.record.moves for each in proposal.motions]
    assert moves == pytest.approx([20.0, 120.0], abs=0.6)
    lines = [line.get_xdata() for line in figure.axes[0].lines]
    upright = [xs[0] for xs in lines if len(xs) == 2 and xs[0] == xs[1]]
    assert upright == moves
    for axis, each in zip(figure.axes[2:4], proposal.motions, strict=True):
        assert f"{each.motion} begins at {each.record.moves:.1f} ms" in axis.get_title("left")


def test_what_could_not_be_read_is_drawn_as_it_is(both, tmp_path):
    time, travel = both
    travel = travel[:1100].copy()
    proposal = proposal_of(tmp_path, time[:1100], travel)
    refused = [
        type(each)(**{**vars(each), "result": None, "said": "no"}) for each in proposal.motions
    ]
    figure = record(type(proposal)(**{**vars(proposal), "motions": refused}))
    assert proposal.layout.file.name in words(figure)
    np.testing.assert_allclose(figure.axes[0].lines[0].get_ydata(), travel.round(3), atol=1e-9)
