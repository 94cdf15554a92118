"""The life of a drive: its records, their trend, and forecasts of its limits."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
import pandas as pd
import xarray as xr

from breaker.family.networks import LEAST_AGREEMENT, agreement_of, shipped_networks
from breaker.model.limits import Limit
from breaker.model.parameters import NAMES
from breaker.model.quantities import CONDITIONS
from breaker.prognosis.forecast import QUANTILES, Future, Onward
from breaker.prognosis.readout import Readout
from breaker.prognosis.series import Series, events_of, series_of
from breaker.prognosis.trend import Change, Follower, Path

_READ = 500  # approximate number of operations with forecasts; the trend uses all


def follow(
    records: Mapping[str, xr.Dataset],
    limits: Sequence[Limit],
    settings: Mapping,
    *,
    events: Mapping,
    conditions: Mapping,
) -> xr.Dataset:
    """Follow the life of a drive, and forecast its limits.

    Args:
        records: Results of ``read_curves``, by motion.
        settings: Sections ``trend`` and ``endurance`` of the configuration, and ``seed``.
        events, conditions: Results of ``known_of``.

    Returns:
        Result of ``forecast_of``, with ``threshold``; over ``operation`` also ``breaker``,
        ``phase``, ``date``, from the first motion that states it, ``event`` and ``CONDITIONS``,
        empty or nan if not stated, and ``not_used``, motions without a usable record.

    Raises:
        ValueError: As ``series_of``, and if an event is not defined.
    """
    trend, endurance = settings["trend"], settings["endurance"]
    read = [limit for limit in limits if limit.of == "record"]
    followed = dict.fromkeys((limit.motion, name) for limit in read for name in limit.quantities)
    done = events_of(events, endurance["events"])
    series = series_of(records, followed, done, conditions)
    options = {"seed": settings["seed"], "misfit_p_value": endurance["misfit_p_value"]}
    readout = Readout.of(series, shipped_networks(), draws=trend["draws"], **options)
    path = Follower(series, readout.coordinates.blocks(series), trend["threshold"]).path()
    life = forecast_of(readout, path, limits, Future(trend["horizon"]))
    numbers = series.operations
    stated = {"event": [events.get(number, "") for number in numbers.tolist()]}
    for name in ("breaker", "phase", "date"):
        stating = [data[name].to_series() for data in records.values() if name in data]
        known = pd.concat([pd.Series(dtype=str), *stating]).loc[lambda texts: texts != ""]
        known = known[~known.index.duplicated()]
        stated[name] = known.reindex(numbers, fill_value="").to_numpy(dtype=str)
    for name in CONDITIONS:
        known = pd.Series(conditions.get(name, {}), dtype=float)
        stated[name] = known.reindex(numbers).values
    used = {m: np.isin(numbers, data.operation[data.accepted == 1]) for m, data in records.items()}
    lacking = pd.DataFrame(used).apply(lambda row: ", ".join(row.index[~row]), axis=1)
    stated["not_used"] = lacking.to_numpy(dtype=str)
    life = life.assign({name: ("operation", values) for name, values in stated.items()})
    return life.assign_attrs(threshold=trend["threshold"])


def forecast_of(
    readout: Readout, path: Path, limits: Sequence[Limit], future: Future
) -> xr.Dataset:
    """Read out the path of a drive's coordinates, and forecast its limits, one or more.

    Returns:
        Dataset over ``operation``: ``evidence`` for a change (nats) and ``weight`` of the record;
        over ``asked``, operations with forecasts: ``changed (asked, parameter, quantile)``, percent
        since new, ``unchanged (asked, parameter)``, the probability of no change, ``turns (asked,
        draw)``, as of ``Future``, ``noticed_in``, operations until a change is detected, and the
        results of ``Onward.forecast``; over ``change``, fields of ``Change``, its evidence as
        ``certainty``; over ``motion``, ``p_value`` of the family. Attributes: ``family``, empty
        outside all families, ``agreement`` of the motions, 1 for a single one, ``reported_from``,
        the first operation at which a trend is reported, later than the last operation if there
        are fewer than ``needed``, and ``horizon``.
    """
    series, number = readout.series, readout.series.operations
    agreed = _agreement(readout, path)
    if agreed < LEAST_AGREEMENT:
        readout = replace(readout, network=None, theta=None)
    where = _read_at(series, path)
    needed = int(series.new[-1]) + series.settle + 1
    first = number[needed - 1] if needed <= len(number) else number[-1] + 1
    past = np.maximum(number[where] - float(number[0]), 1.0)
    onward = Onward(path, readout, where, past, future)
    forecasts = [onward.forecast(limit) for limit in limits]
    columns = {
        name: (dims, np.concatenate([values[name][1] for values in forecasts]))
        for name, (dims, _) in forecasts[0].items()
    }
    named = [name for name in columns if name in ("words", "of") or name.startswith("part_")]
    columns["p_nearer"][1][:, number[where] < first] = np.nan
    draws = onward.now.parameters
    changed = np.quantile(draws, QUANTILES, axis=1)
    unchanged = np.where(np.isfinite(draws[:, 0]), (draws == 0.0).mean(axis=1), np.nan)
    columns |= {
        "evidence": ("operation", path.evidence),
        "weight": ("operation", path.weight),
        "p_value": ("motion", [match.p_value for match in readout.matches.values()]),
        "changed": (("quantile", "asked", "parameter"), changed, {"unit": "%"}),
        "unchanged": (("asked", "parameter"), unchanged),
        "turns": (("asked", "draw"), onward.turns.astype(np.float32)),
        "noticed_in": ("asked", future.noticed * past),
    }
    coords = {"operation": number, "asked": number[where], "parameter": list(NAMES)}
    coords |= {"motion": list(readout.matches), "quantile": list(QUANTILES)}
    attrs = {"family": readout.network.settings["family"] if readout.network else ""}
    attrs |= {"agreement": agreed, "needed": needed}
    attrs |= {"reported_from": int(first), "horizon": future.horizon}
    life = xr.Dataset(columns | _changes(number, path), coords, attrs).set_coords(named)
    return life.transpose("asked", "limit", "part", "parameter", ...)


def _read_at(series: Series, path: Path) -> np.ndarray:
    """Return indices of the operations with forecasts; of each inspection only the last one."""
    known = np.flatnonzero(np.isfinite(path.change).all(axis=1))
    if series.inspections is not None:
        ends = np.append(np.diff(series.inspections) > 0, True)
        known = known[ends[known]]
    every = max(1, -(-known.size // _READ))
    return np.append(known[:-1:every], known[-1:])


def _agreement(readout: Readout, path: Path) -> float:
    """Return the least p-value of the agreement of motions on the last change; 1 if unknown."""
    motions, last = list(readout.coordinates.curves), slice(-1, None)
    if len(motions) < 2:
        return 1.0
    end = readout.at(path.change[last], path.variance[last])
    ends = [end.drawn([motion])[0] for motion in motions]
    return float(agreement_of(*ends).min()) if np.isfinite(ends).all() else 1.0


def _changes(number: np.ndarray, path: Path) -> dict[str, tuple]:
    """Return the changes of a path over ``change``, with numbers of operations."""
    changes = pd.DataFrame(path.changes, columns=Change._fields)
    moments = {name: changes[name].to_numpy(dtype=int) for name in Change._fields[:4]}
    numbers = {name: number[places].astype(int) for name, places in moments.items()}
    numbers["kind"] = changes.kind.to_numpy(dtype=str)
    numbers["certainty"] = changes.evidence.to_numpy(dtype=float)
    numbers["maintenance"] = changes.maintenance.to_numpy(dtype=bool)
    return {name: ("change", values) for name, values in numbers.items()}
