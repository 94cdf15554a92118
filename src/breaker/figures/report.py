"""Curves of a test report: a picture of each motion, with all channels."""

from collections.abc import Callable, Iterator, Mapping, Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from breaker.drive.answers.picture_data import Marked, Panel
from breaker.drive.answers.reference_curve import Overlay
from breaker.figures import style
from breaker.figures.overlay import difference

_CHANNELS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
# inches, hardly less than the text of an A4 page, so that no letter is printed smaller
_WIDTH = 7.0
_AROUND = 1.3  # inches, of title, time axis and legend
_NAME = 28  # letters of a channel's name
_KEYS_WIDE = 98  # letters in a line of the legend
_REFERENCE = {"color": style.PRIOR, "lw": 2.4}
_EVENTS = {"closing": "touch", "opening": "separation"}


def curves(panels: Sequence[Panel]) -> Iterator[Figure]:
    """Draw a picture of each motion; a channel has the same colour in all."""
    phases = dict.fromkeys(each.phase for panel in panels for each in panel.curves)
    colours = {phase: _CHANNELS[k % len(_CHANNELS)] for k, phase in enumerate(phases)}
    for each in panels:
        yield _picture(each, colours)


@style.styled
def _picture(panel: Panel, colours: Mapping[str, str]) -> Figure:
    """Draw travel with its marks; below it contacts and coils, and differences from a good record,
    where there are any.
    """
    drawn: dict[Callable, float] = {_travel: 2.1}  # heights, inches
    if any(each.beside for each in panel.curves):
        drawn[_beside] = 0.6
    if panel.overlays:
        drawn[_difference] = 0.9
    heights = [*drawn.values()]
    figure = style.new_figure(_WIDTH, sum(heights) + _AROUND)
    grid = figure.subplots(len(drawn), 1, sharex=True, height_ratios=heights, squeeze=False)
    for axis, draw in zip(grid[:, 0], drawn, strict=True):
        draw(axis, panel, colours)
        axis.margins(x=0)
    grid[-1, 0].set_xlabel("time of the record (ms)")
    keys = _keys(panel, colours)
    columns = max(1, _KEYS_WIDE // (max(len(each.get_label()) for each in keys) + 8))
    look = {"loc": "outside lower center", "fontsize": 9}
    figure.legend(handles=keys, ncols=min(columns, len(keys)), **look)
    return figure


def _travel(axis: Axes, panel: Panel, colours: Mapping[str, str]) -> None:
    for each in panel.overlays:
        _reference(axis, panel, each)
    for each in panel.curves:
        _marked(axis, each, colours[each.phase])
    axis.set_title(style.within(panel.title, _WIDTH, 10.0), loc="left", fontsize=10)
    axis.set_ylabel(style.TRAVEL)


def _reference(axis: Axes, panel: Panel, overlay: Overlay) -> None:
    """Draw the good record where the channel's own would be."""
    own = next(each for each in panel.curves if each.phase == overlay.phase)
    sign = 1.0 if panel.motion == "closing" else -1.0
    at, travel = overlay.time + own.moves[0], own.rests[0] + sign * overlay.good
    axis.plot(at, travel, zorder=1, **_REFERENCE)


def _marked(axis: Axes, data: Marked, colour: str) -> None:
    axis.plot(data.time, data.travel, color=colour, lw=1.1)
    look = {"color": colour, "ls": "", "zorder": 4}
    axis.plot(*data.moves, marker="v", ms=6, **look)
    axis.plot(*data.switching, marker="o", ms=5, mfc=colour if data.timed else "white", **look)
    if data.points:
        axis.plot(*zip(*data.points, strict=True), marker="s", ms=3, **look)
    for level in data.rests:
        axis.axhline(level, color=colour, lw=0.6, ls="--", zorder=1)


def _beside(axis: Axes, panel: Panel, colours: Mapping[str, str]) -> None:
    """Draw contacts, dashed, and coils, as shares of their ranges."""
    for each in panel.curves:
        for kind, share in each.beside.items():
            dashed = "--" if kind == "contact" else "-"
            axis.plot(each.time, share, color=colours[each.phase], lw=0.9, ls=dashed)
    axis.set(ylim=(-0.08, 1.08), yticks=(0.0, 1.0), ylabel="share")


def _difference(axis: Axes, panel: Panel, colours: Mapping[str, str]) -> None:
    """Draw differences from the good record, and say where they are too large."""
    begins = {each.phase: each.moves[0] for each in panel.curves}
    difference(axis, panel.overlays, colours, begins)
    left = [each for each in panel.overlays if each.leaves]
    first = min(left, key=lambda each: each.leaves[0]) if left else panel.overlays[0]
    name = f"{first.phase}: " if first.phase and left else ""
    look = {"color": style.WARNING if left else "black", "loc": "left", "fontsize": 9}
    axis.set_title(style.within(name + first.words, _WIDTH, 9.0), **look)


def _keys(panel: Panel, colours: Mapping[str, str]) -> list[Line2D]:
    """Return a key for each channel, and for each mark that is drawn."""
    channels, event = panel.curves, _EVENTS[panel.motion]
    names = {each.phase: style.shortened(each.phase or "record", _NAME) for each in channels}
    keys = [style.line_key(style.literal(of), colours[each]) for each, of in names.items()]
    keys.append(style.dot_key("first detected motion", marker="v"))
    if any(each.timed for each in channels):
        keys.append(style.dot_key(f"{event}, measured"))
    if not all(each.timed for each in channels):
        keys.append(style.dot_key(f"{event}, by the model", mfc="white"))
    if any(each.points for each in channels):
        keys.append(style.dot_key("points of speeds", marker="s", ms=3))
    keys.append(style.line_key("rest positions", ls="--", lw=0.6))
    if any("contact" in each.beside for each in channels):
        keys.append(style.line_key("contact (share of range)", ls="--", lw=0.9))
    if any("trigger" in each.beside for each in channels):
        keys.append(style.line_key("coil (share of range)", lw=0.9))
    if panel.overlays:
        keys.append(style.line_key("reference", **_REFERENCE))
    return keys
