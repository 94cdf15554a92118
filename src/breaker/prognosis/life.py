"""The life of a drive: its records, their trend, forecasts of its limits, and its state."""

from collections.abc import Mapping, Sequence
from functools import cached_property
from pathlib import Path as File
from typing import TYPE_CHECKING, Self

import numpy as np
import xarray as xr

from breaker.common.zarr_store import describe, open_store
from breaker.common.zarr_store import save as save_store
from breaker.family.networks import LEAST_AGREEMENT, agreement_of, shipped_networks
from breaker.model.limits import Limit
from breaker.model.parameters import NAMES
from breaker.model.sensor import grid
from breaker.prognosis.forecast import QUANTILES, Forecast, Future, Onward, drift_of
from breaker.prognosis.readout import Condition, Readout
from breaker.prognosis.series import Event, Series, events_of, series_of
from breaker.prognosis.states import STATES, states_of
from breaker.prognosis.tables import days_per_operation, decide, operation_metadata
from breaker.prognosis.trend import Change, Follower, Path
from breaker.records.curves import read_curves
from breaker.records.folder import known_of
from breaker.records.grid import Grid
from breaker.records.operations import Operation
from breaker.shipped import KINDS

if TYPE_CHECKING:
    from breaker.diagnosis.estimate import Estimate
    from breaker.diagnosis.session import Diagnosis

_READ = 500  # operations, about, at which a life is read; all are followed
_NOTICED = 0.25  # share of the operations so far, in which few records show a change of rate


class Life:
    """The records of a drive and its state: the only class of the package that is updated.

    >>> life = Life(limits, settings)  # doctest: +SKIP
    >>> life.update({"closing": curves})  # doctest: +SKIP
    >>> life.state(planning)  # doctest: +SKIP

    Args:
        limits: Limits on what the motions of the drive show.
        settings: ``trend``, that section of the configuration, ``misfit_p_value`` and ``seed``.
        events, conditions: As of ``series_of``.
    """

    def __init__(
        self,
        limits: Sequence[Limit],
        settings: Mapping,
        *,
        events: Mapping[int, Event] | None = None,
        conditions: Mapping[str, Mapping[int, float]] | None = None,
    ) -> None:
        self.limits, self.settings = limits, settings
        self._events, self._conditions = events or {}, conditions or {}
        self._records: dict[str, xr.Dataset] = {}

    def update(self, records: Mapping[str, xr.Dataset]) -> None:
        """Add records of operations, as ``read_curves`` returns them, by motion."""
        for motion, new in records.items():
            some = [self._records[motion]] if motion in self._records else []
            self._records[motion] = xr.concat([*some, new], "operation") if some else new
        for name in ("readout", "trend", "forecast"):
            self.__dict__.pop(name, None)

    @cached_property
    def readout(self) -> Readout:
        """How changes of the drive are read, with its series; may raise as ``series_of``."""
        names: dict[str, list[str]] = {motion: [] for motion in self._records}
        for limit in self.limits:
            if limit.of == "record":
                names[limit.motion] += limit.quantities
        series = series_of(
            self._records,
            followed={motion: list(dict.fromkeys(some)) for motion, some in names.items()},
            events=self._events,
            conditions=self._conditions,
        )
        return Readout.of(
            series,
            list(shipped_networks(*KINDS)),
            draws=self.settings["trend"]["draws"],
            seed=self.settings["seed"],
            misfit_p_value=self.settings["misfit_p_value"],
        )

    @cached_property
    def trend(self) -> Path:
        """The path of the coordinates."""
        return trend_of(self.readout, self.settings["trend"]["threshold"])

    @cached_property
    def forecast(self) -> xr.Dataset:
        """All that is known after each operation: see ``forecast_of``."""
        trend = self.settings["trend"]
        future = Future(trend["horizon"])
        return forecast_of(self.readout, self.trend, self.limits, future, trend["threshold"])

    def state(self, planning: Mapping, per_operation: np.ndarray | None = None) -> xr.Dataset:
        """Return the states of limits and drive: see ``states_of``."""
        days = np.full(self.forecast.sizes["operation"], np.nan)
        return states_of(self.forecast, planning, days if per_operation is None else per_operation)

    def save(self, path: str | File, **parameters: object) -> None:
        """Save the forecast, with the parameters that it was made by."""
        save_store(describe(self.forecast, "life", **parameters), path)

    @classmethod
    def load(cls, path: str | File) -> Self:
        """Return a life whose forecast was saved; it has no records."""
        found = cls([], {})
        found.__dict__["forecast"] = open_store(path).load()
        return found


