"""A record of unknown origin as it was inspected: motions, rests, speed, noise and doubts."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from breaker.common.numerals import in_digits
from breaker.figures import style
from breaker.reading.inspection.bends import seen_touch, speed_along
from breaker.reading.inspection.setting_proposal import InspectedMotion, Proposal

_MOTIONS = {"closing": "#2166AC", "opening": "#D98C21"}
_REST = (50.0, 1.0)  # ms before the first motion, of which the noise is shown
_WIDTH = 11.0  # inches
_MOST = 2  # first motions that are shown


@style.styled
def record(proposal: Proposal) -> Figure:
    """Draw the record of a proposal.

    Above all channels over the whole record, below the speed; at the foot the first motions and
    the rest before them, of the first channel. What could not be read is drawn as it stands in the
    file.
    """
    read = [each for each in proposal.motions if each.record]
    if not read:
        return _raw(proposal)
    first = [each for each in read if each.column == read[0].column]
    shown = first[:_MOST]
    figure = style.new_figure(_WIDTH, 9.0)
    grid = figure.add_gridspec(3, len(shown) + 1, height_ratios=[1.5, 0.9, 1.1])
    whole = figure.add_subplot(grid[0, :])
    speed = figure.add_subplot(grid[1, :], sharex=whole)
    _whole(whole, read, first)
    _speed(speed, first)
    whole.tick_params(labelbottom=False)
    for k, each in enumerate(shown):
        _start(figure.add_subplot(grid[2, k]), each)
    _noise(figure.add_subplot(grid[2, -1]), shown[0])
    masked = any((each.record.doubts != "").any() for each in read)
    touch = _touch(first) is not None
    style.title(figure, style.literal(f"Record of {proposal.layout.file.name}"))
    style.legend_below(figure, _keys(first, masked, touch))
    return figure


def _raw(proposal: Proposal) -> Figure:
    """The columns of travel as they are, where no motion could be read."""
    travel, layout = proposal.travels[0], proposal.layout
    figure = style.new_figure(_WIDTH, 4.0)
    axis = figure.subplots()
    for each in proposal.travels:
        axis.plot(layout.columns[each.place], color=style.MEASURED, lw=0.8)
    axis.set(
        xlabel="sample",
        ylabel=style.literal(f"{layout.column(travel.place)} ({travel.unit or 'no unit'})"),
    )
    axis.margins(x=0)
    words = f"Record of {proposal.layout.file.name}: no motion could be read"
    style.title(figure, style.literal(words), color=style.WARNING)
    return figure


def _whole(axis: Axes, read: Sequence[InspectedMotion], first: Sequence[InspectedMotion]) -> None:
    """All channels over the whole record; motions and rest positions of the first one."""
    channels = {each.column: each.record for each in read}
    for channel, one in channels.items():
        main = channel == first[0].column
        look = {"color": style.MEASURED, "lw": 1.4} if main else {"color": style.PRIOR, "lw": 0.7}
        axis.plot(one.time, one.sure, zorder=3 if main else 2, **look)
    for each in first:
        one, colour = each.record, _MOTIONS[each.motion]
        axis.axvspan(one.moves, each.arrives, color=colour, alpha=0.15, lw=0)
        axis.axvline(one.moves, color=colour, lw=1.2)
        begin, end = one.time[one.segment.begin], one.time[one.segment.end - 1]
        axis.hlines([one.segment.before], begin, one.moves, color=colour, ls="--", lw=1.2, zorder=4)
        axis.hlines([one.segment.after], each.arrives, end, color=colour, ls="--", lw=1.2, zorder=4)
        doubtful = one.doubts != ""
        inside = np.clip(one.whole[doubtful], *axis.get_ylim())
        axis.plot(one.time[doubtful], inside, "x", color=style.WARNING, ms=6, zorder=5)
    axis.set_ylabel(style.TRAVEL)
    axis.set_xlim(first[0].record.time[[0, -1]])
    others = f", {len(channels) - 1} other channels in grey" if len(channels) > 1 else ""
    axis.set_title(style.within(f"{first[0].column}{others}", _WIDTH), loc="left")


def _speed(axis: Axes, first: Sequence[InspectedMotion]) -> None:
    one = first[0].record
    duration = min(each.arrives - each.begins for each in first)
    axis.plot(one.time, speed_along(one.time, one.sure, duration), color=style.MEASURED, lw=1.0)
    for each in first:
        axis.axvspan(each.record.moves, each.arrives, color=_MOTIONS[each.motion], alpha=0.15, lw=0)
        axis.axvline(each.record.moves, color=_MOTIONS[each.motion], lw=1.2)
    if (touch := _touch(first)) is not None:
        axis.axvline(touch, color=style.REFERENCE, lw=1.0, ls=":")
    axis.set(xlabel="time of the record (ms)", ylabel="speed (m/s)")


def _touch(first: Sequence[InspectedMotion]) -> float | None:
    """Time at which the first closing touches, ms, if it is seen."""
    for each in first:
        if each.motion == "closing":
            one = each.record
            part = slice(*np.searchsorted(one.time, [each.begins, each.arrives]))
            return seen_touch(one.time[part], one.sure[part])
    return None


def _start(axis: Axes, each: InspectedMotion) -> None:
    """A motion's beginning, samples one by one."""
    one, colour = each.record, _MOTIONS[each.motion]
    reach = max(4.0, 0.15 * (each.arrives - each.begins))
    near = np.abs(one.time - one.moves) <= reach
    fine = near & (one.doubts == "")
    axis.plot(one.time[fine], one.whole[fine], ".", color=style.MEASURED, ms=3)
    doubtful = near & ~fine
    axis.plot(one.time[doubtful], one.whole[doubtful], "x", color=style.WARNING, ms=6)
    axis.axvline(one.moves, color=colour, lw=1.2)
    axis.axhline(one.segment.before, color=colour, ls="--", lw=1.2)
    axis.set(xlabel="time of the record (ms)", ylabel=style.TRAVEL)
    axis.set_title(f"{each.motion} begins at {one.moves:.1f} ms", loc="left")


def _noise(axis: Axes, each: InspectedMotion) -> None:
    """The rest before a motion, and the standard deviation of its noise."""
    one = each.record
    before = (one.time >= one.moves - _REST[0]) & (one.time <= one.moves - _REST[1])
    rest = (before & (one.doubts == "")).nonzero()[0]
    low, high = one.segment.before - one.noise.sd, one.segment.before + one.noise.sd
    axis.axhspan(low, high, color=style.PRIOR, alpha=0.3, lw=0)
    axis.plot(one.time[rest], one.whole[rest], ".", color=style.MEASURED, ms=3)
    axis.set(xlabel="time of the record (ms)", ylabel=style.TRAVEL)
    said = [f"steps of {in_digits(one.quantum, 2)} mm"] if one.quantum else []
    said += [f"correlation {one.noise.colour:.2f}"] if np.isfinite(one.noise.colour) else []
    axis.set_title(
        "\n".join([f"at rest: sd {in_digits(one.noise.sd, 2)} mm", ", ".join(said)]), loc="left"
    )


def _keys(first: Sequence[InspectedMotion], masked: bool, touch: bool) -> list:
    motions = dict.fromkeys(each.motion for each in first)
    return [
        *(style.band_key(f"{each}, to its rest", _MOTIONS[each], 0.15) for each in motions),
        style.line_key("first motion", lw=1.2),
        style.line_key("rest position", ls="--", lw=1.2),
        touch and style.line_key("bend of the speed, near the touch", ls=":"),
        masked and style.dot_key("doubtful sample", style.WARNING, "x"),
    ]
