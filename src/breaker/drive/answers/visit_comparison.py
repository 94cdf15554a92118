"""Two visits to a drive, as their records were read: compared, in one document."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

from breaker.common.plain_values import plainly
from breaker.common.randomness import generator
from breaker.drive.answers.comparability import judged_today, unlike
from breaker.drive.answers.evidence import AnswerSettings
from breaker.drive.answers.identity import (
    dates_in_words,
    doubts_about,
    samples_of,
    stated_of,
    visits_in_order,
)
from breaker.drive.answers.remounting import slack_between, zero_between
from breaker.drive.answers.visit_changes import compare, measured_changes
from breaker.drive.answers.visit_document import (
    ComparisonSettings,
    RejectedRecord,
    VisitDocument,
    visits_document,
)
from breaker.drive.family.network_files import shipped_networks
from breaker.drive.family.untold import advice_on
from breaker.model.limits import from_list
from breaker.model.parameters import MOTIONS
from breaker.model.quantities import Speed
from breaker.shipped import KINDS


def compared(
    visits: Mapping[str, Sequence],
    speeds: Sequence[Speed],
    settings: AnswerSettings,
    *,
    beyond: float,
    limits: Sequence[Mapping[str, object]] = (),
    advice: Mapping[str, str] | None = None,
) -> VisitDocument:
    """Return the document of a comparison.

    Args:
        visits: Records "before" and "today", as ``read_operations`` returns them.
        speeds: How speeds are defined.
        settings: How answers are drawn.
        beyond: Share beyond which a change counts.
        limits: Entries of the section ``limits`` on which to judge today's visit.
        advice: Where to look first, by name of what has become worse.

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
    stated = {visit: stated_of(each) for visit, each in visits.items()}
    used = {visit: _used(each) for visit, each in visits.items()}
    differences = unlike(measured, found.strokes, stated, found.paces)
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
        dates={visit: dates_in_words(each) for visit, each in used.items()},
        doubts=_warnings(visits),
        remount=zero_between(used),
    )
    return replace(document, advice=advice_on(document.worse, advice or {}))


def _warnings(visits: Mapping[str, Sequence]) -> list[str]:
    """What to say of records before anything else: of their rates and dates, whose they are, and
    which is there twice.
    """
    found = visits_in_order(visits)
    found += [doubt for records in visits.values() for doubt in doubts_about(records)]
    before, today = map(_used, visits.values())
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
