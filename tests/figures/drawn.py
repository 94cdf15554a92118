"""What tests of figures read from a drawn figure: words, lines and colours."""

from itertools import combinations


def assert_drawn(figure):
    """Every text can be laid out, with its mathematics, and no panel is empty."""
    figure.canvas.draw()
    for axis in figure.axes:
        assert axis.has_data() or axis.texts or not axis.axison


def words(figure):
    """All texts of a figure that are not ticks."""
    texts = [text.get_text() for legend in figure.legends for text in legend.get_texts()]
    for axis in figure.axes:
        texts += [axis.get_title(loc) for loc in ("left", "center", "right")]
        texts += [axis.get_xlabel(), axis.get_ylabel()]
        if axis.get_legend() is not None:
            texts += [text.get_text() for text in axis.get_legend().get_texts()]
    return "\n".join([figure.get_suptitle(), *texts])


def written(axis):
    return [text.get_text() for text in axis.texts]


def line_of(axis, colour, marker=None):
    """The first line of a colour, and of a marker where one is given."""
    lines = [line for line in axis.lines if line.get_color() == colour]
    return next(line for line in lines if marker is None or line.get_marker() == marker)


def assert_nothing_overlaps(figure):
    """Panels with their labels, legend and title share no more than a line's width."""
    parts = {f"panel {i}": axis.get_tightbbox() for i, axis in enumerate(figure.axes)}
    parts |= {f"legend {i}": legend.get_window_extent() for i, legend in enumerate(figure.legends)}
    if figure.get_suptitle():
        parts["title"] = figure._suptitle.get_window_extent()
    page = figure.bbox.padded(3.0)
    off_page = [
        key
        for key, box in parts.items()
        if not (page.contains(box.x0, box.y0) and page.contains(box.x1, box.y1))
    ]
    assert not off_page, off_page
    overlaps = []
    for (a, first), (b, second) in combinations(parts.items(), 2):
        width = min(first.x1, second.x1) - max(first.x0, second.x0)
        height = min(first.y1, second.y1) - max(first.y0, second.y0)
        if width > 3.0 and height > 3.0:  # pixels, of 150 an inch
            overlaps.append((a, b, round(width), round(height)))
    assert not overlaps, overlaps
