"""A fleet: a loop over drives, each a phase of a breaker.

The last inspection of a drive is judged as ``breaker infer`` does, or compared with the first one
as ``breaker compare`` does, and a long life is followed. A fault of one drive stops no other.
"""

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from datetime import timedelta

import numpy as np

from breaker.common.plain_values import note_of, plainly
from breaker.configuration.loading import defaults
from breaker.diagnosis.changes import mean_error
from breaker.diagnosis.estimate import Estimate
from breaker.diagnosis.limits import Verdict
from breaker.diagnosis.session import Diagnosis
from breaker.diagnosis.words import say
from breaker.model.quantities import quantities_of
from breaker.prognosis.fleet_table import STATES, DriveResult, LimitState, MeasuredValue
from breaker.prognosis.life import follow_drive
from breaker.records.dates import instant, one_date
from breaker.records.files import Files
from breaker.records.formats.registry import stated_in
from breaker.records.operations import Operation

_APART = timedelta(days=30)  # an inspection takes days, and the next is months later
_MOST = 20  # operations of an inspection: more reduce no error that they share
_LIFE = 150  # operations from which a life is followed: it needs 100 for its reference
_SURE = 0.95  # probability from which a limit is due; below the rest of it a limit is ok


@dataclass(frozen=True)
class Drive:
    """A drive: names, empty where unknown; motion and operation of each record, by inspection."""

    breaker: str
    phase: str
    type: str
    inspections: Sequence[Sequence[tuple[str, Operation]]]


def drives_of(
    rows: Mapping[str, Sequence[tuple[str, Operation]]], motions: Collection[str], form: Mapping
) -> Iterator[Drive]:
    """Yield the drives in the rows of ``list_fleet``. A file states a date or type that no row
    states; ``form`` is ``endurance.format``.
    """
    files = Files()
    for breaker, every in rows.items():
        phases = _grouped((row[1].phase, row) for row in every if row[0] in motions)
        for phase, own in phases.items():
            stated = [stated_in(files[each.file], form, each.channel) for _, each in own]
            dated = [
                (motion, replace(each, date=one_date(each.date, header.dates, each.file)))
                for (motion, each), header in zip(own, stated, strict=True)
            ]
            types = [each.type for _, each in own] + [header.type for header in reversed(stated)]
            yield Drive(breaker, phase, next(filter(None, types), ""), inspections_of(dated))


def inspections_of(rows: Iterable[tuple[str, Operation]]) -> list[list[tuple[str, Operation]]]:
    """Return the rows of each inspection; one without a date belongs to the inspection before."""
    found, last = [], None
    for row in sorted(rows, key=lambda row: row[1].number):
        day = instant(row[1].date) if row[1].date else last
        if not found or (last and day - last > _APART):
            found.append([])
        found[-1].append(row)
        last = day
    return found


def _grouped(pairs: Iterable[tuple]) -> dict:
    """Return the second parts of pairs by the first."""
    found: dict = {}
    for key, value in pairs:
        found.setdefault(key, []).append(value)
    return found


@contextmanager
def _noted(remarks: list) -> Iterator[None]:
    """Take an error as a remark, and go on."""
    try:
        yield
    except ValueError as error:
        remarks.append(error)


def examine(drive: Drive, config: Mapping, types: Mapping[str, Mapping]) -> DriveResult:
    """Return the knowledge of a drive.

    Limits that ship count only if they are on changes: the others are of one size of drives. Of
    ``types``, the entries of types, that of the drive counts.
    """
    limits, shipped = config["limits"], defaults()["limits"]
    limits = [each for each in limits if limits != shipped or each.get("of") == "change"]
    diagnosis, found, remarks = Diagnosis(config, limits, types=types), {}, []
    with _noted(remarks):  # a type without an entry, which only a file states
        diagnosis = diagnosis.of_type(drive.type) if types and drive.type else diagnosis
    with _noted(remarks):
        found = _examined(drive, diagnosis, remarks)
    every = [each for rows in drive.inspections for _, each in rows]
    dates = sorted((each.date for each in every if each.date), key=instant) or [""]
    return DriveResult(
        **{name: getattr(drive, name) for name in ("breaker", "phase", "type")},
        first=dates[0],
        last=dates[-1],
        operation=max(each.number for each in every),
        records=len(every),
        inspections=len(drive.inspections),
        remarks=[note_of(remark) for remark in remarks],
        **plainly(found),
    )


def _examined(drive: Drive, diagnosis: Diagnosis, remarks: list) -> dict[str, object]:
    """Return the fields of ``DriveResult`` that records show, and add remarks."""
    *before, today = (
        diagnosis.read({motion: own[-_MOST:] for motion, own in _grouped(rows).items()})
        for rows in (*drive.inspections[:-1][:1], drive.inspections[-1])
    )
    remarks += [record.reason for record in today if record.reason]
    used = [each for each in diagnosis.infer(today) if not each.record.reason]
    found = {"rejected": len(today) - len(used), "measured": [*_measured(used)]}
    if not used:
        return found
    limits = [*_states(row for rows in diagnosis.judge(used) for row in rows)]
    with _noted(remarks):  # no usable record in the first inspection
        if before:
            change = diagnosis.compare({"before": before[0], "today": today})
            remarks += [*change.warnings, *change.limitations]
            found["changes"], on_both = change.measured, _states(change.limits)
            limits = [*{each.limit: each for each in (*limits, *on_both)}.values()]
            if change.differences:
                return found
    rows = [row for some in drive.inspections for row in some]
    with _noted(remarks):  # no record counts as new
        if len({each.number for _, each in rows}) >= _LIFE:
            limits = [LimitState(*each) for each in follow_drive(_grouped(rows), used, diagnosis)]
    remarks += [] if limits else [say("no-limit-of-drive")]
    limits.sort(key=lambda each: (STATES.index(each.state), -(each.p_exceeded or 0.0)))
    return found | {"limits": limits, "state": limits[0].state if limits else "unknown"}


def _states(verdicts: Iterable[Verdict]) -> Iterator[LimitState]:
    """Yield the state of each limit by its mean probability over records."""
    for name, values in _grouped((each["name"], each["p_exceeded"]) for each in verdicts).items():
        p = float(np.mean(np.array(values, dtype=float)))  # nan without a value
        state = "due" if p >= _SURE else "ok" if p <= 1.0 - _SURE else "unknown"
        yield LimitState(name, state, p)


def _measured(used: Sequence[Estimate]) -> Iterator[MeasuredValue]:
    """Yield the means of what the records of an inspection show."""
    readings = _grouped(
        ((name, each.record.motion), measured[:2])
        for each in used
        for name, measured in each.measured.items()
        if np.isfinite(measured.value) and each.measured_directly(name)
    )
    for (name, motion), some in readings.items():
        values = np.array(some, dtype=float)
        stroke = np.mean(readings.get(("stroke", motion), [[0.0]]), axis=0)[0]
        mean = float(values[:, 0].mean())
        sd = mean_error([values], name, float(stroke))
        unit = quantities_of(motion, used[0].speeds, ("record",))[name].unit
        quantity = name if motion in name else f"{motion} {name}"  # as in a file of types
        yield MeasuredValue(quantity, unit, mean, sd)
