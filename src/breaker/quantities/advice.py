"""Where to look first if a quantity has become worse: words of the configuration, no diagnosis."""

from collections.abc import Iterable, Mapping

from breaker.quantities.parameters import MOTIONS

LOOK = "Where to look first (no diagnosis)"
"""What stands before such words."""


def advice_on(names: Iterable[str], advice: Mapping[str, str]) -> list[str]:
    """Say where to look first for quantities, parameters or mechanisms, the same words once.

    Args:
        names: Of what has become worse. A speed that has no entry has that of its motion.

    Example:
        >>> advice_on(["f", "mu", "closing_speed_10_90"], {"f": "spring", "closing_speed": "latch"})
        ['f: spring', 'closing_speed_10_90: latch']
    """
    found: dict[str, dict[str, None]] = {}
    for name in names:
        motion = name.partition("_speed_")[0]
        key = f"{motion}_speed" if name not in advice and motion in MOTIONS else name
        if words := advice.get(key):
            found.setdefault(words, {})[name] = None
    return [f"{', '.join(these)}: {words}" for words, these in found.items()]
