"""What tests of figures read from a drawn figure: words, lines, boxes, overlaps, colours."""

from itertools import combinations

import numpy as np
from matplotlib.colors import to_hex, to_rgb


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


def boxes(axis, colour):
    """From where to where the spans of a colour reach."""
    found = [each for each in axis.patches if to_hex(each.get_facecolor()).upper() == colour]
    return [(box.x0, box.x1) for box in (each.get_bbox() for each in found)]


def segments(axis, colour):
    """Ends of the horizontal or vertical lines of a colour, one array ``(n, 2, 2)`` per call."""
    parts = [part for part in axis.collections if hasattr(part, "get_segments")]
    return [
        np.array(part.get_segments())
        for part in parts
        if to_hex(part.get_color()[0]).upper() == colour
    ]


def bands(axis):
    """Lowest and highest value of each filled band, in the order of drawing."""
    filled = [part for part in axis.collections if not hasattr(part, "get_segments")]
    return [part.get_datalim(axis.transData).intervaly for part in filled]


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


# Machado, Oliveira & Fernandes 2009, severity 1.0: what a deficient eye sees, in linear RGB.
SIGHT = {
    "normal": np.eye(3),
    "protanopia": [
        [0.152286, 1.052583, -0.204868],
        [0.114503, 0.786281, 0.099216],
        [-0.003882, -0.048116, 1.051998],
    ],
    "deuteranopia": [
        [0.367322, 0.860646, -0.227968],
        [0.280085, 0.672501, 0.047413],
        [-0.011820, 0.042940, 0.968881],
    ],
    "tritanopia": [
        [1.255528, -0.076749, -0.178779],
        [-0.078411, 0.930809, 0.147602],
        [0.004733, 0.691367, 0.303900],
    ],
}


def lab(colour, sight):
    """CIELAB of a colour as it is seen, from sRGB with white point D65."""
    rgb = np.array(to_rgb(colour))
    linear = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    seen = np.clip(np.asarray(sight) @ linear, 0.0, 1.0)
    to_xyz = [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]]
    x, y, z = np.cbrt(np.maximum(to_xyz @ seen / [0.9505, 1.0, 1.089], 1e-9))
    return np.array([116 * y - 16, 500 * (x - y), 200 * (y - z)])
