"""A fleet: a loop over drives, each a phase of a breaker.

The last inspection of a drive is judged as by ``breaker infer``, or compared with the first one as
by ``breaker compare``, and a life is followed. An error of one drive does not stop the others.
"""

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace

import numpy as np

from breaker.common.plain_values import note_of, plainly
from breaker.configuration.loading import defaults
from breaker.diagnosis.changes import mean_error
from breaker.diagnosis.estimate import Estimate
from breaker.diagnosis.inspection_change import compare_inspections
from breaker.diagnosis.limits import Verdict
from breaker.diagnosis.sentences import say
from breaker.diagnosis.session import Diagnosis
from breaker.model.quantities import quantities_of
from breaker.model.sensor import grid
from breaker.prognosis import series
from breaker.prognosis.fleet_table import STATES, DriveResult, LimitState, MeasuredValue
from breaker.prognosis.life import follow
from breaker.prognosis.limit_states import STATES as LIFE_STATES
from breaker.prognosis.limit_states import next_state, states_of
from breaker.records.curves import Grid, read_curves
from breaker.records.dates import instant, one_date
from breaker.records.files import Files
from breaker.records.folder import known_of
from breaker.records.formats.detection import stated_in
from breaker.records.operations import Operation

_MOST = 20  # operations of an inspection that are used: more do not reduce their common error
_LIFE = 150  # operations from which a life is followed: it needs 100 for its reference

Row = tuple[str, Operation]  # motion and operation of a record


@dataclass(frozen=True)
class Drive:
    """A drive: names, empty where unknown; the rows of each inspection."""

    breaker: str
    phase: str
    type: str
    inspections: Sequence[Sequence[Row]]


def drives_of(
    rows: Mapping[str, Sequence[Row]], motions: Collection[str], form: Mapping
) -> Iterator[Drive]:
    """Yield the drives in the rows of ``list_fleet``. Dates and types that rows lack are read from
    the files; ``form`` is ``endurance.format``.
    """
    files = Files()
    for breaker, breaker_rows in rows.items():
        phases = _grouped((row[1].phase, row) for row in breaker_rows if row[0] in motions)
        for phase, listed in phases.items():
            stated = [
                stated_in(files[operation.file], form, operation.channel) for _, operation in listed
            ]
            dated = [
                (
                    motion,
                    replace(operation, date=one_date(operation.date, header.dates, operation.file)),
                )
                for (motion, operation), header in zip(listed, stated, strict=True)
            ]
            types = [operation.type for _, operation in listed] + [
                header.type for header in reversed(stated)
            ]
            yield Drive(breaker, phase, next(filter(None, types), ""), inspections_of(dated))


def inspections_of(rows: Iterable[Row]) -> list[list[Row]]:
    """Return the rows of each inspection, as in a life; a monitored drive has one inspection."""
    rows = sorted(rows, key=lambda row: row[1].number)
    dates = {operation.number: "" for _, operation in rows}
    dates |= {operation.number: operation.date for _, operation in rows if operation.date}
    grouped = series.inspections_of(np.array([*dates]), series.days_of([*dates.values()]))
    places = dict(zip(dates, np.zeros(len(dates)) if grouped is None else grouped, strict=True))
    return [*_grouped((places[row[1].number], row) for row in rows).values()]


def _grouped(pairs: Iterable[tuple]) -> dict:
    """Return the second parts of pairs by the first."""
    groups: dict = {}
    for key, value in pairs:
        groups.setdefault(key, []).append(value)
    return groups


@contextmanager
def _noted(remarks: list) -> Iterator[None]:
    """Append a ValueError to the remarks, and continue."""
    try:
        yield
    except ValueError as error:
        remarks.append(error)


def examine(drive: Drive, config: Mapping, types: Mapping[str, Mapping]) -> DriveResult:
    """Return the result for a drive, by the entry of its type in ``types``.

    Of the shipped limits only those on changes count: the others are for one size of drives.
    """
    limits, shipped = config["limits"], defaults()["limits"]
    limits = [limit for limit in limits if limits != shipped or limit.get("of") == "change"]
    diagnosis, results, remarks = Diagnosis(config, limits, types=types), {}, []
    with _noted(remarks):  # a type that only a file states may have no entry
        diagnosis = diagnosis.of_type(drive.type) if types and drive.type else diagnosis
    with _noted(remarks):
        results = _examined(drive, diagnosis, remarks)
    operations = [operation for rows in drive.inspections for _, operation in rows]
    dates = sorted((e.date for e in operations if e.date), key=instant) or [""]
    facts = {name: getattr(drive, name) for name in ("breaker", "phase", "type")}
    facts |= {"first": dates[0], "last": dates[-1], "inspections": len(drive.inspections)}
    facts |= {"operation": max(e.number for e in operations), "records": len(operations)}
    return DriveResult(**facts, remarks=[note_of(remark) for remark in remarks], **plainly(results))


