"""Colours of phases, as engineers know them."""

from collections.abc import Iterable
from itertools import cycle

_OF_PHASES = {
    # red, amber, blue
    **dict.fromkeys(("R Y B", "R S T", "A B C"), ("#C62828", "#E39A00", "#1F5FBF")),
    **dict.fromkeys(("L1 L2 L3", "U V W"), ("#8B4A1C", "#000000", "#808080")),  # IEC 60445
}
_OTHERS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")


def phase_colours(names: Iterable[str]) -> dict[str, str]:
    """Return the colour of each phase: the usual one if all names are of one system, else any.

    >>> phase_colours(["L2", "L1"])
    {'L2': '#000000', 'L1': '#8B4A1C'}
    """
    names = [*dict.fromkeys(names)]
    for system, colours in _OF_PHASES.items():
        known = dict(zip(system.split(), colours, strict=True))
        if {name.upper() for name in names} <= known.keys():
            return {name: known[name.upper()] for name in names}
    return dict(zip(names, cycle(_OTHERS)))
