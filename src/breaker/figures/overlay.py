"""Records laid over a good record of the same motion: curves, and the difference with its band."""

from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from breaker.drive.answers.reference_curve import Overlay
from breaker.figures import style

_LABELS = 0.9  # inches, left of a panel
_PAGE = 3  # records beside each other


@style.styled
def overlay(overlays: Sequence[Overlay]) -> Figure:
    """Draw each record over its good one, aligned at the first motion."""
    columns = min(len(overlays), _PAGE)
    rows = -(-len(overlays) // columns)
    figure = style.new_figure(max(8.0, 5.0 * columns), 5.4 * rows + 0.8)
    heights = [2.0, 1.0] * rows
    grid = figure.subplots(2 * rows, columns, height_ratios=heights, squeeze=False)
    for k, each in enumerate(overlays):
        above, below = (
            grid[2 * (k // columns), k % columns],
            grid[2 * (k // columns) + 1, k % columns],
        )
        below.sharex(above)
        _curves(above, each, figure.get_figwidth() / columns - _LABELS)
        difference(below, [each], {each.phase: style.MEASURED}, {each.phase: 0.0})
        below.set_xlabel("time after the first motion (ms)")
    for spare in range(len(overlays), rows * columns):
        for row in (0, 1):
            grid[2 * (spare // columns) + row, spare % columns].remove()
    files = dict.fromkeys(style.file_name(each.good_file) for each in overlays)
    style.title(figure, style.literal(f"Over the reference {', '.join(files)}"))
    style.legend_below(figure, _keys())
    return figure


def _curves(axis: Axes, data: Overlay, width: float) -> None:
    axis.plot(data.time, data.good, color=style.PRIOR, lw=2.6)
    axis.plot(data.time, data.way, color=style.MEASURED, lw=1.2)
    axis.fill_between(data.time, data.good - data.band, data.good + data.band, **style.BAND)
    if data.leaves:
        axis.axvline(data.leaves[0], color=style.WARNING, lw=1.0)
    phase = f", {data.phase}" if data.phase else ""
    title = f"{data.motion}{phase} in {style.file_name(data.file)}: {data.words}"
    colour = style.WARNING if data.leaves else "black"
    axis.set_title(style.within(title, width), loc="left", color=colour, fontsize=10)
    axis.set_ylabel("way (mm)")
    axis.margins(x=0)


def difference(
    axis: Axes, overlays: Sequence[Overlay], colours: dict[str, str], begins: dict[str, float]
) -> None:
    """Draw differences, their band, and where they leave it.

    Args:
        colours, begins: By phase, the colour, and the time of the axis that is the first motion.
    """
    for each in overlays:
        begin = begins[each.phase]
        axis.plot(begin + each.time, each.difference, color=colours[each.phase], lw=1.0)
        if each.leaves:
            at, by = each.leaves
            axis.axvline(begin + at, color=style.WARNING, lw=1.0)
            axis.plot(begin + at, by, "o", color=style.WARNING, ms=5, zorder=5)
    band = max(each.band for each in overlays)
    axis.axhspan(-band, band, **style.BAND)
    axis.axhline(0.0, color=style.REFERENCE, lw=0.6)
    axis.margins(x=0)
    axis.set_ylabel("difference (mm)")


def _keys() -> list:
    return [
        style.line_key("record", style.MEASURED),
        style.line_key("reference", style.PRIOR, lw=2.6),
        style.band_key("tolerance", style.PRIOR, style.BAND["alpha"]),
        style.line_key("leaves the band", style.WARNING, lw=1.0, marker="o", ms=5),
    ]
