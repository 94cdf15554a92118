"""How a file was read, setting by setting, each with its reason; what is uncertain comes first."""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from breaker.app.page_choices import FIELDS, Field, as_text
from breaker.diagnosis.estimate import DriveRecord
from breaker.diagnosis.session import Diagnosis
from breaker.records.proposal import Proposal
from breaker.records.settings import FORMAT
from breaker.records.sheet import Sheet


class SettingRow(NamedTuple):
    """A setting as the page shows it.

    Attributes:
        field: What it is.
        text: Value, as the text of its field.
        used: What was used, in words.
        reason: Why.
        state: "lacking", "doubtful", "chosen" or "sure".
        options: Texts and words of a choice.
    """

    field: Field
    text: str
    used: str
    reason: str
    state: str
    options: Sequence[tuple[str, str]]


_ORDER = ("lacking", "doubtful", "chosen", "sure")
_BESIDE = ("contact_column", "current_column", "trigger_column", "motor_column")
_SEARCHED = {"travel_column": "the column that moves as a drive does"}
_SEARCHED |= dict.fromkeys(_BESIDE, "by name, number and time, beside each travel")


def base_of(config: Mapping, proposal: Proposal | None, wanted: str) -> tuple[dict[str, Any], str]:
    """Return all of ``endurance.format`` before anything is chosen on the page, and what it is:
    "configured" or "seen", as it was wanted; else a configuration of the user's own, or what is
    proposed of the file.
    """
    own = config["endurance"]["format"]
    if (wanted or ("seen" if own == FORMAT else "configured")) == "seen" and proposal is not None:
        return {**FORMAT, **proposal.settings, **dict.fromkeys(proposal.lacking)}, "seen"
    return {**FORMAT, **own}, "configured"


def rows_of(
    base: Mapping[str, Any],
    proposal: Proposal | None,
    layout: Sheet | None,
    chosen: Mapping[str, Any],
    read: Diagnosis | None,
) -> list[SettingRow]:
    """Return the settings that the page offers.

    Args:
        base: Settings before anything is chosen.
        proposal: Of the first file, if the page starts from it.
        layout: Of the first file; None where there is none.
        chosen: What was changed on the page.
        read: The visit as it was read; None if it cannot be.
    """
    rows = []
    for field in FIELDS:
        key = field.key
        value = chosen.get(key, None if key == "travel_column" else base[key])
        told = _told(key, read.records if read else ())
        reason, state = told[1:] if told else _reason(key, base, proposal)
        if key in chosen:
            reason, state = "you chose it here", "chosen"
        elif proposal and key in proposal.lacking and not told:
            reason, state = f"fill it in: {proposal.lacking[key]}", "lacking"
        shown, words = as_text(key, value), _options(field, layout, value)
        used = told[0] if told else dict(words).get(shown, field.none if value is None else shown)
        rows.append(SettingRow(field, shown, str(used), reason, state, words))
    return sorted(rows, key=lambda row: _ORDER.index(row.state))


def _told(key: str, records: Sequence[DriveRecord]) -> tuple[str, str, str] | None:
    """What files tell of a setting that nothing else does, how, and that it is sure."""
    values = dict.fromkeys(
        str(each.operation.settings[key]) for each in records if key in each.operation.settings
    )
    if not values:
        return None
    how = "stated by the file" if key == "rate" else "the column that goes with each travel"
    return ", ".join(values), f"{how}, or by its row of operations.csv", "sure"


def _reason(key: str, base: Mapping, proposal: Proposal | None) -> tuple[str, str]:
    """Why a setting is as it is, where nobody chose it and no file tells it alone."""
    default = "the default" if base[key] == FORMAT[key] else ""
    if proposal is None:
        return default or "of your configuration", "sure"
    if doubts := proposal.found.doubts.get(key):
        return "; ".join(doubts), "doubtful"
    if key == "sign" and not proposal.found.sure:
        return "guessed from the curve", "sure"
    if key in proposal.layout.settings:
        return f"seen in the lines of {proposal.layout.kind}", "sure"
    return _SEARCHED.get(key, default or "seen in the file"), "sure"


def _options(field: Field, layout: Sheet | None, value: object) -> list[tuple[str, str]]:
    """What may be chosen, the value as it is among it."""
    found = [(as_text(field.key, each), words) for each, words in field.options]
    if field.kind == "column":
        columns = [layout.column(i) for i in range(len(layout.columns))] if layout else []
        found = [(as_text(field.key, each), str(each)) for each in columns]
        found = [("null", field.none), *found] if field.none else found
    if found and as_text(field.key, value) not in dict(found):
        found.append((as_text(field.key, value), str(value)))
    return found
