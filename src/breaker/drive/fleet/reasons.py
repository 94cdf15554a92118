"""Why a drive is where it is among those of a fleet, in words."""

from collections.abc import Mapping, Sequence

import numpy as np

from breaker.common.numerals import first_of, in_digits
from breaker.drive.family.untold import UNLIKE
from breaker.drive.fleet.drive_document import DriveChange, DriveDocument
from breaker.drive.fleet.fleet_states import DIFFERENT, UNJUDGED
from breaker.quantities.catalogue import QUANTITIES
from breaker.quantities.speeds import SPEED_UNIT

_TOLD = 3  # changes in a reason


def reason_of(row: Mapping, document: DriveDocument) -> str:
    """Return the reason, what is urgent first.

    Args:
        row: Of the table; ``shown``, where there is one, is name and motion of the quantity
            farthest off the type, its value and the median of the type.
        document: What is known of the drive.
    """
    said = [*document.differences]
    if document.state == DIFFERENT:
        said += [f"{UNLIKE}, so no trend is told"]
    elif said:
        said += ["so no trend is told"]
    said += [f"exceeded: {row['failed']}"] if row["failed"] else []
    if row["due"] and not row["failed"]:
        on = f" by {row['due_date']}" if row["due_date"] else ""
        left = row["operations_left"]
        many = f", {left:.0f} operations left" if np.isfinite(left) else ""
        said.append(f"{row['due']}{on}{many}")
    if document.changed:
        since = "since new" if document.how == "life" else _since_first(document)
        said.append(f"{since} {_changes(document.changed)}")
    if row["odd"]:
        said += _off_type(row, document.zones)
        share = in_digits(100.0 * row["off"], 2, sign=True)
        said.append(f"{row['odd']} is {share} % off the median of {row['type'] or 'all drives'}")
    if document.state == UNJUDGED:
        said += _known(row, document)
    said += document.trust
    if document.rejected:
        said.append(f"{len(document.rejected)} records rejected")
    return "; ".join(said) or "nothing is due"


def _known(row: Mapping, document: DriveDocument) -> list[str]:
    """What is known of a drive without a limit: changes, spread, distance from its type."""
    said = []
    if document.since and not document.changed:
        said.append(f"{_since_first(document)}, within doubt, {_changes(document.since)}")
    if document.spread:
        most = max(document.spread, key=lambda each: each.value)
        percent = in_digits(most.value, 2)
        said.append(f"records of the last visit differ most in {most.label}, sd {percent} %")
    return said if row["odd"] else said + _off_type(row, document.zones)


def _since_first(document: DriveDocument) -> str:
    return f"since the first visit {document.first[:10]}".rstrip()


def _off_type(row: Mapping, zones: Mapping[str, str]) -> list[str]:
    if not row.get("shown"):
        return []
    name, motion, value, middle = row["shown"]
    unit = SPEED_UNIT if name in zones else QUANTITIES[name].unit
    values = f"{in_digits(value, 3)} {unit}, of its type {in_digits(middle, 3)}"
    about = ", ".join(filter(None, (motion, zones.get(name, ""))))
    return [f"measured {name} ({about}) {values}"]


def _changes(rows: Sequence[DriveChange]) -> str:
    """The largest changes, and how many more there are."""
    most = sorted(rows, key=lambda each: -abs(each.change[1]))
    words = [f"{each.label} {in_digits(each.change[1], 2, sign=True)} %" for each in most]
    return first_of(words, _TOLD)
