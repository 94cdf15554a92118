"""A fleet in one table: every drive beside its type, ranked by what is due, with the reason."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
import pandas as pd
import xarray as xr

from breaker.common.numerals import first_of, in_digits
from breaker.common.text import bare, usual_spelling
from breaker.diagnosis.type_prior import DEVIATES, TypeDraws, TypeOfBreaker, learn_type
from breaker.diagnosis.words import say
from breaker.family.network_files import shipped_levels
from breaker.model.parameters import NAMES, PARAMETERS
from breaker.model.prior import Prior
from breaker.model.quantities import QUANTITIES, SPEED_UNIT
from breaker.prognosis.drive_document import (
    DIFFERENT,
    FLEET,
    FLEET_STATES,
    UNJUDGED,
    DriveChange,
    DriveDocument,
    Farthest,
    FleetRow,
    label,
)

_ENDS = (0.05, 0.5, 0.95)
# Times by which phases are compared, by rank: instants first, which a standard bounds.
_POLES = {"closing_time": 1, "opening_time": 1, "travel_time": 0}
_TOLD = 3  # changes in a reason
_ALIKE = 0.005  # share by which measured quantities of drives differ that count as alike


def learn_types(drives: xr.Dataset, usual: Prior) -> dict[str, tuple[np.ndarray, TypeOfBreaker]]:
    """Learn each type: by name, indices of its drives of which something was inferred, and the
    type.

    Args:
        drives: Chunks of ``stored``, one after the other.
        usual: Prior of drives of any type.
    """
    names = np.array([each.type for each in _documents(drives)])
    known, found = np.isfinite(drives["mean"].values).all(axis=1), {}
    for name in sorted({*names[known].tolist()}):
        where = np.flatnonzero(known & (names == name))
        parts = ("mean", "squares", "count", "theta")
        drawn = TypeDraws(*(drives[part].values[where].astype(float) for part in parts))
        found[name] = where, learn_type(drawn, usual.log_sds)
    return found


def _documents(drives: xr.Dataset) -> list[DriveDocument]:
    """Documents of drives, their types as most of them spell these: GL314 and GL 314 are one."""
    found = [DriveDocument.from_json(each) for each in drives.document.values]
    usual = usual_spelling(each.type for each in found)
    return [replace(each, type=usual[bare(each.type)]) for each in found]


def type_table(types: Mapping[str, tuple[np.ndarray, TypeOfBreaker]]) -> pd.DataFrame:
    """Return the prior of each type: one row for each parameter."""
    return pd.DataFrame(
        {
            "type": name,
            "drives": len(where),
            "parameter": each.name,
            "unit": each.unit,
            "median": learned.medians[k],
            "log_sd": learned.log_sds[k],
            "spread": learned.spread[k],
        }
        for name, (where, learned) in types.items()
        for k, each in enumerate(PARAMETERS)
    )


def fleet_table(
    drives: xr.Dataset, types: Mapping[str, tuple[np.ndarray, TypeOfBreaker]]
) -> pd.DataFrame:
    """Return the table of a fleet, with the columns ``FLEET``, the most urgent drive first.

    Args:
        drives: Chunks of ``stored``, one after the other.
        types: What ``learn_types`` returns.
    """
    documents = _documents(drives)
    rows = [FleetRow(document) for document in documents]
    families = {
        levels.settings["family"]: Prior.from_settings(levels.settings["prior"])
        for levels in shipped_levels()
    }
    for where, learned in types.values():
        for k, i in enumerate(where):
            theta = drives.theta.values[i].astype(float)
            weights = learned.weights(theta, families[documents[i].family])
            rows[i].parameters = _parameters(theta, weights)
            _judge(rows[i], learned.evidence[k], learned.off[k])
        _show([rows[i] for i in where])
    compare_poles(rows)
    for row in rows:
        row.reason = reason_of(row)
    table = pd.DataFrame([row.columns() for row in rows])
    table = table.reindex(columns=dict.fromkeys([*FLEET, *table.columns]))
    urgent = -table.state.map(FLEET_STATES.index)
    keys = {"u": urgent, "d": table.due_date.replace("", "9999"), "o": -table.evidence.fillna(0.0)}
    keys["c"] = -table.change.abs().fillna(0.0)
    by = ["u", "d", "o", "c", "breaker", "phase"]
    order = table.assign(**keys).sort_values(by, kind="stable")
    return order[table.columns].reset_index(drop=True)


def _parameters(theta: np.ndarray, weights: np.ndarray) -> dict[str, float]:
    """Median and 90 % interval of weighted draws ``(d, p)``."""
    found = {}
    for name, draws in zip(NAMES, theta.T, strict=True):
        order = np.argsort(draws)
        places = np.searchsorted(np.cumsum(weights[order]), _ENDS).clip(max=len(draws) - 1)
        low, middle, high = draws[order][places].tolist()
        found |= {name: middle, f"{name}_5": low, f"{name}_95": high}
    return found


def _judge(row: FleetRow, evidence: np.ndarray, off: np.ndarray) -> None:
    """Put down in which parameter a drive is unlike its type: the one with most evidence for it."""
    k = int(evidence.argmax())
    row.evidence = float(evidence[k]) if np.isfinite(evidence[k]) else np.nan
    if evidence[k] >= DEVIATES:
        row.odd, row.off = NAMES[k], float(off[k])


def _show(rows: Sequence[FleetRow]) -> None:
    """Put down of drives of a type which measured quantity is farthest off those of the others."""
    shown: dict[tuple, dict[int, float]] = {}
    for i, row in enumerate(rows):
        for name, motion, value in row.document.measured:
            shown.setdefault((name, motion), {})[i] = value
    off: dict[int, list] = {i: [] for i in range(len(rows))}
    for (name, motion), of in shown.items():
        values = np.array([*of.values()])
        middle = float(np.median(values))
        spread = np.median(np.abs(values - middle)) + _ALIKE * abs(middle) + 1e-9
        for i, value in of.items() if len(of) > 1 else ():
            off[i].append((abs(value - middle) / spread, Farthest(name, motion, value, middle)))
    for i, each in off.items():
        rows[i].shown = max(each)[1] if each else None


def compare_poles(rows: Sequence[FleetRow]) -> None:
    """Put down how far the phases of each breaker are apart, by instants if these are shown."""
    times: dict[str, dict[tuple, list[float]]] = {}
    for row in rows:
        of = times.setdefault(row.document.breaker, {})
        for name, motion, value in row.document.measured:
            if name in _POLES:
                of.setdefault((_POLES[name], name, motion), []).append(value)
    for row in rows:
        of = times[row.document.breaker].items()
        apart = [(rank, max(e) - min(e), name) for (rank, name, _), e in of if len(e) > 1]
        _, row.pole_spread, row.pole_spread_of = max(apart, default=(0, np.nan, ""))


def reason_of(row: FleetRow) -> str:
    """Return the reason, what is urgent first."""
    document = row.document
    said, due = [*document.differences], document.due
    if document.state == DIFFERENT:
        said += [f"{say('change-different-setup')}, so no trend is told"]
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
        where = label(most.name, most.motion)
        said.append(f"records of the last visit differ most in {where}, sd {percent} %")
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
    words = [
        f"{label(each.name, each.motion)} {in_digits(each.change[1], 2, sign=True)} %"
        for each in most
    ]
    return first_of(words, _TOLD)
