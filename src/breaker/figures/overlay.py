"""What records differ by from good ones, with the band that they may."""

from collections.abc import Sequence

from matplotlib.axes import Axes

from breaker.answers import Overlay
from breaker.figures import style

__all__ = ["difference"]


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
