"""Two visits to a drive, as their records were read: compared, in one document."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from breaker.common.plain_values import plainly
from breaker.common.randomness import generator
from breaker.configuration.definitions import family_of
from breaker.diagnosis.changes import (
    NetworkChanges,
    compare,
    measured_changes,
    usual_scatter,
    visit_error,
    with_explanations,
)
from breaker.diagnosis.estimate import EstimateSettings
from breaker.diagnosis.explanations import explain, otherwise_measured
from breaker.diagnosis.identity import days_of, doubts_about, order_doubts, stated_differences
from breaker.diagnosis.inspection_change import (
    ComparisonSettings,
    InspectionChange,
    RejectedRecord,
    visits_document,
)
from breaker.diagnosis.limits import Evidence, Verdict, judge
from breaker.diagnosis.reading import samples_of
from breaker.diagnosis.remounting import slack_between, zero_between
from breaker.family.network_files import shipped_networks
from breaker.family.sensitivities import shipped_sensitivities
from breaker.family.untold import advice_on
from breaker.model.limits import Limit, from_list
from breaker.model.parameters import MOTIONS, NAMES
from breaker.model.quantities import Speed
from breaker.records.files import printable
from breaker.records.measurements import Measured
from breaker.records.record import Record
from breaker.records.rejections import DISTURBED
from breaker.shipped import KINDS


def compared(
    visits: Mapping[str, Sequence],
    speeds: Sequence[Speed],
    settings: EstimateSettings,
    *,
    beyond: float,
    limits: Sequence[Mapping[str, object]] = (),
    advice: Mapping[str, str] | None = None,
    same_transducer: bool = False,
) -> InspectionChange:
    """Return the document of a comparison.

    Args:
        visits: Records "before" and "today", as ``read_operations`` returns them.
        speeds: How speeds are defined.
        settings: How answers are drawn.
        beyond: Share beyond which a change counts.
        limits: Entries of the section ``limits`` on which to judge today's visit.
        advice: Where to look first, by name of what has become worse.
        same_transducer: Whether both visits have the same transducer and ratio; they also have if
            all their records name one transducer.

    Raises:
        ValueError: If no motion has a usable record in both visits.
    """
    before, today, rejected = _usable(visits)
    misfit, seed = settings.misfit_p_value, settings.seed
    rng = generator(seed, "two visits")
    networks = shipped_networks(*KINDS)
    found = compare(before, today, networks, rng, misfit_p_value=misfit)
    measured = measured_changes(before, today, speeds, beyond)
    entries = from_list(limits, [*before], speeds)
    used = {visit: _used(each) for visit, each in visits.items()}
    found = _explained(found, before, today, used, same_transducer)
    differences = stated_differences(visits) + otherwise_measured(found.explanations)
    differences += slack_between(used, measured)
    # Of visits that were measured differently no change is one of the drive.
    told = replace(found, ratios={}) if differences else found
    document = visits_document(
        found,
        measured,
        differences,
        ComparisonSettings(beyond, seed, misfit),
        records={m: {"before": len(before[m]), "today": len(today[m])} for m in before},
        rejected=rejected,
        limits=plainly(judged_today(told, today, entries, speeds, seed)),
        dates={visit: days_of(each) for visit, each in used.items()},
        doubts=_warnings(visits),
        remount=zero_between(used),
    )
    return replace(document, advice=advice_on(document.worse, advice or {}))


def _explained(
    found: NetworkChanges, before: Mapping, today: Mapping, used: Mapping, same_transducer: bool
) -> NetworkChanges:
    """The comparison with its explanations; a transducer may be the same by its name, too."""
    named = {each.operation.transducer for records in used.values() for each in records}
    about = {"same_transducer": same_transducer or (len(named) == 1 and named != {""})}
    about["sliding"] = family_of(found.family)["contacts"]["sliding"]
    regressions = shipped_sensitivities(found.family)
    return with_explanations(found, explain(before, today, regressions, **about))


def _warnings(visits: Mapping[str, Sequence]) -> list[str]:
    """What to say of records before anything else: of their rates and dates, whose they are, and
    which is there twice.
    """
    found = order_doubts(visits)
    found += [doubt for records in visits.values() for doubt in doubts_about(records)]
    before, today = map(_used, visits.values())
    found += [
        f"{printable(one.operation.file)}, {one.motion}: {remark}"
        for one in (*before, *today)
        for remark in one.raw.remarks_on()
        if getattr(remark, "code", "") in DISTURBED
    ]
    for one in before:
        found += [
            f"{one.operation.file} and {other.operation.file} hold the same samples: they are one "
            "record, and nothing can have changed; name the records of either visit"
            for other in today
            if samples_of(one) == samples_of(other)
        ]
    return list(dict.fromkeys(found))


def _used(records: Sequence) -> list:
    return [each for each in records if not each.reason]


def _usable(visits: Mapping[str, Sequence]) -> tuple[dict, dict, list[RejectedRecord]]:
    """Usable records of motions that both visits have, of either visit, and why others are not."""
    pairs = [(visit, each) for visit, records in visits.items() for each in records]
    pairs.sort(key=lambda pair: MOTIONS.index(pair[1].motion))
    usable: dict[str, dict[str, list]] = {visit: {} for visit in visits}
    for visit, each in pairs:
        if not each.reason:
            usable[visit].setdefault(each.motion, []).append(each.raw)
    motions = [motion for motion in MOTIONS if all(motion in by for by in usable.values())]
    rejected = []
    for visit, each in pairs:
        file = str(each.operation.file)
        reason = each.reason.removeprefix(f"{file}: ")
        if not reason and each.motion not in motions:
            (other,) = visits.keys() - {visit}
            reason = f"the visit {other} has no usable {each.motion} to compare it with"
        if reason:
            rejected.append(RejectedRecord(file, each.motion, visit, reason))
    if not motions:
        raise ValueError(_nothing(rejected))
    before, today = ({motion: by[motion] for motion in motions} for by in usable.values())
    return before, today, rejected


def _nothing(rejected: Sequence[RejectedRecord]) -> str:
    """Why nothing can be compared, and what to do."""
    reasons = "".join(
        f"\n  {each.visit}: {each.file} ({each.motion}): {each.reason}" for each in rejected
    )
    return (
        "nothing can be compared: no motion has a usable record in both visits. Name a closing of "
        "each, or an opening, all of one drive; breaker inspect FILE says how a file can be read"
        f"{reasons}"
    )


def judged_today(
    found: NetworkChanges,
    today: Mapping[str, Sequence[Record]],
    limits: Sequence[Limit],
    speeds: Sequence[Speed],
    seed: int,
) -> list[Verdict]:
    """Return what ``judge`` does of limits at the second of two visits.

    Of what records show, the mean of the visit is judged; of changes of parameters, those between
    both visits. A comparison does not tell quantities of the model.
    """
    read = {motion: [raw.measured(speeds) for raw in raws] for motion, raws in today.items()}
    visits = _Visits(found, read)
    return judge(limits, lambda limit, name: limit.read(visits, name), seed, "visits")


@dataclass(frozen=True)
class _Visits:
    """What two visits tell of a quantity of a limit, by the limit's source."""

    found: NetworkChanges
    read: Mapping[str, Sequence[Mapping[str, Measured]]]

    def of_change(self, _limit: Limit, name: str) -> Evidence:
        if len(self.found.ratios) != 1:
            return Evidence(reason="changes of parameters are not told")
        (ratios,) = self.found.ratios.values()
        return Evidence(draws=100.0 * (ratios[:, NAMES.index(name)] - 1.0))

    def of_model(self, _limit: Limit, _name: str) -> Evidence:
        return Evidence(reason="of the model: breaker infer tells it")

    def of_record(self, limit: Limit, name: str) -> Evidence:
        records = self.read[limit.motion]
        shown = [each[name] for each in records]
        visit = np.array([each[:2] for each in shown if np.isfinite(each.value)], float)
        if not len(visit):
            return Evidence(reason=shown[0].reason)
        mean = float(visit[:, 0].mean())
        stroke = float(np.nanmean([each["stroke"].value for each in records] or np.nan))
        return Evidence(mean, visit_error([visit], usual_scatter(name, mean, stroke)))
