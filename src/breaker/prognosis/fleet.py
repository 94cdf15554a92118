"""A fleet: a loop over drives, each a phase of a breaker.

The last inspection of a drive is judged as ``breaker infer`` does, or compared with the first one
as ``breaker compare`` does, and a long life is followed. A fault of one drive stops no other.
"""

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import timedelta

import numpy as np

from breaker.common.plain_values import note_of, plainly
from breaker.configuration.loading import defaults
from breaker.diagnosis.changes import mean_error, usual_scatter
from breaker.diagnosis.estimate import Estimate
from breaker.diagnosis.limits import Verdict
from breaker.diagnosis.session import Diagnosis
from breaker.model.quantities import quantities_of
from breaker.model.sensor import grid
from breaker.prognosis.fleet_table import TONES, DriveResult, LimitState, MeasuredValue, label
from breaker.prognosis.life_records import Event
from breaker.prognosis.life_results import follow_curves
from breaker.prognosis.life_tables import decided
from breaker.records.curves import read_curves
from breaker.records.dates import instant, one_date
from breaker.records.files import Files
from breaker.records.folder import known_of
from breaker.records.formats.registry import stated_in
from breaker.records.grid import Grid
from breaker.records.operations import Operation

_APART = timedelta(days=30)  # an inspection takes days, and the next is months later
_MOST = 20  # operations of an inspection: more reduce no error that they share
_LIFE = 150  # operations from which a life is followed: it needs 100 for its reference
_SURE = 0.95  # probability from which a limit is due; below the rest of it a limit is ok


@dataclass(frozen=True)
class Drive:
    """A drive: names, empty where unknown, and the operations of each inspection by motion."""

    breaker: str
    phase: str
    type: str
    inspections: Sequence[Mapping[str, Sequence[Operation]]]

    @property
    def operations(self) -> list[Operation]:
        """All operations, by inspection and motion."""
        return [e for some in self.inspections for own in some.values() for e in own]


def drives_of(
    rows: Mapping[str, Sequence[tuple[str, Operation]]], motions: Collection[str], form: Mapping
) -> Iterator[Drive]:
    """Yield the drives in the rows of a table, as ``list_fleet`` returns them.

    A file states the date and the type that no row states; ``form`` is ``endurance.format``.
    """
    files = Files()
    for breaker, own in rows.items():
        for phase in dict.fromkeys(each.phase for _, each in own):
            some = [row for row in own if row[1].phase == phase and row[0] in motions]
            stated = [stated_in(files[e.file], form, e.channel) for _, e in some]
            dated = [
                (motion, replace(e, date=one_date(e.date, header.dates, e.file)))
                for (motion, e), header in zip(some, stated, strict=True)
            ]
            types = [e.type for _, e in some] + [header.type for header in reversed(stated)]
            if some:
                yield Drive(breaker, phase, next(filter(None, types), ""), inspections_of(dated))


def inspections_of(rows: Iterable[tuple[str, Operation]]) -> list[dict[str, list[Operation]]]:
    """Return the operations of each inspection by motion; one without a date belongs to the
    inspection before.

    >>> dates = {1: "2012-05-01", 2: "", 9: "2026-03-01"}
    >>> found = inspections_of(("closing", Operation(n, "", date=dates[n])) for n in dates)
    >>> [[operation.number for operation in each["closing"]] for each in found]
    [[1, 2], [9]]
    """
    found, last = [], None
    for motion, operation in sorted(rows, key=lambda row: row[1].number):
        day = instant(operation.date) if operation.date else last
        if not found or (last and day - last > _APART):
            found.append({})
        found[-1].setdefault(motion, []).append(operation)
        last = day
    return found


def examine(drive: Drive, config: Mapping, types: Mapping[str, Mapping]) -> DriveResult:
    """Return the knowledge of a drive.

    Limits that ship count only if they are on changes: the others are of one size of drives. Of
    ``types``, the entries of types, that of the drive counts.
    """
    dates = sorted((e.date for e in drive.operations if e.date), key=instant)
    result = DriveResult(
        breaker=drive.breaker,
        phase=drive.phase,
        type=drive.type,
        first=dates[0] if dates else "",
        last=dates[-1] if dates else "",
        operation=max(e.number for e in drive.operations),
        records=len(drive.operations),
        inspections=len(drive.inspections),
    )
    shipped = defaults()["limits"]
    limits = [e for e in config["limits"] if config["limits"] != shipped or e.get("of") == "change"]
    diagnosis = Diagnosis(config, limits, types=types)
    try:
        diagnosis = diagnosis.of_type(drive.type) if types and drive.type else diagnosis
        found = _examined(drive, diagnosis)
    except (OSError, ValueError) as error:
        found = {"remarks": [error]}
    notes = [note_of(remark) for remark in found.pop("remarks")]
    return replace(result, **plainly(found), remarks=notes)


