"""The figure of identifiability: contraction of every source where it is, and in numbers."""

import numpy as np
import pytest

from breaker.figures import style
from breaker.figures.identifiability import identifiability
from breaker.validation import comparison
from tests.figures.drawn import assert_nothing_overlaps, line_of, segments, words
from tests.validation.made import NAMES, contractions


@pytest.fixture(scope="module")
def identified():
    values = {name: each for name, each in contractions().items() if name != "drive"}
    found = comparison.reached(values, NAMES)
    return found, identifiability(found, motion="closing")


def test_contractions_are_drawn_where_they_are(identified):
    found, figure = identified
    axis = figure.axes[0]
    rows = np.arange(8)
    limit = found.sel(source="limit")
    for patch, low, high, row in zip(axis.patches, limit.lower, limit.upper, rows, strict=True):
        box = patch.get_bbox()
        assert (box.x0, box.x1) == pytest.approx((float(low), float(high)))
        assert box.y0 < row < box.y1
    (dashes,) = segments(axis, style.MEASURED)
    np.testing.assert_allclose(dashes[..., 0], limit["mean"].values[:, None] + [0, 0])
    colours = {"amortised": style.AMORTISED, "corrected": style.CORRECTED}
    for source, colour in colours.items():
        one = found.sel(source=source)
        marks = line_of(axis, colour)
        np.testing.assert_allclose(marks.get_xdata(), one["mean"])
        ends = np.stack([one.lower, one.upper], axis=1)
        np.testing.assert_allclose(segments(axis, colour)[0][..., 0], ends)
        np.testing.assert_allclose(segments(axis, colour)[0][:, 0, 1], marks.get_ydata())
        assert np.all(np.abs(np.asarray(marks.get_ydata()) - rows) < 0.36)  # inside the band
    thresholds = {line.get_xdata()[0] for line in axis.lines if line.get_linestyle() == ":"}
    assert thresholds == {0.5, 0.8}
    assert axis.get_xlim() == (0.0, 1.0)


def test_each_row_has_its_name_numbers_and_words(identified):
    found, figure = identified
    axis, table = figure.axes
    for row, name in enumerate(found.output.values):
        label = axis.get_yticklabels()[row].get_text()
        assert label == f"{style.OUTPUTS[name].meaning}   {style.OUTPUTS[name].symbol}"
        beside = [text.get_text() for text in table.texts if text.get_position()[1] == row]
        one = found.sel(output=name)
        numbers = [f"{one['mean'].sel(source=each).item():.3f}" for each in found.source.values]
        assert beside == [*numbers, one.known.item()]
    above = [text.get_text() for text in table.texts if text.get_position()[1] < 0]
    assert above == ["limit", "amortised", "corrected", "over the prior"]


def test_identifiability_says_what_came_out(identified):
    text = words(identified[1])
    expected = [
        "Closing: how well the curve determines each parameter\nover the prior",
        "linearised limit: 90 % of 200 draws of the prior",
        "amortised (network alone): mean and 90 % of 50 simulated curves",
        "corrected (exact posterior): mean and 90 % of 48 simulated curves",
        "0: nothing learnt, the prior stays;  1: known exactly",
    ]
    assert [each for each in expected if each not in text] == []
    assert_nothing_overlaps(identified[1])


def test_identifiability_without_onset_and_below_zero():
    """A posterior wider than its prior stays in sight."""
    values = contractions(NAMES[:7], shift=0.5)
    values.pop("drive")
    found = comparison.reached(values, NAMES[:7])
    figure = identifiability(found, motion="opening")
    assert len(figure.axes[0].get_yticklabels()) == 7
    assert "$t_0$" not in "".join(t.get_text() for t in figure.axes[0].get_yticklabels())
    assert figure.axes[0].get_xlim()[0] <= found.lower.values.min() < 0
    assert figure.get_suptitle().startswith("Opening: ")
    assert_nothing_overlaps(figure)
