"""A life, followed: all that is known after each operation, for tables and figures."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from breaker.family.networks import LEAST_AGREEMENT, agreement_of, shipped_networks
from breaker.model.limits import Limit
from breaker.model.parameters import NAMES
from breaker.model.sensor import grid
from breaker.prognosis.drift import Drift
from breaker.prognosis.forecast import Forecast, Future, Onward
from breaker.prognosis.life_records import Event, series_of
from breaker.prognosis.life_tables import decided
from breaker.prognosis.path_fit import Change, Path
from breaker.prognosis.readout import Readout, name_set
from breaker.prognosis.tracker import Tracker
from breaker.records.curves import read_curves
from breaker.records.folder import known_of
from breaker.records.grid import Grid
from breaker.records.operations import Operation
from breaker.shipped import KINDS

if TYPE_CHECKING:
    from breaker.diagnosis.estimate import Estimate
    from breaker.diagnosis.session import Diagnosis

QUANTILES = (0.05, 0.5, 0.95)
_ASKED = 500  # operations, about, at which a life is read; all are followed


def follow_curves(
    data: Mapping[str, xr.Dataset],
    limits: Sequence[Limit],
    settings: Mapping,
    *,
    events: Mapping[int, Event],
    conditions: Mapping[str, Mapping[int, float]],
) -> xr.Dataset:
    """Follow a drive by the networks that ship, and judge its limits: see ``follow_life``.

    Args:
        data, events, conditions: As of ``series_of``, which may raise.
        settings: ``trend``, that section of the configuration, ``misfit_p_value`` and
            ``seed``.
    """
    trend = settings["trend"]
    names: dict[str, list[str]] = {motion: [] for motion in data}
    for limit in limits:
        if limit.of == "record":
            names[limit.motion] += limit.quantities
    followed = {motion: list(dict.fromkeys(each)) for motion, each in names.items()}
    series = series_of(
        data,
        trend["reference"],
        followed=followed,
        events=events,
        conditions=conditions,
    )
    del data  # which is large, and of no more use
    readout = Readout.of(
        series,
        list(shipped_networks(*KINDS)),
        draws=trend["draws"],
        seed=settings["seed"],
        misfit_p_value=settings["misfit_p_value"],
    )
    tracker = Tracker.from_settings(trend)
    future = Future.from_settings(trend)
    return follow_life(readout, tracker, limits, future)


def follow_drive(
    operations: Mapping[str, Sequence[Operation]],
    used: Sequence["Estimate"],
    diagnosis: "Diagnosis",
) -> list[tuple[str, str, float, float, str | None]]:
    """Follow a drive from its files to the state of each limit after the last operation.

    Args:
        operations: By motion.
        used: Estimates of some usable records, which tell how long motions are.
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
    life = follow_curves(
        curves,
        diagnosis.limits_on(used, curves),
        {"trend": config["trend"], "seed": config["seed"]}
        | {"misfit_p_value": config["endurance"]["misfit_p_value"]},
        events=Event.by_operation(texts, config["endurance"]["events"]),
        conditions=conditions,
    )
    stands, decisions = decided(life, curves, config["planning"])
    last, decision = stands.isel(operation=-1), decisions.iloc[-1]
    found = []
    for k, name in enumerate(life.limit.values.tolist()):
        state = ("unknown", "ok", "planned", "due")[int(last.state[k])]
        date = decision.get("service_by_date") if decision.limit == name else None
        found.append((name, state, float(last.beyond[k]), float(last.service_by[k]), date or None))
    return found


