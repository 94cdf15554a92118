"""The life of a drive: its records, their trend, forecasts of its limits, and its state."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from pathlib import Path as File
from typing import Self

import numpy as np
import pandas as pd
import xarray as xr

from breaker.common.zarr_store import describe, open_store
from breaker.common.zarr_store import save as save_store
from breaker.family.networks import LEAST_AGREEMENT, agreement_of, shipped_networks
from breaker.model.limits import Limit
from breaker.model.parameters import NAMES
from breaker.model.quantities import CONDITIONS
from breaker.prognosis.forecast import QUANTILES, Future, Onward
from breaker.prognosis.readout import Readout
from breaker.prognosis.series import Series, events_of, series_of
from breaker.prognosis.states import states_of
from breaker.prognosis.trend import Change, Follower, Path

_READ = 500  # operations, about, at which a life is read; all are followed


class Life:
    """The records of a drive, and its state: the only class of the package that is updated.

    Args:
        limits: Limits on what the motions of the drive show.
        settings: Sections ``trend`` and ``endurance`` of the configuration, and ``seed``.
        events, conditions: What ``known_of`` returns.
    """

    def __init__(
        self, limits: Sequence[Limit], settings: Mapping, *, events: Mapping, conditions: Mapping
    ) -> None:
        self._limits, self._settings = limits, settings
        self._events, self._conditions = events, conditions
        self._records: dict[str, xr.Dataset] = {}

    def update(self, records: Mapping[str, xr.Dataset]) -> None:
        """Add records of operations: what ``read_curves`` returns, by motion.

        Raises:
            ValueError: If an operation has a record already.
        """
        for motion, new in records.items():
            known = [self._records[motion]] if motion in self._records else []
            every = xr.concat([*known, new], "operation") if known else new
            numbers = every.indexes["operation"]
            if (again := numbers[numbers.duplicated()]).size:
                raise ValueError(f"{motion} {again[0]:g} has a record already: leave it out")
            self._records[motion] = every
        for name in ("_readout", "trend", "forecast"):
            self.__dict__.pop(name, None)

    @cached_property
    def _readout(self) -> Readout:
        trend, endurance = self._settings["trend"], self._settings["endurance"]
        read = [limit for limit in self._limits if limit.of == "record"]
        followed = dict.fromkeys(
            (limit.motion, name) for limit in read for name in limit.quantities
        )
        events = events_of(self._events, endurance["events"])
        series = series_of(self._records, followed, events, self._conditions)
        about = {"seed": self._settings["seed"], "misfit_p_value": endurance["misfit_p_value"]}
        return Readout.of(series, shipped_networks(), draws=trend["draws"], **about)

    @cached_property
    def trend(self) -> Path:
        """Path of the drive's coordinates, with its changes.

        Raises:
            ValueError: As of ``series_of``, and if an event has no meaning.
        """
        blocks = self._readout.coordinates.blocks(self._readout.series)
        return Follower(self._readout.series, blocks, self._settings["trend"]["threshold"]).path()

    @cached_property
    def forecast(self) -> xr.Dataset:
        """What ``forecast_of`` returns, with ``threshold``; over ``operation`` also ``breaker``,
        ``phase``, ``date``, by the first motion that states it, ``event`` and ``CONDITIONS``, empty
        or nan where not stated, and ``not_used``, motions without a usable record.
        """
        trend, records = self._settings["trend"], self._records
        life = forecast_of(self._readout, self.trend, self._limits, Future(trend["horizon"]))
        numbers = life.operation.values
        stated = {"event": [self._events.get(number, "") for number in numbers.tolist()]}
        for name in ("breaker", "phase", "date"):
            some = [data[name].to_series() for data in records.values() if name in data]
            known = pd.concat([pd.Series(dtype=str), *some]).loc[lambda texts: texts != ""]
            known = known[~known.index.duplicated()]
            stated[name] = known.reindex(numbers, fill_value="").to_numpy(dtype=str)
        for name in CONDITIONS:
            known = pd.Series(self._conditions.get(name, {}), dtype=float)
            stated[name] = known.reindex(numbers).values
        used = {m: np.isin(numbers, e.operation[e.accepted == 1]) for m, e in records.items()}
        lacking = pd.DataFrame(used).apply(lambda row: ", ".join(row.index[~row]), axis=1)
        stated["not_used"] = lacking.to_numpy(dtype=str)
        life = life.assign({name: ("operation", values) for name, values in stated.items()})
        return life.assign_attrs(threshold=trend["threshold"])

    def state(self, planning: Mapping) -> xr.Dataset:
        """Return the states of the drive and of its limits: see ``states_of``."""
        return states_of(self.forecast, planning)

    def save(self, path: str | File, **parameters: object) -> None:
        """Save the forecast, with the parameters that it was made by."""
        save_store(describe(self.forecast, "life", **parameters), path)

    @classmethod
    def load(cls, path: str | File) -> Self:
        """Return a life whose forecast was saved; it has no records."""
        life = cls([], {}, events={}, conditions={})
        life.forecast = open_store(path).load()
        return life


def forecast_of(
    readout: Readout, path: Path, limits: Sequence[Limit], future: Future
) -> xr.Dataset:
    """Read the trend of a drive, the path of its coordinates, and forecast its limits, one or more.

    Returns:
        Dataset over ``operation``: ``evidence`` for a change (nats) and ``weight`` of the record;
        over ``asked``, operations at which the life was read: ``changed (asked, parameter,
        quantile)``, percent since new, ``unchanged (asked, parameter)``, the probability of no
        change, ``turns (asked, draw)``, as of ``Future``, ``noticed_in``, operations in which a
        change shows, and what ``Onward.forecast`` returns; over ``change``, fields of ``Change``,
        its evidence as ``certainty``; over ``motion``, ``p_value`` of the family. Attributes:
        ``family``, empty if it is of none, ``agreement`` of the motions, 1 of a single one,
        ``reported_from``, the first operation at which a trend is reported, later than the last one
        while there are fewer than ``needed`` of them, and ``horizon``.
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
        name: (dims, np.concatenate([forecast_[name][1] for forecast_ in forecasts]))
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
    """Indices of the operations at which a life is read: of each inspection the last one."""
    known = np.flatnonzero(np.isfinite(path.change).all(axis=1))
    if series.inspections is not None:
        ends = np.append(np.diff(series.inspections) > 0, True)
        known = known[ends[known]]
    every = max(1, -(-known.size // _READ))
    return np.append(known[:-1:every], known[-1:])


def _agreement(readout: Readout, path: Path) -> float:
    """Return how probably motions disagree as much on the change at the end; 1 without a doubt."""
    motions, last = list(readout.coordinates.curves), slice(-1, None)
    if len(motions) < 2:
        return 1.0
    end = readout.at(path.change[last], path.variance[last])
    ends = [end.drawn([motion])[0] for motion in motions]
    return float(agreement_of(*ends).min()) if np.isfinite(ends).all() else 1.0


def _changes(number: np.ndarray, path: Path) -> dict[str, tuple]:
    """Changes of a path over ``change``, by the numbers of the operations."""
    changes = pd.DataFrame(path.changes, columns=Change._fields)
    moments = {name: changes[name].to_numpy(dtype=int) for name in Change._fields[:4]}
    numbers = {name: number[places].astype(int) for name, places in moments.items()}
    numbers["kind"] = changes.kind.to_numpy(dtype=str)
    numbers["certainty"] = changes.evidence.to_numpy(dtype=float)
    numbers["maintenance"] = changes.maintenance.to_numpy(dtype=bool)
    return {name: ("change", values) for name, values in numbers.items()}
