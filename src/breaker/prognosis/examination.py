"""The examination of one drive of a fleet: its last visit is inferred; its life is followed where
there are many records, its first and last visit are compared where there are few.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from datetime import timedelta
from typing import NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

from breaker.common.plain_values import to_json
from breaker.configuration.loading import defaults
from breaker.diagnosis.changes import QuantityChange
from breaker.diagnosis.estimate import Estimate
from breaker.diagnosis.limits import VERDICTS, Verdict
from breaker.diagnosis.session import Diagnosis
from breaker.diagnosis.type_prior import TypeDraws, draws_of
from breaker.model.parameters import MOTIONS, NAMES
from breaker.model.sensor import grid
from breaker.prognosis.drive_document import (
    DIFFERENT,
    UNJUDGED,
    DriveChange,
    DriveDocument,
    Due,
    Shown,
)
from breaker.prognosis.life_records import Event
from breaker.prognosis.life_results import follow_curves
from breaker.prognosis.life_tables import change_table, decided
from breaker.prognosis.limit_states import STATES
from breaker.prognosis.members import Member
from breaker.records.curves import read_curves
from breaker.records.dates import instant
from breaker.records.files import printable
from breaker.records.folder import known_of
from breaker.records.grid import Grid

_MOST = 20  # operations of a visit that are read: more say no more of the drive
_STILL = 0.05  # probability of no change, below which a parameter has changed
_YEAR = 365.25  # days


class Examined(NamedTuple):
    """What is known of one drive, and draws of its parameters by operation, ``(o, d, p)``."""

    document: DriveDocument
    theta: np.ndarray


def examine(
    member: Member, config: Mapping, types: Mapping[str, Mapping] | None = None
) -> Examined:
    """Examine a drive as ``breaker infer`` and ``breaker compare`` do, or follow its life.

    Limits on values, not on changes, count only where they are other than those that ship, which
    are an example for one size. A prior, a size and known values are of one type or drive, and are
    not taken.

    Args:
        member: The drive.
        config: The whole configuration.
        types: Entries of types, of which that of the drive counts.
    """
    visits, unknown = member.visits(), []
    shipped = config["limits"] == defaults()["limits"]
    limits = [e for e in config["limits"] if not shipped or e.get("of") == "change"]
    assessment = Diagnosis(config, limits, types=types or {})
    if types and member.type:
        try:
            assessment = assessment.of_type(member.type)
        except ValueError as error:  # a type that only a file states, and the table does not
            unknown = [str(error)]
    records = assessment.read(member.only(visits[-1][-_MOST:]))
    answers = assessment.infer(records)
    used = [each for each in answers if not each.record.reason]
    document = _about(member, visits, answers)
    document = replace(document, trust=[*document.trust, *unknown])
    nothing = np.empty((0, config["endurance"]["draws"], len(NAMES)))
    if not used:
        return Examined(document, nothing)
    try:
        both = {"today": records}
        if len(visits) > 1:
            before = assessment.read(member.only(visits[0][-_MOST:]))
            both = {"before": before, "today": records}
        if len(member.numbers) >= config["fleet"]["followed"]:
            found = _followed(member, used, assessment)
            document = replace(document, **found | _unlike_life(member, both, assessment))
        elif len(visits) > 1:
            document = replace(document, **_compared(member, both, assessment))
        else:
            rows = [row for verdicts in assessment.judge(used) for row in verdicts]
            said = [] if rows else ["one visit, and no limit on what it shows"]
            trust = [*document.trust, *said]
            document = replace(document, how="visit", trust=trust, **_judged(rows))
    except ValueError as error:  # what one drive lacks stops no other
        document = replace(document, trust=[str(error).splitlines()[0]])
    if document.state == STATES[0]:
        document = replace(document, state=UNJUDGED)
    drawn = draws_of(used)
    return Examined(document, np.array(drawn) if drawn else nothing)


def stored(examined: Sequence[Examined]) -> xr.Dataset:
    """Return what is known of drives as a dataset: documents, and draws in few numbers.

    Returns:
        Dataset over ``drive``: ``document`` (JSON), ``count``, operations that were inferred,
        ``mean (drive, parameter)`` of the logarithms of their draws, ``squares (drive, parameter,
        parameter)``, the sum of products of the deviations of operations from it, and some draws,
        ``theta (drive, draw, parameter)``; nan of a drive of which nothing was inferred.
    """
    nothing = np.full((1, 1, len(NAMES)), np.nan)
    found = TypeDraws.of(each.theta if len(each.theta) else nothing for each in examined)
    over = ("drive", "parameter")
    documents = np.array([to_json(each.document) for each in examined], dtype=str)
    return xr.Dataset(
        {
            "document": ("drive", documents),
            "count": ("drive", np.array([len(draws) for _, draws in examined])),
            "mean": (over, found.mean),
            "squares": ((*over, "other"), np.nan_to_num(found.squares)),
            "theta": (("drive", "draw", "parameter"), found.theta.astype(np.float32)),
        },
        {"parameter": list(NAMES)},
    )


def _about(member: Member, visits: Sequence, answers: Sequence[Estimate]) -> DriveDocument:
    """What is known without any comparison."""
    dates, used = member.dates, [each for each in answers if not each.record.reason]
    out = [each for each in used if each.misfit]
    trust = ["no record of the last visit can be used"] if not used else []
    if out:
        odd = " and ".join(dict.fromkeys(each.record.motion for each in out))
        trust = [f"{len(out)} of {len(used)} records are out of the family ({odd})"]
    shown: dict[tuple[str, str], list[float]] = {}
    for each in used:
        for name, value in each.measured.items():
            if np.isfinite(value.value) and each.measured_directly(name):
                shown.setdefault((name, each.record.motion), []).append(float(value.value))
    return DriveDocument(
        breaker=member.breaker,
        phase=member.phase,
        type=member.type,
        records=sum(map(len, member.operations.values())),
        visits=len(visits),
        operation=member.numbers[-1],
        first=min(dates.values(), default="", key=instant),
        last=max(dates.values(), default="", key=instant),
        trust=trust,
        rejected=[each.record.reason for each in answers if each.record.reason],
        measured=[Shown(*of, float(np.mean(values))) for of, values in shown.items()],
        zones={each.name: each.words for answer in used[:1] for each in answer.speeds},
        spread=[
            Shown(*of, float(100.0 * np.std(values, ddof=1) / abs(np.mean(values))))
            for of, values in shown.items()
            if len(values) > 1 and np.mean(values)
        ],
        family=used[0].levels.settings["family"] if used else "",
        p_value=min((each.match.p_value for each in used), default=None),
        file=printable(answers[0].record.operation.file) if answers else "",
    )


def _judged(rows: Sequence[Verdict]) -> dict:
    """State and verdicts of limits that were judged: of several records, the worst of each."""
    worst: dict[str, str] = {}
    for row in rows:
        worst[row.name] = max(worst.get(row.name, "pass"), row.verdict, key=VERDICTS.index)
    failed = [name for name, verdict in worst.items() if verdict == "fail"]
    state = "now" if failed else "healthy" if "pass" in worst.values() else "unknown"
    return {"limits": worst, "state": state, "due": Due(failed[0] if failed else None)}


def _compared(member: Member, visits: Mapping[str, Sequence], assessment: Diagnosis) -> dict:
    """First and last visit; what goes on as it did reaches a limit on a date."""
    found = assessment.compare(visits)
    rows, unlike = [*found.measured, *found.inferred], [each.words for each in found.differences]
    either = [e for e in [found.explained] if e.code == "explained-by-setup"]
    said = {"how": "visits", "differences": unlike or either}
    said |= _judged(found.limits)
    for key, some in {"changed": found.reported, "since": found.measured}.items():
        said[key] = [DriveChange(row.name, row.motion, row.change) for row in some]
    said["trust"] = [*found.doubts, *found.limitations]
    if said["differences"]:  # of no trend; beyond a limit today it is whatever was before
        now = said["state"] == "now" and not unlike
        return said | {"changed": []} | ({} if now else {"state": DIFFERENT, "due": Due()})
    dates = [member.dates.get(each) for each in (member.numbers[0], member.numbers[-1])]
    if said["state"] == "now" or not all(dates):
        return said
    first, last = map(instant, dates)
    due = [(_left(limit, rows), limit.name) for limit in found.limits]
    left, name = min(due, default=(np.inf, ""))
    days = left * ((last - first) / timedelta(days=1))
    if days < _YEAR * assessment.config["planning"]["years"]:
        date = (last + timedelta(days=days)).date().isoformat()
        said |= {"state": "plan", "due": Due(name, date)}
    return said


def _unlike_life(member: Member, visits: Mapping[str, Sequence], assessment: Diagnosis) -> dict:
    """What is told instead of a life whose last visit was measured differently from its first,
    without an event that says so; nothing where the two cannot be compared.
    """
    rows = (each for some in member.operations.values() for each in some if each.event)
    more = assessment.config["endurance"]["events"]
    if len(visits) < 2 or any(Event.from_text(each.event, more).transducer for each in rows):
        return {}
    try:
        found = replace(assessment, limits=()).compare(visits)
    except ValueError:  # such as a first visit without a usable record: the life stands without it
        return {}
    said = [each.words for each in found.differences]
    told = {"state": DIFFERENT, "due": Due(), "changed": [], "differences": said}
    return told if said else {}


def _left(limit: Verdict, rows: Sequence[QuantityChange]) -> float:
    """Time until a changed quantity is at a limit, in times between the visits; inf if never."""
    if len(limit.parts) != 1 or limit.verdict == "fail":
        return np.inf
    (part,) = limit.parts
    of = [e for e in rows if e.changed and (e.name, e.motion) == (part.quantity, limit.motion)]
    if not of or part.value is None:
        return np.inf
    before = of[0].before if of[0].measured else 0.0  # of a parameter, its change
    step, (low, high) = part.value - before, part.bounds
    bound = high if step > 0.0 else low
    return np.inf if bound is None or step == 0.0 else max((bound - part.value) / step, 0.0)


def _followed(member: Member, used: Sequence[Estimate], assessment: Diagnosis) -> dict:
    """The life of a drive, as the workflow follows that of a single one."""
    config, speeds, levels = assessment.config, used[0].speeds, used[0].levels
    usual = np.exp(levels.usual[1, 0])
    longer = np.median([each.record.shape.duration for each in used]) / usual
    sensor, form = config["sensor"], config["endurance"]["format"]
    times = longer * grid(**{key: sensor[key] for key in ("start", "stop", "samples")})
    curves = {
        motion: read_curves(each, form, Grid(times), motion, speeds=speeds)
        for motion, each in member.operations.items()
    }
    rows = [each for motion in MOTIONS for each in member.operations.get(motion, ())]
    texts, conditions = known_of(rows, member.numbers)
    life = follow_curves(
        curves,
        assessment.limits_on(used, curves),
        {"trend": config["trend"], "seed": config["seed"]}
        | {"misfit_p_value": config["endurance"]["misfit_p_value"]},
        events=Event.by_operation(texts, config["endurance"]["events"]),
        conditions=conditions,
    )
    stands, decisions = decided(life, curves, config["planning"])
    row, since = decisions.iloc[-1], change_table(life).iloc[-1]
    states = stands.attrs["states"]
    by_limit = zip(life.limit.values.tolist(), stands.state.values[-1], strict=True)
    names = [name for name in NAMES if since[f"{name}_unchanged"] < _STILL]
    ends = [[float(since[f"{name}{end}"]) for end in ("_5", "", "_95")] for name in names]
    numbers = (None if pd.isna(e) else float(e) for e in (row.service_by, row.operations_left))
    due = Due(row.limit, row.get("service_by_date") or None, *numbers) if row.limit else Due()
    said = "" if life.attrs["family"] else "parameters are withheld: of no family, or contradicted"
    return {
        "how": "life",
        "state": row.state,
        "due": due,
        "limits": {name: states[state] for name, state in by_limit},
        "changed": [DriveChange(name, "", each) for name, each in zip(names, ends, strict=True)],
        "trust": [said] if said else [],
    }
