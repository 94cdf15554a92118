"""What tests of figures read from a drawn figure: all that is in it, overlaps, colours.

Of figures that somebody has looked at, ``drawn.json`` has a checksum for each panel. After a change
that is meant, look at the figures and write it anew: ``BREAKER_RENEW=1 python -m pytest
tests/figures``.
"""

import json
import os
from itertools import combinations, zip_longest
from pathlib import Path
from zlib import crc32

import numpy as np
from matplotlib.colors import to_hex, to_rgb

KEPT = Path(__file__).with_name("drawn.json")
_OFF = 1.0 + 1e-9


def numbers(values):
    """Numbers of any shape in five digits: few as they are, of many how many and some sums."""
    # A little off what is written, so that no tie is rounded by the order of a processor's sums.
    flat = np.ravel(np.asarray(np.ma.filled(values, np.nan), dtype=float)) * _OFF
    largest = np.max(np.abs(flat), initial=1e-9, where=np.isfinite(flat))
    flat = np.round(flat, 5 - int(np.ceil(np.log10(largest))))  # a zero is one on any processor
    if flat.size > 12:
        there = np.where(np.isfinite(flat), flat, 0.0)
        places = np.linspace(0.0, 1.0, flat.size)
        sums = [np.isfinite(flat).sum(), there.sum(), there @ places, there @ np.sin(9 * places)]
        flat = np.concatenate([flat[:2], flat[-2:], sums])
    return " ".join(f"{_OFF * each:.5g}" for each in flat + 0.0)


def parts(axis):
    """A line of text for each thing that is drawn in a panel."""
    yield from (f"title: {axis.get_title(loc)!r}" for loc in ("left", "center", "right"))
    yield f"title is {to_hex(axis.title.get_color())}"
    for name in "xy":
        ticks = [tick.get_text() for tick in getattr(axis, f"get_{name}ticklabels")()]
        yield f"{name}: {getattr(axis, f'get_{name}label')()!r} {ticks}"
        scale, limits = (getattr(axis, f"get_{name}{of}")() for of in ("scale", "lim"))
        yield f"{name}: {scale} {numbers(limits)}"
    for text in axis.texts:
        yield f"text: {text.get_text()!r} {to_hex(text.get_color())} {numbers(text.get_position())}"
    for line in axis.lines:
        look = line.get_marker(), line.get_linestyle(), line.get_drawstyle()
        x, y = (numbers(each) for each in line.get_data())
        yield f"line: {to_hex(line.get_color())} {look} x {x} y {y}"
    for patch in axis.patches:
        yield f"box: {to_hex(patch.get_facecolor())} {numbers(patch.get_bbox().extents)}"
    for part in axis.collections:
        colours = {to_hex(each) for each in [*part.get_facecolor(), *part.get_edgecolor()][:9]}
        places = [part.get_offsets(), *(path.vertices for path in part.get_paths())]
        found = np.concatenate([np.reshape(each, (-1, 2)) for each in places])
        yield f"{type(part).__name__}: {sorted(colours)} {numbers(found)}"
    yield from (f"image: {each.get_array().shape}" for each in axis.images)
    if axis.get_legend() is not None:
        yield f"legend: {[text.get_text() for text in axis.get_legend().get_texts()]}"


def around(figure):
    """A line of text for each thing that is drawn beside the panels."""
    yield f"title: {figure.get_suptitle()!r}"
    if figure.get_suptitle():
        yield f"title is {to_hex(figure._suptitle.get_color())}"
    for legend in figure.legends:
        texts = [text.get_text() for text in legend.get_texts()]
        yield f"legend: {legend.get_title().get_text()!r} {texts}"
    yield from (f"text: {text.get_text()!r}" for text in figure.texts)


def assert_drawn(figure, name):
    """It is drawn as it was when somebody looked at it, and nothing overlaps."""
    figure.canvas.draw()  # ticks are known from here on
    found = ["\n".join(each) for each in (around(figure), *map(parts, figure.axes))]
    sums = [f"{crc32(each.encode()):08x}" for each in found]
    kept = json.loads(KEPT.read_text(encoding="utf-8")) if KEPT.exists() else {}
    if os.environ.get("BREAKER_RENEW"):
        kept[name] = sums
        lines = [f"{json.dumps(of)}: {json.dumps(each)}" for of, each in sorted(kept.items())]
        KEPT.write_text("{\n" + ",\n".join(lines) + "\n}\n", encoding="utf-8")
    pairs = zip_longest(found, sums, kept[name])
    other = [text for text, one, before in pairs if one != before]
    assert not other, f"{name} is drawn in another way (see tests/figures/drawn.py): {other}"
    assert_nothing_overlaps(figure)


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