def trend_of(readout: Readout, threshold: float) -> Path:
    """Follow the coordinates of a drive."""
    series = readout.series
    life = Follower(
        series.operations,
        readout.coordinates.blocks(series),
        new=series.new,
        settle=series.settle,
        threshold=threshold,
        counted=series.counted,
        conditions=series.conditions,
    )
    return life.path({i: event.transducer for i, event in series.events.items() if event.renews})


def forecast_of(
    readout: Readout, path: Path, limits: Sequence[Limit], future: Future, threshold: float = 10.0
) -> xr.Dataset:
    """Read the trend of a drive, and forecast its limits.

    Args:
        readout: How changes of the drive are read; with its series.
        limits: Limits on what the drive's motions show.
        threshold: Evidence from which a change is noticed, kept for figures.

    Returns:
        Dataset over ``operation``, every one: ``evidence`` for a change (nats) and ``weight`` of
        the record; over ``asked``, numbers of the operations at which the life was read:
        ``changed`` ``(asked, parameter, quantile)``, percent since new, ``unchanged`` ``(asked,
        parameter)``, the probability of no change, ``p_exceeded`` and ``p_nearer`` ``(asked,
        limit)``, ``remaining`` ``(asked, limit, quantile)`` and ``lives`` ``(asked, limit,
        draw)``, as of ``Forecast``, ``turns (asked,
        draw)``, as of ``Future.turns``, ``noticed_in (asked)``, operations in which a change shows,
        and ``value`` ``(asked, part, quantile)`` of the limits' parts, with ``new (part)``; over
        ``change``: ``noticed``, ``start``, ``earliest`` and ``latest``, numbers of operations,
        ``kind``, ``certainty`` (nats), and ``maintenance``, whether it is work
        on the drive; over ``motion``: ``p_value`` of the family. Attributes:
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
        **_changes(readout, path),
    }
    late = number[where] >= first
    found["p_nearer"][1][~late] = np.nan
    coords = {"operation": number, "asked": number[where], "parameter": list(NAMES)}
    coords |= {"motion": list(readout.matches), "quantile": list(QUANTILES)}
    coords |= _limit_coords(limits)
    attrs = {"family": readout.family, "agreement": agreed, "needed": needed}
    attrs |= {"reported_from": int(first), "threshold": threshold, "horizon": future.horizon}
    return xr.Dataset(found, coords, attrs)


def _read_at(series: Series, path: Path) -> np.ndarray:
    """Indices of the operations at which a life is read: of each inspection the last one."""
    known = np.flatnonzero(np.isfinite(path.change).all(axis=1))
    if series.inspections is not None:
        ends = np.append(np.diff(series.inspections) > 0, True)
        known = known[ends[known]]
    every = max(1, -(-known.size // _READ))
    return np.append(known[:-1:every], known[-1:])


def agreement(readout: Readout, path: Path) -> float:
    """Return how probably closing and opening disagree as much on the change at the end, or more; 1
    of a single motion, or of no family.
    """
    motions, last = list(readout.coordinates.curves), slice(-1, None)
    if len(motions) < 2 or readout.changes is None:
        return 1.0
    found = [readout.parameters(path.change[last], path.variance[last], [m])[0] for m in motions]
    if not all(np.isfinite(draws).all() for draws in found):
        return 1.0
    return float(agreement_of(*found).min())


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
    number, count = readout.series.operations, len(where)
    past = np.maximum(number[where] - float(number[0]), 1.0)
    age = _age(number, path)[where]
    drift = drift_of(path, where, age, future, readout)
    onward = {
        since: Onward(path, readout, where, past, future, since)
        for since in {"new", *(limit.since for limit in limits)}
    }
    zero = np.zeros((1, readout.size))
    as_new = Condition(readout, zero, zero + 1e-12)
    new = [limit.read(as_new)[0] for limit in limits]
    found = [
        Forecast.of(limit, onward[limit.since], draws, drift, age, future)
        for limit, draws in zip(limits, new, strict=True)
    ]
    turns = onward["new"].turns[0]
    spacing = past / np.maximum(where, 1)
    noticed = np.minimum(future.noticed * spacing, _NOTICED * past)
    none, limited = np.zeros((count, 0)), ("asked", "limit")

    def side_by_side(name: str, shape: tuple[int, ...]) -> np.ndarray:
        some = [getattr(one, name) for one in found]
        return np.stack(some, axis=1) if some else np.zeros((count, 0, *shape))

    return {
        "p_exceeded": (limited, side_by_side("p_exceeded", ())),
        "p_nearer": (limited, side_by_side("p_nearer", ())),
        "remaining": ((*limited, "quantile"), side_by_side("remaining", (3,))),
        "lives": ((*limited, "draw"), side_by_side("lives", turns.shape[1:]).astype(np.float32)),
        "turns": (("asked", "draw"), turns.astype(np.float32)),
        "noticed_in": ("asked", noticed),
        "value": (
            ("asked", "part", "quantile"),
            np.hstack([none[..., None].repeat(3, axis=2), *(one.value for one in found)]),
        ),
        "new": ("part", np.concatenate([np.zeros(0), *(np.median(each, axis=0) for each in new)])),
    }


def _age(operations: np.ndarray, path: Path) -> np.ndarray:
    """Operations since new, or since the last maintenance of the drive, at least 1, ``(o,)``."""
    events = [operations[change.start] for change in path.changes if _maintenance(change)]
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
        found[name] = ("limit", np.array([getattr(limit, key) for limit in limits], dtype=str))
    return found


def _changes(readout: Readout, path: Path) -> Mapping[str, tuple]:
    """Changes of the path."""
    number, changes = readout.series.operations, path.changes
    places = np.array([change[:4] for change in changes], dtype=int).reshape(-1, 4)
    about = zip(Change._fields[:4], number[places].astype(int).T, strict=True)
    maintained = [_maintenance(change) for change in changes]
    return {name: ("change", column) for name, column in about} | {
        "kind": ("change", np.array([change.kind for change in changes], dtype=str)),
        "certainty": ("change", np.array([change.evidence for change in changes])),
        "maintenance": ("change", np.array(maintained, dtype=bool)),
    }


def _maintenance(change: Change) -> bool:
    """Whether a change is maintenance of the drive, not of its transducer alone."""
    return change.kind == "event" and not change.transducer


def follow_drive(
    operations: Mapping[str, Sequence[Operation]],
    used: Sequence["Estimate"],
    diagnosis: "Diagnosis",
) -> list[tuple[str, str, float, float, str | None]]:
    """Follow a drive from its files to the state of each limit after the last operation.

    Args:
        operations: By motion.
        used: Estimates of some usable records, which show how long motions are.
        diagnosis: Configuration and limits.

    Returns:
        Name, state, probability that the limit is exceeded, and operation and date by which to
        service, of each limit.
    """
    config = diagnosis.config
    usual = np.exp(used[0].levels.usual[1, 0])
    longer = np.median([each.record.shape.duration for each in used]) / usual
    times = longer * grid(**{key: config["sensor"][key] for key in ("start", "stop", "samples")})
    form, speeds = config["endurance"]["format"], used[0].speeds
    curves = {m: read_curves(e, form, Grid(times), m, speeds=speeds) for m, e in operations.items()}
    rows = [each for some in operations.values() for each in some]
    texts, conditions = known_of(rows, sorted({each.number for each in rows}))
    life = Life(
        diagnosis.limits_on(used, curves),
        {"trend": config["trend"], "seed": config["seed"]}
        | {"misfit_p_value": config["endurance"]["misfit_p_value"]},
        events=events_of(texts, config["endurance"]["events"]),
        conditions=conditions,
    )
    life.update(curves)
    states, decisions = decided(life, curves, config["planning"])
    last, decision = states.isel(operation=-1), decisions.iloc[-1]
    found = []
    for k, name in enumerate(states.limit.values.tolist()):
        date = decision.get("service_by_date") if decision.limit == name else None
        numbers = float(last.p_exceeded[k]), float(last.service_by[k])
        found.append((name, STATES[int(last.state[k])], *numbers, date or None))
    return found


def decided(life: Life, curves: Mapping[str, xr.Dataset], planning: Mapping) -> tuple:
    """Return the states of a life, and the table of decisions: see ``states_of``, ``decide``."""
    forecast = life.forecast
    known = operation_metadata(curves, forecast.operation.values)
    states = life.state(planning, days_per_operation(forecast.operation.values, list(known.date)))
    return states, decide(forecast, states, known)