def _examined(drive: Drive, diagnosis: Diagnosis, remarks: list) -> dict[str, object]:
    """Return the fields of ``DriveResult`` that depend on records, and add remarks."""
    *before, today = (
        diagnosis.read({motion: own[-_MOST:] for motion, own in _grouped(rows).items()})
        for rows in (*drive.inspections[:-1][:1], drive.inspections[-1])
    )
    remarks += [record.reason for record in today if record.reason]
    used = [estimate for estimate in diagnosis.infer(today) if not estimate.record.reason]
    results = {"rejected": len(today) - len(used), "measured": [*_measured(used)]}
    if not used:
        return results
    limits = [*_states(row for rows in diagnosis.judge(used) for row in rows)]
    with _noted(remarks):  # no usable record in the first inspection
        if before:
            change = compare_inspections(diagnosis, {"before": before[0], "today": today})
            remarks += [*change.warnings, *change.limitations]
            results["changes"], on_both = change.measured, _states(change.limits)
            limits = [*{known.limit: known for known in (*limits, *on_both)}.values()]
            if change.differences:
                return results
    numbers = {operation.number for rows in drive.inspections for _, operation in rows}
    with _noted(remarks):  # no record counts as new
        if len(drive.inspections) > 2 or len(numbers) >= _LIFE:  # two inspections are compared
            limits = _followed(drive, used, diagnosis) or limits
    remarks += [] if limits else [say("no-limit-of-drive")]
    limits.sort(key=lambda entry: (STATES.index(entry.state), -(entry.p_exceeded or 0.0)))
    return results | {"limits": limits, "state": limits[0].state if limits else "unknown"}


def _states(verdicts: Iterable[Verdict]) -> Iterator[LimitState]:
    """Yield the state of each limit by its mean probability over records."""
    for name, values in _grouped(
        (verdict["name"], verdict["p_exceeded"]) for verdict in verdicts
    ).items():
        p = float(np.mean(np.array(values, dtype=float)))  # nan without a value
        yield LimitState(name, next_state("unknown", p, 0.0, np.inf), p)


def _followed(drive: Drive, used: Sequence[Estimate], diagnosis: Diagnosis) -> list[LimitState]:
    """Return the states of limits at the end of a life; estimates give the length of motions."""
    config, rows = diagnosis.config, [row for own in drive.inspections for row in own]
    longer = np.median([estimate.record.shape.duration for estimate in used])
    longer /= np.exp(used[0].levels.usual[1, 0])
    times = longer * grid(**{key: config["sensor"][key] for key in ("start", "stop", "samples")})
    form, speeds = config["endurance"]["format"], used[0].speeds
    curves = {
        motion: read_curves(own, form, Grid(times), motion, speeds=speeds)
        for motion, own in _grouped(rows).items()
    }
    if not (limits := diagnosis.limits_on(used, curves)):
        return []
    operations = [listed for _, listed in rows]
    events, conditions = known_of(operations, sorted({chosen.number for chosen in operations}))
    life = follow(curves, limits, config, events=events, conditions=conditions)
    columns = ["state", "p_exceeded", "service_by", "service_by_date"]
    last = states_of(life, config["planning"]).isel(operation=-1)[columns].to_dataframe()
    return [
        LimitState(row.Index, LIFE_STATES[row.state], *row[2:4], row.service_by_date or None)
        for row in last[columns].itertuples()
    ]


def _measured(used: Sequence[Estimate]) -> Iterator[MeasuredValue]:
    """Yield the means of quantities measured in the records of an inspection."""
    readings = _grouped(
        ((name, estimate.record.motion), measured[:2])
        for estimate in used
        for name, measured in estimate.measured.items()
        if np.isfinite(measured.value) and estimate.measured_directly(name)
    )
    for (name, motion), pairs in readings.items():
        values = np.array(pairs, dtype=float)
        stroke = np.mean(readings.get(("stroke", motion), [[0.0]]), axis=0)[0]
        sd = mean_error([values], name, float(stroke))
        unit = quantities_of(motion, used[0].speeds, ("record",))[name].unit
        quantity = name if motion in name else f"{motion} {name}"  # as in a file of types
        yield MeasuredValue(quantity, unit, float(values[:, 0].mean()), sd)
