"""A fleet in one table: every drive beside its type, ranked by what is due, with the reason."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
import pandas as pd
import xarray as xr

from breaker.drive.answers.type_model import TypeDraws, TypeOfBreaker, learn_type
from breaker.drive.family.network_files import shipped_levels
from breaker.drive.fleet.drive_document import DriveDocument, Farthest, FleetRow
from breaker.drive.fleet.fleet_columns import FLEET
from breaker.drive.fleet.fleet_states import FLEET_STATES
from breaker.drive.fleet.reasons import reason_of
from breaker.mechanism.prior import Prior
from breaker.quantities.parameters import NAMES, PARAMETERS
from breaker.reading.files.word_meanings import bare, usual_spelling

_ENDS = (0.05, 0.5, 0.95)
# Times by which phases are compared, by rank: instants first, which a standard bounds.
_POLES = {"closing_time": 1, "opening_time": 1, "travel_time": 0}
_ALIKE = 0.005  # share by which measured quantities of drives differ that count as alike


def learn_types(drives: xr.Dataset, usual: Prior) -> dict[str, tuple[np.ndarray, TypeOfBreaker]]:
    """Learn each type.

    Args:
        drives: Chunks of ``stored``, one after the other.
        usual: Prior of drives of any type.

    Returns:
        By name, indices of its drives of which something was inferred, and the type.
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
    drives: xr.Dataset, types: Mapping[str, tuple[np.ndarray, TypeOfBreaker]], least: float
) -> pd.DataFrame:
    """Return the table of a fleet, with the columns ``FLEET``, the most urgent drive first.

    Args:
        drives: Chunks of ``stored``, one after the other.
        types: What ``learn_types`` returns.
        least: Evidence from which a drive is odd, nats.
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
            _judge(rows[i], learned.evidence[k], learned.off[k], least)
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


def _judge(row: FleetRow, evidence: np.ndarray, off: np.ndarray, least: float) -> None:
    """Put down in which parameter a drive is unlike its type: the one with most evidence for it."""
    k = int(evidence.argmax())
    row.evidence = float(evidence[k]) if np.isfinite(evidence[k]) else np.nan
    if evidence[k] >= least:
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