def _examined(drive: Drive, diagnosis: Diagnosis) -> dict[str, object]:
    """Return the fields of ``DriveResult`` that records show."""
    read = [
        diagnosis.read({motion: own[-_MOST:] for motion, own in some.items()})
        for some in (drive.inspections[0], drive.inspections[-1])
    ]
    before, today = read
    used = [each for each in diagnosis.infer(today) if not each.record.reason]
    remarks: list[object] = [record.reason for record in today if record.reason]
    found = {"rejected": len(remarks), "remarks": remarks, "measured": _measured(used)}
    if not used:
        return found
    verdicts, differ = [row for rows in diagnosis.judge(used) for row in rows], False
    if len(drive.inspections) > 1:
        try:
            change = diagnosis.compare({"before": before, "today": today})
        except ValueError as error:  # no usable record in the first inspection
            remarks.append(error)
        else:
            found["changes"] = change.measured
            remarks += [*change.warnings, *change.limitations]
            differ = bool(change.differences)
            verdicts = [] if differ else change.limits
    limits = _states(verdicts)
    if not differ and len({each.number for each in drive.operations}) >= _LIFE:
        limits = _followed(drive, used, diagnosis)
    return found | {"limits": limits, "state": limits[0].state if limits else "unknown"}


def _states(verdicts: Iterable[Verdict]) -> list[LimitState]:
    """Return the state of each limit by its mean probability over records, the worst first."""
    by: dict[str, list[float]] = {}
    for each in verdicts:
        by.setdefault(each.name, []).append(np.nan if each.p_exceeded is None else each.p_exceeded)
    found = []
    for name, values in by.items():
        p = float(np.mean(values))
        state = "due" if p >= _SURE else "ok" if p <= 1.0 - _SURE else "unknown"
        found.append(LimitState(name, state, p))
    return _urgent_first(found)


def _urgent_first(states: Iterable[LimitState]) -> list[LimitState]:
    return sorted(states, key=lambda e: ([*TONES].index(e.state), -(e.p_exceeded or 0.0)))


def _measured(used: Sequence[Estimate]) -> list[MeasuredValue]:
    """Return the means of what the records of an inspection show."""
    readings: dict[tuple[str, str], list] = {}
    for each in used:
        for name, measured in each.measured.items():
            if np.isfinite(measured.value) and each.measured_directly(name):
                readings.setdefault((name, each.record.motion), []).append(measured[:2])
    found = []
    for (name, motion), some in readings.items():
        values = np.array(some, dtype=float)
        stroke = np.mean(readings.get(("stroke", motion), [[0.0]]), axis=0)[0]
        mean = float(values[:, 0].mean())
        sd = mean_error([values], usual_scatter(name, mean, float(stroke)))
        unit = quantities_of(motion, used[0].speeds, ("record",))[name].unit
        found.append(MeasuredValue(label(name, motion), unit, mean, sd))
    return found


def _followed(drive: Drive, used: Sequence[Estimate], diagnosis: Diagnosis) -> list[LimitState]:
    """Return the state of each limit after the life of a drive."""
    config, speeds, levels = diagnosis.config, used[0].speeds, used[0].levels
    longer = np.median([each.record.shape.duration for each in used]) / np.exp(levels.usual[1, 0])
    times = longer * grid(**{key: config["sensor"][key] for key in ("start", "stop", "samples")})
    form, by = config["endurance"]["format"], {}
    for some in drive.inspections:
        for motion, own in some.items():
            by.setdefault(motion, []).extend(own)
    curves = {m: read_curves(own, form, Grid(times), m, speeds=speeds) for m, own in by.items()}
    texts, conditions = known_of(drive.operations, sorted({e.number for e in drive.operations}))
    life = follow_curves(
        curves,
        diagnosis.limits_on(used, curves),
        {"trend": config["trend"], "seed": config["seed"]}
        | {"misfit_p_value": config["endurance"]["misfit_p_value"]},
        events=Event.by_operation(texts, config["endurance"]["events"]),
        conditions=conditions,
    )
    stands, decisions = decided(life, curves, config["planning"])
    last, row = stands.isel(operation=-1), decisions.iloc[-1]
    found = []
    for k, name in enumerate(life.limit.values.tolist()):
        state = ("unknown", "ok", "planned", "due")[int(last.state[k])]
        date = row.get("service_by_date") if row.limit == name else None
        numbers = (float(last.beyond[k]), float(last.service_by[k]))
        found.append(LimitState(name, state, *numbers, date or None))
    return _urgent_first(found)