def follow_life(
    readout: Readout, tracker: Tracker, limits: Sequence[Limit], future: Future
) -> xr.Dataset:
    """Follow a drive and judge its limits.

    Args:
        readout: How changes of the drive are read; with its series.
        limits: Limits on what the drive's motions show.

    Returns:
        Dataset over ``operation``, every one: ``evidence`` for a change (nats) and ``weight`` of
        the record; over ``asked``, numbers of the operations at which the life was read:
        ``changed`` ``(asked, parameter, quantile)``, percent since new, ``unchanged`` ``(asked,
        parameter)``, the probability of no change, ``names``, the set of what has changed most,
        ``beyond`` ``(asked, limit)``, ``remaining`` ``(asked, limit, quantile)`` and ``lives``
        ``(asked, limit, draw)``, as of ``Forecast``, and ``value`` ``(asked, part, quantile)`` of
        the limits' parts, with ``new (part)`` and ``common (asked, part)``, how far all
        readings are off alike (sd); over ``change``: ``noticed``, ``start``,
        ``earliest`` and ``latest``, numbers of operations, ``kind``, ``certainty`` (nats; below 0
        taken back), ``work``, whether it is work on the drive, and ``change_names``; over
        ``motion``: ``p_value`` of the family. Attributes ``family``, empty if it is of none,
        ``agreement`` of the motions, 1 of a single one, ``told``, the first operation at which
        anything but what is measured is told, later than the last one while there are fewer
        than ``needed`` of them, ``threshold``, and the fields of ``Future``.
    """
    series = readout.series
    blocks = readout.coordinates.blocks(series)
    events = {i: event.transducer for i, event in series.events.items() if event.renews}
    path = tracker.follow(
        series.operations, blocks, new=series.new, events=events, conditions=series.apart
    )
    apart = agreement(readout, path)
    if apart < LEAST_AGREEMENT:
        readout = readout.withheld()
    known = np.flatnonzero(np.isfinite(path.change).all(axis=1))
    every = max(1, -(-known.size // _ASKED))
    where = np.append(known[:-1:every], known[-1:])
    number = series.operations
    needed = int(series.new[-1]) + tracker.settle + 1
    told = number[needed - 1] if needed <= len(number) else number[-1] + 1
    found = {
        "evidence": ("operation", path.evidence),
        "weight": ("operation", path.weight),
        "p_value": ("motion", [each.p_value for each in readout.matches.values()]),
        **_parameters(readout, path, where),
        **_limits(limits, readout, path, where, future),
        **_changes(readout, path, tracker.settle),
    }
    coords = {"operation": number, "asked": number[where], "parameter": list(NAMES)}
    coords |= {"motion": list(readout.matches), "quantile": list(QUANTILES)}
    coords |= _limit_coords(limits)
    attrs = {"family": readout.family, "agreement": apart, "told": int(told), "needed": needed}
    return xr.Dataset(found, coords, attrs | {"threshold": tracker.threshold} | future._asdict())


def agreement(readout: Readout, path: Path) -> float:
    """Return how probably closing and opening are as far apart on the change at the end, or more; 1
    of a single motion, or of no family.
    """
    motions = list(readout.coordinates.curves)
    if len(motions) < 2 or readout.changes is None:
        return 1.0
    last = slice(-1, None)
    each = [readout.parameters(path.change[last], path.variance[last], [m])[0] for m in motions]
    if not all(np.isfinite(draws).all() for draws in each):
        return 1.0
    return float(agreement_of(*each).min())


def _parameters(readout: Readout, path: Path, where: np.ndarray) -> Mapping[str, tuple]:
    """Changes of the parameters since new."""
    draws = readout.parameters(path.change[where], path.variance[where])
    usual = readout.usual()
    names = [" or ".join(name_set(each, usual)) for each in draws]
    return {
        "changed": (
            ("asked", "parameter", "quantile"),
            np.moveaxis(np.quantile(draws, QUANTILES, axis=1), 0, -1),
            {"unit": "%"},
        ),
        "unchanged": (
            ("asked", "parameter"),
            np.where(np.isfinite(draws[:, 0]), (draws == 0.0).mean(axis=1), np.nan),
        ),
        "names": ("asked", np.array(names, dtype=str)),
    }


def _limits(
    limits: Sequence[Limit], readout: Readout, path: Path, where: np.ndarray, future: Future
) -> Mapping[str, tuple]:
    """What is known of limits."""
    operations = readout.series.operations[where]
    past = np.maximum(operations - float(readout.series.operations[0]), 1.0)
    onward = {
        since: Onward(path, readout, where, future.horizon, since)
        for since in {limit.since for limit in limits}
    }
    age = _age(readout.series.operations, path)[where]
    drift = Drift.of(path, where, age, future.drift, future.drifting, readout.seed)
    found = [Forecast.of(limit, onward[limit.since], drift, past, future) for limit in limits]
    zero = np.zeros((1, readout.size))
    as_new = readout.condition(zero, zero + 1e-12, readout.series.new[-1:])
    new = [np.median(limit.read(as_new)[0], axis=0) for limit in limits]
    common = [_common(limit, readout)[where] for limit in limits]
    none = np.zeros((len(where), 0, 3))
    each = ("asked", "limit", "quantile")
    beyond = [one.beyond[:, None] for one in found]
    return {
        "beyond": (each[:2], np.hstack([none[..., 0], *beyond])),
        "remaining": (each, np.hstack([none, *(one.remaining[:, None] for one in found)])),
        "lives": ((*each[:2], "draw"), np.stack([one.lives for one in found], axis=1))
        if found
        else ((*each[:2], "draw"), np.zeros((len(where), 0, 0))),
        "value": (("asked", "part", "quantile"), np.hstack([none, *(one.value for one in found)])),
        "new": ("part", np.concatenate([np.zeros(0), *new])),
        "common": (("asked", "part"), np.hstack([none[..., 0], *common])),
    }


def _age(operations: np.ndarray, path: Path) -> np.ndarray:
    """Operations since new, or since the last work on the drive, at least 1, ``(o,)``."""
    works = [operations[change.start] for change in path.changes if _work(change)]
    last = np.append(operations[0], works)[np.searchsorted(works, operations, side="right")]
    return np.maximum(operations - last, 1.0)


def _common(limit: Limit, readout: Readout) -> np.ndarray:
    """How far all readings of each part are off alike, sd, ``(o, parts)``; 0 of the inferred."""
    found = np.zeros((len(readout.series.operations), len(limit.parts)))
    for k, name in enumerate(limit.quantities):
        row = readout.coordinates.row(limit.motion, name) if limit.of == "record" else None
        found[:, k] = row[0].common if row else 0.0
    return found


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


def _changes(readout: Readout, path: Path, settle: int) -> Mapping[str, tuple]:
    """Changes of the path, and what has most to do with each."""
    number, names = readout.series.operations, []
    for k, change in enumerate(path.changes):
        begins = [later.start for later in path.changes[k + 1 :]]
        last = min([change.noticed + settle, len(number) - 1, *(b - 1 for b in begins)])
        names.append(_named(readout, path, max(change.start - 1, 0), max(last, change.start)))
    places = np.array([change[:4] for change in path.changes], dtype=int).reshape(-1, 4)
    about = zip(Change._fields[:4], number[places].astype(int).T, strict=True)
    return {name: ("change", column) for name, column in about} | {
        "kind": ("change", np.array([change.kind for change in path.changes], dtype=str)),
        "certainty": ("change", np.array([change.evidence for change in path.changes])),
        "work": ("change", np.array([_work(change) for change in path.changes], dtype=bool)),
        "change_names": ("change", np.array(names, dtype=str)),
    }


def _work(change: Change) -> bool:
    """Whether a change is known work on the drive, not on its transducer alone."""
    return change.kind == "event" and not change.transducer


def _named(readout: Readout, path: Path, before: int, after: int) -> str:
    """Name what has most to do with the way off a line that the drive was on; empty if nothing."""
    number = readout.series.operations
    on = float(number[after] - number[before])
    off = path.change[after] - path.change[before] - on * path.rate[before]
    variance = path.variance[after] + path.variance[before]
    variance = variance + on**2 * path.rate_variance[before]
    if readout.changes is None or not np.isfinite(off).all():
        return ""
    draws = readout.parameters(off[None], variance[None])[0]
    return " or ".join(name_set(draws, readout.usual()))
