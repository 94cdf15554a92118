"""Why a drive is where it is among those of a fleet, in words."""

from collections.abc import Sequence

from breaker.common.numerals import first_of, in_digits
from breaker.drive.family.untold import UNLIKE
from breaker.drive.fleet.drive_document import DriveChange, DriveDocument, FleetRow
from breaker.drive.fleet.fleet_states import DIFFERENT, UNJUDGED
from breaker.quantities.catalogue import QUANTITIES
from breaker.quantities.speeds import SPEED_UNIT

_TOLD = 3  # changes in a reason


def reason_of(row: FleetRow) -> str:
    """Return the reason, what is urgent first."""
    document = row.document
    said, due = [*document.differences], document.due
    if document.state == DIFFERENT:
        said += [f"{UNLIKE}, so no trend is told"]
    elif said:
        said += ["so no trend is told"]
    said += [f"exceeded: {row.failed}"] if row.failed else []
    if due.limit and not row.failed:
        on = f" by {due.date}" if due.date else ""
        many = "" if due.left is None else f", {due.left:.0f} operations left"
        said.append(f"{due.limit}{on}{many}")
    if document.changed:
        since = "since new" if document.how == "life" else _since_first(document)
        said.append(f"{since} {_changes(document.changed)}")
    if row.odd:
        said += _off_type(row)
        share = in_digits(100.0 * row.off, 2, sign=True)
        said.append(f"{row.odd} is {share} % off the median of {document.type or 'all drives'}")
    if document.state == UNJUDGED:
        said += _known(row)
    said += document.trust
    if document.rejected:
        said.append(f"{len(document.rejected)} records rejected")
    return "; ".join(said) or "nothing is due"


def _known(row: FleetRow) -> list[str]:
    """What is known of a drive without a limit: changes, spread, distance from its type."""
    document, said = row.document, []
    if document.since and not document.changed:
        said.append(f"{_since_first(document)}, within doubt, {_changes(document.since)}")
    if document.spread:
        most = max(document.spread, key=lambda each: each.value)
        percent = in_digits(most.value, 2)
        said.append(f"records of the last visit differ most in {most.label}, sd {percent} %")
    return said if row.odd else said + _off_type(row)


def _since_first(document: DriveDocument) -> str:
    return f"since the first visit {document.first[:10]}".rstrip()


def _off_type(row: FleetRow) -> list[str]:
    if row.shown is None:
        return []
    (name, motion, value, middle), zones = row.shown, row.document.zones
    unit = SPEED_UNIT if name in zones else QUANTITIES[name].unit
    values = f"{in_digits(value, 3)} {unit}, of its type {in_digits(middle, 3)}"
    about = ", ".join(filter(None, (motion, zones.get(name, ""))))
    return [f"measured {name} ({about}) {values}"]


def _changes(rows: Sequence[DriveChange]) -> str:
    """The largest changes, and how many more there are."""
    most = sorted(rows, key=lambda each: -abs(each.change[1]))
    words = [f"{each.label} {in_digits(each.change[1], 2, sign=True)} %" for each in most]
    return first_of(words, _TOLD)
