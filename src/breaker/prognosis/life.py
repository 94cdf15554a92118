"""The life of a drive: its records, their trend, forecasts of its limits, and its state."""

from collections.abc import Mapping, Sequence
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
from breaker.prognosis.forecast import FORECAST, QUANTILES, Future, Onward
from breaker.prognosis.readout import Condition, Readout
from breaker.prognosis.series import Series, events_of, series_of
from breaker.prognosis.states import states_of
from breaker.prognosis.trend import Change, Follower, Path
from breaker.shipped import KINDS

_READ = 500  # operations, about, at which a life is read; all are followed


class Life:
    """The records of a drive, and its state: the only class of the package that is updated.

    >>> life = Life(limits, config, events={}, conditions={})  # doctest: +SKIP
    >>> life.update({"closing": read_curves(operations, form, grid, "closing")})  # doctest: +SKIP
    >>> life.state(config["planning"])  # doctest: +SKIP

    Args:
        limits: Limits on what the motions of the drive show.
        settings: Sections ``trend`` and ``endurance`` of the configuration, and ``seed``.
        events, conditions: What ``known_of`` returns.
    """

    def __init__(
        self,
        limits: Sequence[Limit],
        settings: Mapping,
        *,
        events: Mapping[int, str],
        conditions: Mapping[str, Mapping[int, float]],
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
            known = self._records[motion].operation if motion in self._records else []
            if (again := np.intersect1d(known, new.operation)).size:
                raise ValueError(f"{motion} {again[0]:g} has a record already: leave it out")
            some = [self._records[motion]] if motion in self._records else []
            self._records[motion] = xr.concat([*some, new], "operation") if some else new
        for name in ("_readout", "trend", "forecast"):
            self.__dict__.pop(name, None)

    @cached_property
    def _readout(self) -> Readout:
        names: dict[str, list[str]] = {motion: [] for motion in self._records}
        for limit in self._limits:
            if limit.of == "record":
                names[limit.motion] += limit.quantities
        settings = self._settings
        series = series_of(
            self._records,
            followed={motion: list(dict.fromkeys(some)) for motion, some in names.items()},
            events=events_of(self._events, settings["endurance"]["events"]),
            conditions=self._conditions,
        )
        return Readout.of(
            series,
            list(shipped_networks(*KINDS)),
            draws=settings["trend"]["draws"],
            seed=settings["seed"],
            misfit_p_value=settings["endurance"]["misfit_p_value"],
        )

    @cached_property
    def trend(self) -> Path:
        """Path of the drive's coordinates, with its changes.

        Raises:
            ValueError: As of ``series_of``, and if an event has no meaning.
        """
        return trend_of(self._readout, self._settings["trend"]["threshold"])

    @cached_property
    def forecast(self) -> xr.Dataset:
        """What ``forecast_of`` returns; also over ``operation`` what is stated of it, texts that
        are empty and numbers that are nan where nothing is: ``breaker``, ``phase``, ``date`` of the
        first motion that states it, ``event``, ``CONDITIONS``, and ``not_used``, motions without a
        usable record.
        """
        trend = self._settings["trend"]
        future = Future(trend["horizon"])
        life = forecast_of(self._readout, self.trend, self._limits, future, trend["threshold"])
        records, numbers = self._records, life.operation.values
        stated = {name: _stated(name, records, numbers) for name in ("breaker", "phase", "date")}
        stated["event"] = np.array([self._events.get(number, "") for number in numbers.tolist()])
        for name in CONDITIONS:
            known = pd.Series(self._conditions.get(name, {}), dtype=float)
            stated[name] = known.reindex(numbers).values
        used = {m: np.isin(numbers, e.operation[e.accepted == 1]) for m, e in records.items()}
        lacking = pd.DataFrame(used).apply(lambda row: ", ".join(row.index[~row]), axis=1)
        stated["not_used"] = lacking.to_numpy(dtype=str)
        return life.assign({name: ("operation", values) for name, values in stated.items()})

    def state(self, planning: Mapping) -> xr.Dataset:
        """Return the states of the drive and of its limits: see ``states_of``."""
        return states_of(self.forecast, planning)

    def save(self, path: str | File, **parameters: object) -> None:
        """Save the forecast, with the parameters that it was made by."""
        save_store(describe(self.forecast, "life", **parameters), path)

    @classmethod
    def load(cls, path: str | File) -> Self:
        """Return a life whose forecast was saved; it has no records."""
        found = cls([], {}, events={}, conditions={})
        found.forecast = open_store(path).load()
        return found


def _stated(name: str, records: Mapping[str, xr.Dataset], operations: np.ndarray) -> np.ndarray:
    """Return what the first motion states that knows it, ``(o,)``; empty where none does."""
    found = np.full(len(operations), "", dtype=object)
    for data in records.values():
        if name in data:
            values = data[name].to_series().reindex(operations, fill_value="")
            found = np.where(found == "", values, found)
    return found.astype(str)


def forecast_of(
    readout: Readout, path: Path, limits: Sequence[Limit], future: Future, threshold: float
) -> xr.Dataset:
    """Read the trend of a drive, and forecast its limits.

    Args:
        readout: How changes of the drive are read; with its series.
        path: What ``trend_of`` returns.
        limits: Limits on what the drive's motions show, at least one.
        threshold: Evidence from which a change is noticed, nats.

    Returns:
        Dataset over ``operation``, every one: ``evidence`` for a change (nats) and ``weight`` of
        the record; over ``asked``, numbers of the operations at which the life was read:
        ``changed`` ``(asked, parameter, quantile)``, percent since new, ``unchanged`` ``(asked,
        parameter)``, the probability of no change, ``p_exceeded``, ``p_nearer``, ``remaining``,
        ``lives`` and ``value`` of limits, as of ``Onward.forecast``, ``turns (asked, draw)``, as of
        ``Future.turns``, ``age (asked)``, operations since new or the last maintenance,
        ``noticed_in (asked)``, operations in which a change shows; over ``part``, those of limits:
        ``new``; over ``change``: ``noticed``, ``start``, ``earliest`` and ``latest``, numbers of
        operations, ``kind``, ``certainty`` (nats), and ``maintenance``, whether
        it is work on the drive; over ``motion``: ``p_value`` of the family. Attributes:
        ``family``, empty if it is of none, ``agreement`` of the motions, 1 of a single one,
        ``reported_from``, the first operation at which a trend is reported, later than the last one
        while there are fewer than ``needed`` of them, ``threshold`` and ``horizon``.
    """
    series, number = readout.series, readout.series.operations
    agreed = agreement(readout, path)
    if agreed < LEAST_AGREEMENT:
        readout = readout.withheld()
    where = _read_at(series, path)
    needed = int(series.new[-1]) + series.settle + 1
    first = number[needed - 1] if needed <= len(number) else number[-1] + 1
    found = {
        "evidence": ("operation", path.evidence),
        "weight": ("operation", path.weight),
        "p_value": ("motion", [each.p_value for each in readout.matches.values()]),
        **_parameters(readout, path, where),
        **_limits(limits, readout, path, where, future),
        **_changes(number, path.changes),
    }
    found["p_nearer"][1][number[where] < first] = np.nan
    coords = {"operation": number, "asked": number[where], "parameter": list(NAMES)}
    coords |= {"motion": list(readout.matches), "quantile": list(QUANTILES)}
    coords |= _limit_coords(limits)
    attrs = {"family": readout.family, "agreement": agreed, "needed": needed}
    attrs |= {"reported_from": int(first), "threshold": threshold, "horizon": future.horizon}
    return xr.Dataset(found, coords, attrs)


def trend_of(readout: Readout, threshold: float) -> Path:
    """Follow the coordinates of a drive."""
    series = readout.series
    follower = Follower(
        series.operations,
        readout.coordinates.blocks(series),
        new=series.new,
        settle=series.settle,
        threshold=threshold,
        counted=series.counted,
        conditions=series.conditions,
    )
    return follower.path(
        {i: event.transducer for i, event in series.events.items() if event.renews}
    )


def _read_at(series: Series, path: Path) -> np.ndarray:
    """Indices of the operations at which a life is read: of each inspection the last one."""
    known = np.flatnonzero(np.isfinite(path.change).all(axis=1))
    if series.inspections is not None:
        ends = np.append(np.diff(series.inspections) > 0, True)
        known = known[ends[known]]
    every = max(1, -(-known.size // _READ))
    return np.append(known[:-1:every], known[-1:])


def agreement(readout: Readout, path: Path) -> float:
    """Return how probably motions disagree as much on the change at the end; 1 without a doubt."""
    motions, last = list(readout.coordinates.curves), slice(-1, None)
    if len(motions) < 2:
        return 1.0
    found = [readout.parameters(path.change[last], path.variance[last], [m])[0] for m in motions]
    return float(agreement_of(*found).min()) if np.isfinite(found).all() else 1.0


def _parameters(readout: Readout, path: Path, where: np.ndarray) -> Mapping[str, tuple]:
    """Changes of the parameters since new."""
    draws = readout.parameters(path.change[where], path.variance[where])
    quantiles = np.moveaxis(np.quantile(draws, QUANTILES, axis=1), 0, -1)
    unchanged = np.where(np.isfinite(draws[:, 0]), (draws == 0.0).mean(axis=1), np.nan)
    return {
        "changed": (("asked", "parameter", "quantile"), quantiles, {"unit": "%"}),
        "unchanged": (("asked", "parameter"), unchanged),
    }


def _limits(
    limits: Sequence[Limit], readout: Readout, path: Path, where: np.ndarray, future: Future
) -> Mapping[str, tuple]:
    """What is known of limits."""
    number = readout.series.operations
    past = np.maximum(number[where] - float(number[0]), 1.0)
    onward = {
        since: Onward(path, readout, where, past, future, since)
        for since in {"new", *(limit.since for limit in limits)}
    }
    zero = np.zeros((1, readout.size))
    as_new = Condition(readout, zero, zero + 1e-12)
    new = [limit.read(as_new)[0] for limit in limits]
    each = [onward[limit.since].forecast(limit, of) for limit, of in zip(limits, new, strict=True)]
    found = {
        name: (dims, np.concatenate([one[name] for one in each], axis=1)) for name, dims in FORECAST
    }
    return found | {
        "new": ("part", np.concatenate([np.median(draws, axis=0) for draws in new])),
        "turns": (("asked", "draw"), onward["new"].turns.astype(np.float32)),
        "age": ("asked", _age(number, path.changes)[where]),
        "noticed_in": ("asked", future.noticed * past),
    }


def _age(operations: np.ndarray, changes: Sequence[Change]) -> np.ndarray:
    """Operations since new, or since the last maintenance of the drive, at least 1, ``(o,)``."""
    events = [operations[change.start] for change in changes if _maintenance(change)]
    last = np.append(operations[0], events)[np.searchsorted(events, operations, side="right")]
    return np.maximum(operations - last, 1.0)


def _limit_coords(limits: Sequence[Limit]) -> dict[str, object]:
    """Coordinates of limits and of their parts."""
    parts = [
        (limit.name, *part, unit)
        for limit in limits
        for part, unit in zip(limit.parts, limit.units, strict=True)
    ]
    names = ("limit", "quantity", "bound", "upper", "unit")
    found = {f"part_{name}": ("part", [part[k] for part in parts]) for k, name in enumerate(names)}
    for name, key in (("limit", "name"), ("words", "words"), ("of", "of")):
        found[name] = ("limit", np.array([getattr(limit, key) for limit in limits]))
    return found


def _changes(operations: np.ndarray, changes: Sequence[Change]) -> Mapping[str, tuple]:
    """Changes of the path."""
    places = np.array([change[:4] for change in changes], dtype=int).reshape(-1, 4)
    about = zip(Change._fields[:4], operations[places].astype(int).T, strict=True)
    maintained = [_maintenance(change) for change in changes]
    return {name: ("change", column) for name, column in about} | {
        "kind": ("change", np.array([change.kind for change in changes], dtype=str)),
        "certainty": ("change", np.array([change.evidence for change in changes])),
        "maintenance": ("change", np.array(maintained, dtype=bool)),
    }


def _maintenance(change: Change) -> bool:
    """Whether a change is maintenance of the drive, not of its transducer alone."""
    return change.kind == "event" and not change.transducer
