"""States of a drive of a fleet: those of one that is followed, and where no limit is told.

A drive is *measured differently* where its visits are, or where its stroke has changed: stops of a
drive hold that to far less, so its transducer was mounted elsewhere, or a ratio changed. Of such a
drive no trend is told. It is *not judged* where nothing says how it stands to any limit, but its
records can be used; without any of these it is *unknown*.
"""

from collections.abc import Mapping, Sequence

from breaker.common.numerals import in_digits
from breaker.drive.life.limit_states import STATES

DIFFERENT = "measured differently"
UNJUDGED = "not judged"
FLEET_STATES = (STATES[0], STATES[1], UNJUDGED, DIFFERENT, *STATES[2:])
"""States of a drive of a fleet, the most urgent last."""

# Of a stroke: share that counts beside its uncertainty, of which it takes so many sds: by chance of
# one drive in a thousand.
_LITTLE, _SDS = 0.005, 3.3


def other_strokes(changes: Sequence[Mapping]) -> list[str]:
    """Say which strokes have changed beyond their uncertainty.

    Args:
        changes: Rows of a comparison, ``visit_comparison.compared``.

    Example:
        >>> row = {"name": "stroke", "kind": "measured", "motion": "closing", "before": 150.0}
        >>> other_strokes([row | {"today": 156.0, "sd": 0.6}])
        ['the stroke of the closing was 150 mm and is 156 mm']
        >>> other_strokes([row | {"today": 151.0, "sd": 0.6}])
        []
    """
    found = []
    for row in changes:
        if (row["name"], row["kind"]) != ("stroke", "measured"):
            continue
        first, second = row["before"], row["today"]
        if abs(second - first) > _SDS * row["sd"] + _LITTLE * first:
            was, now = (f"{in_digits(each, 4)} mm" for each in (first, second))
            found.append(f"the stroke of the {row['motion']} was {was} and is {now}")
    return found
