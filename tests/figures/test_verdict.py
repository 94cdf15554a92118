"""The first page: sentences, rows, intervals and arrows."""

import numpy as np
import pytest
import xarray as xr
from matplotlib.colors import to_hex

from breaker.decisions import STATES
from breaker.figures.verdict import COLOURS, verdict
from tests.figures.drawn import assert_nothing_overlaps, words, written
from tests.figures.test_operations import LIMITS, QUANTILES


def verdict_data(count=4):
    """Healthy, with a trend, exceeded, unknown, and then all of them again."""
    way = [[5, 12, 20], [35, 48, 60], [90, 104, 140], [np.nan] * 3]
    remaining = [[np.nan] * 3, [900, 2130, np.inf], [0, 0, 60], [np.nan] * 3]
    way += [[-40, -10, 5], [70, 78, 84], [99, 100, 101], [0, 15, 30]]
    remaining += [[4000, 9000, np.inf], [310, 421, 633], [0, 0, 0], [np.nan] * 3]
    state = ["healthy", "plan", "plan", "unknown", "drifting", "plan", "now", "healthy"]
    since = [np.nan] * 6 + [1912, np.nan]
    way, remaining, state, since = 2 * way, 2 * remaining, 2 * state, 2 * since  # for many limits
    return xr.Dataset(
        {
            "way": (("limit", "quantile"), np.array(way[:count], dtype=float)),
            "remaining": (("limit", "quantile"), np.array(remaining[:count], dtype=float)),
            "state": ("limit", state[:count]),
            "since": ("limit", since[:count]),
            "words": ("limit", (2 * [*LIMITS.values()])[:count]),
        },
        {"limit": [*LIMITS, *(f"{name}_2" for name in LIMITS)][:count], "quantile": QUANTILES},
        {
            "headline": "Service now: little wipe exceeded since operation 1,912.",
            "wearing": "Wearing: friction of the drive, plus 7.4 % in 1000 operations "
            "(5.9 to 9.1), since operation 1761 (1745 to 1772).",
            "left": "Left: 2,130 operations until tired closing (900 to beyond the horizon); "
            "no trend towards the others.",
            "trust": "Trust: closing differs from the model by 0.4 mm at the start, 0.2 mm in the "
            "main motion and 1.1 mm at the end, as drives of the family do (0.5, 0.3, 1).",
        },
    )


@pytest.mark.parametrize("count", [1, 8, 12])
def test_verdict_says_it_in_few_lines_and_rows(count):
    data = verdict_data(count)
    figure = verdict(data)
    assert_nothing_overlaps(figure)
    text, left, right = figure.axes
    assert figure.get_suptitle() == data.headline
    said = " ".join(written(text)[0].split())
    assert said == f"{data.wearing} {data.trust}"  # what is left stands in the rows
    width = figure.bbox.width
    assert text.texts[0].get_window_extent().x1 < width
    assert figure._suptitle.get_window_extent().x1 < width
    by_row = [
        (each.xy[1], each.get_text(), each.get_color())
        for each in left.texts
        if each.get_text() in COLOURS
    ]
    expected = [
        (row, str(state), COLOURS[str(state)]) for row, state in enumerate(data.state.values)
    ]
    assert by_row == expected
    rights = ["no trend", "2,130  (900 to beyond)", "0  (0 to 60)", "cannot be told"]
    rights += ["9,000  (4,000 to beyond)", "421  (310 to 633)", "exceeded since 1,912", "no trend"]
    assert written(right) == (2 * rights)[:count]
    percents = [each for each in written(left) if each not in COLOURS]
    lefts = ["12 %", "48 %", "104 %", "not known", "−10 %", "78 %", "100 %", "15 %"]
    assert percents == (2 * lefts)[:count]
    keys = [text.get_text() for text in figure.legends[0].get_texts()]
    there = [state for state in reversed(STATES) if state in data.state.values]
    assert [key.split(":")[0] for key in keys[:-1]] == there  # and no state that is not there


def test_verdict_draws_intervals_and_arrows_where_they_are():
    data = verdict_data(8)
    _, left, right = verdict(data).axes

    def segments(axis):
        return {
            part.get_segments()[0][0, 1]: part.get_segments()[0][:, 0].tolist()
            for part in axis.collections
        }

    assert segments(left) == {
        0: [5, 20],
        1: [35, 60],
        2: [90, 130],
        4: [-18, 5],
        5: [70, 84],
        6: [99, 101],
        7: [0, 30],
    }
    assert segments(right) == {1: [900, 1e5], 2: [1, 60], 4: [4000, 1e5], 5: [310, 633]}

    def marks(axis, kind):
        lines = [line for line in axis.lines if line.get_marker() == kind]
        return {line.get_ydata()[0]: line.get_xdata()[0] for line in lines}

    over = to_hex(COLOURS["now"])
    gone = [bar.get_width() for bar in left.patches if to_hex(bar.get_facecolor()) == over]
    assert gone[0] == 100  # and the strip past the limit
    assert marks(left, "o") == {0: 12, 1: 48, 2: 104, 4: -10, 5: 78, 6: 100, 7: 15}
    assert marks(right, "o") == {1: 2130, 4: 9000, 5: 421}
    assert (marks(left, "<"), marks(left, ">")) == ({4: -18}, {2: 130})
    assert (marks(right, "<"), marks(right, ">")) == ({2: 1}, {1: 1e5, 4: 1e5})


@pytest.mark.parametrize("state", ["unknown", "now"])
def test_nothing_known_and_all_exceeded_from_the_start(state):
    data = verdict_data(2)
    data["state"][:] = state
    data["way"][:], data["remaining"][:] = np.nan, 0.0 if state == "now" else np.nan
    data["since"][:] = 1.0 if state == "now" else np.nan
    figure = verdict(data)
    assert_nothing_overlaps(figure)
    told = "exceeded since 1" if state == "now" else "cannot be told"
    assert written(figure.axes[2]) == [told] * 2
    assert written(figure.axes[1])[::2] == ["not known"] * 2
    assert "healthy" not in words(figure)


def test_names_of_limits_are_no_mathematics():
    """In rows and sentences; an odd number of signs is not enough to see it."""
    data = verdict_data(1).assign_coords(limit=["5 $ or {6 $"])
    data.attrs |= {"headline": "Not healthy: 5 $ or {6 $ exceeded.", "left": "Left: 5 $ or {6 $."}
    figure = verdict(data)
    figure.canvas.draw()
    assert figure.get_suptitle() == r"Not healthy: 5 \$ or {6 \$ exceeded."


def test_long_sentences_are_broken_and_strange_states_refused():
    data = verdict_data(2)
    data.attrs |= {
        name: f"{data.attrs[name]} " * 3 for name in ("headline", "wearing", "left", "trust")
    }
    figure = verdict(data)
    assert_nothing_overlaps(figure)
    assert "\n" in figure.get_suptitle()
    box, below = figure.axes[0].texts[0].get_window_extent(), figure.axes[1].get_tightbbox()
    assert box.x1 < figure.bbox.width
    assert box.y0 > below.y1
    lines = figure.get_suptitle().splitlines() + figure.axes[0].texts[0].get_text().splitlines()
    assert len(lines) == 5
    assert lines[-1].endswith("…")
    data["state"][1] = "tired"
    with pytest.raises(ValueError, match="no state is called 'tired'"):
        verdict(data)
