"""Colours of phases: those that engineers know them by."""

from collections.abc import Iterable, Mapping
from itertools import cycle

_KNOWN = {
    **{"R": "#d62728", "Y": "#c79a00", "B": "#1f5fbf"},
    **{"S": "#c79a00", "T": "#1f5fbf", "A": "#d62728", "C": "#1f5fbf"},
    **{"L1": "#8a4b12", "L2": "#30363d", "L3": "#8a929b"},
    **{"U": "#8a4b12", "V": "#30363d", "W": "#8a929b"},
}
_OTHERS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")


def phase_colours(names: Iterable[str], own: Mapping[str, str]) -> dict[str, str]:
    """Return the colour of each phase: the user's own, that of a known system, or another.

    >>> phase_colours(["R", "pole 2"], {"R": "#ff0000"})
    {'R': '#ff0000', 'pole 2': '#0072B2'}
    """
    names = [*dict.fromkeys(names)]
    known = {**_KNOWN, **({"B": _KNOWN["Y"]} if "A" in names else {}), **own}
    others = cycle(_OTHERS)
    return {name: known.get(name) or next(others) for name in names}
