"""What networks of a family infer of each operation of a drive, and what its records show.

Parameters and the time of touch or separation are inferred, from both motions of an operation where
both are there. Everything else is measured; what needs the touch takes the inferred one where no
contact was timed. A prior of one's own, facts and a timed contact weigh the draws of the network.
"""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from itertools import tee

import numpy as np

from breaker.common.randomness import generator, systematic
from breaker.diagnosis.draw_weights import (
    SURPRISING,
    apart,
    contradicted,
    possible,
    surprise_of,
    weights_of,
)
from breaker.diagnosis.estimate import DriveRecord, Estimate, EstimateSettings, Given
from breaker.family.inputs import mean_with_scatter
from breaker.family.membership import choose_family
from breaker.family.networks import StateDraws, StateNetwork
from breaker.model.parameters import NAMES, Size
from breaker.model.quantities import Speed

_ROUNDS = (4_000, 40_000)  # draws that are weighed: more if the first are too few
_LEAST, _ENOUGH = 100.0, 400.0  # effective size, below which an answer is not resolved; of a round
_MORE = 9  # rounds beside the largest, while so many more could resolve an answer
_POSSIBLE = 0.2  # share of draws that is enough where they are not weighed


def infer_drive(
    records: Sequence[DriveRecord],
    families: Iterable[StateNetwork],
    given: Given,
    speeds: tuple[Speed, ...],
    settings: EstimateSettings,
) -> list[Estimate]:
    """Infer all records of a drive, in their order.

    Args:
        families: Networks of levels, the narrowest family first: ``choose_family`` finds the one
            that answers, by the median record of each motion. A family that denies a contact's
            time gives way to one that holds it.
        speeds: How speeds are defined.
        settings: How answers are drawn.
    """
    usable = [record for record in records if not record.reason]
    if not usable:
        return [Estimate(record) for record in records]
    families, again = tee(families)
    inferred = _in_family(usable, families, given, speeds, settings)
    if any(map(_contact_denied, inferred)):
        others = [each for each in again if each is not inferred[0].levels]
        new = _in_family(usable, others, given, speeds, settings) if others else inferred
        if not any(each.misfit or _contact_denied(each) for each in new):
            inferred = new
    told = [replace(each, draws=None) if each.unresolved else each for each in inferred]
    found = {id(answer.record): _measured(answer) for answer in told}
    return [found.get(id(record), Estimate(record)) for record in records]


def _in_family(
    usable: Sequence[DriveRecord],
    families: Iterable[StateNetwork],
    given: Given,
    speeds: tuple[Speed, ...],
    settings: EstimateSettings,
) -> list[Estimate]:
    """Infer records in the family that they give most evidence of."""
    levels, matches, _fits = choose_family(
        families,
        lambda levels: [(each.motion, levels.match(each.motion, each.seen)) for each in usable],
        settings.misfit_p_value,
    )
    groups: dict[tuple, list[Estimate]] = {}
    for record, (_, match) in zip(usable, matches, strict=True):
        misfit = match.p_value < settings.misfit_p_value
        key = record.operation.number, record.operation.breaker, record.operation.phase
        groups.setdefault(key, []).append(Estimate(record, levels, match, misfit, speeds=speeds))
    inferred = []
    for group in groups.values():
        inferred += _together([each for each in group if not each.misfit], given, settings)
        inferred += [each for each in group if each.misfit]
    return inferred


def _contact_denied(answer: Estimate) -> bool:
    """Whether a recorded contact is not where any or enough of the draws have it."""
    denied = answer.unresolved or abs(answer.surprise) > SURPRISING
    return answer.record.timed and not answer.misfit and bool(denied)


def infer_means(
    answers: Sequence[Estimate], given: Given, settings: EstimateSettings
) -> list[list[Estimate]]:
    """Infer each pole from the means of its records, which say more than one of them.

    What operations differ by is noise of a mean (``inputs.mean_with_scatter``).

    Args:
        answers: What ``infer_drive`` returns; those without draws are left out.
        given, settings: As of ``infer_drive``.

    Returns:
        For each pole of which a motion has several records, an answer for each of its motions.
    """
    poles: dict[tuple, dict[str, list[Estimate]]] = {}
    for each in answers:
        if each.draws is not None:
            pole = each.record.operation.breaker, each.record.operation.phase
            poles.setdefault(pole, {}).setdefault(each.record.motion, []).append(each)
    several = [by for by in poles.values() if max(map(len, by.values())) > 1]
    return [_together([_mean_of(each) for each in by.values()], given, settings) for by in several]


def _mean_of(answers: Sequence[Estimate]) -> Estimate:
    """The mean of records of one motion as one record, with the mean of the contact's times."""
    first, records = answers[0], [each.record for each in answers]
    mean = mean_with_scatter([each.raw for each in records], first.levels.bases[records[0].motion])
    shape = mean.units._replace(way=mean.seen.way[0], present=mean.seen.present[0])
    contact = records[0].raw.contact._replace(time=np.nan, sd=np.nan)
    if timed := [each for each in records if each.timed]:
        after = np.array([each.switched for each in timed])
        sd = np.hypot(np.mean([each.raw.contact.sd for each in timed]), after.std())
        contact = contact._replace(
            time=records[0].tenth + after.mean(), sd=sd / np.sqrt(len(timed))
        )
    raw = replace(records[0].raw, contact=contact)
    record = replace(records[0], raw=raw, shape=shape, seen=mean.seen)
    return Estimate(record, first.levels, first.match, speeds=first.speeds, records=len(records))


def _together(
    within: Sequence[Estimate], given: Given, settings: EstimateSettings
) -> list[Estimate]:
    """Infer one operation from its records in the family; each by itself if they contradict."""
    if not within:
        return []
    rng = generator(settings.seed, "motions", within[0].record.operation.number)
    if len(within) > 1 and (said := apart(within, given, rng)):
        split = [replace(each, remarks=(said,)) for each in within]
        return [new for each in split for new in _inferred([each], given, settings)]
    return _inferred(within, given, settings)


def _inferred(
    within: Sequence[Estimate], given: Given, settings: EstimateSettings
) -> list[Estimate]:
    """Infer one operation from its records, which are in the family."""
    levels, first = within[0].levels, within[0].record
    rng = generator(settings.seed, "levels", first.operation.number)
    seen = {answer.record.motion: answer.record.seen for answer in within}
    weighed = bool(given.prior or given.known) or any(each.record.timed for each in within)
    rounds = _ROUNDS if weighed else (settings.draws, _ROUNDS[-1])
    tries = [(n, given.size) for n in rounds]
    if given.prior is not None:  # it may be wider than the family's, whose draws then lack its ends
        tries.append((_ROUNDS[-1], None))
    effective = -1.0
    for n, size in tries:
        found = levels.draw(seen, n, rng, size=size)
        left, new, shares = _weighed(within, found, given, size)
        if left > effective:
            effective, draws, trial, weights, best = left, found, new, shares, size
        if effective >= (_ENOUGH if weighed else _POSSIBLE * n):
            break
    for more in range(_MORE if weighed else 0, 0, -1):  # a contact at the edge of what draws expect
        if effective >= _LEAST or effective * (1.0 + more * rounds[-1] / weights.size) < _LEAST:
            break
        draws = draws.joined(levels.draw(seen, rounds[-1], rng, size=best))
        effective, trial, weights = _weighed(within, draws, given, best)
    unresolved = ""
    if effective < min(_LEAST, _POSSIBLE * weights.size):
        drawn = f"{effective:.0f} of {weights.size} draws"
        unresolved = f"effective size {drawn}, {_LEAST:.0f} are needed"
    if effective and (weighed or effective < len(weights) - 0.5):
        draws = draws.of(systematic(weights, settings.draws, rng.random(), rng))
    inferred = [
        replace(
            each,
            draws=draws if effective else None,
            effective_size=effective,
            contact_known=given.prior is not None or bool(given.known),
            unresolved=unresolved,
            surprise=surprise_of(each),
        )
        for each in trial
    ]
    said = contradicted(inferred, given)
    return [
        _beside(each, given, [*each.remarks, *(said if not k else [])])
        for k, each in enumerate(inferred)
    ]


def _weighed(
    within: Sequence[Estimate], draws: StateDraws, given: Given, size: Size | None
) -> tuple[float, list[Estimate], np.ndarray]:
    """The effective size of draws, the answers with them, and their weights, at most 1."""
    new = [replace(each, draws=draws, motions=tuple(draws.release)) for each in within]
    shares = np.where(possible(new), weights_of(new, given, size), 0.0)
    shares /= shares.max() or 1.0  # those that are possible may be of any smallness
    left = float(shares.sum() ** 2 / np.square(shares).sum()) if shares.any() else 0.0
    return left, new, shares


def _beside(answer: Estimate, given: Given, remarks: Sequence[str]) -> Estimate:
    """Hold an answer against what was given beside the record."""
    if abs(answer.surprise) > SURPRISING:
        remarks = [
            *remarks,
            f"the contact's time is {answer.surprise:+.1f} sd from what the curve leads to expect: "
            "it is not used. Is it of this record, of this phase, and in its time?",
        ]
    answer = replace(answer, remarks=tuple(remarks))
    if answer.draws is None:
        return answer
    sds = given.prior_log_sds(answer.levels)
    left = np.log(answer.draws.theta).std(axis=0) / sds
    answer = replace(answer, prior_share=np.square(left))
    if given.size is None:
        return answer
    from scipy.special import chdtrc

    prior = given.prior_of(answer.levels)
    sds, square = prior.distances(np.median(answer.draws.theta, axis=0))
    return replace(answer, prior_sds=sds, prior_p_value=float(chdtrc(len(NAMES), square)))


def _measured(answer: Estimate) -> Estimate:
    """Read what the record shows, at the inferred touch where none was timed."""
    raw = answer.record.raw
    remarks = (*raw.remarks_on(), *answer.remarks)
    return replace(answer, measured=raw.measured(answer.speeds, answer.contact), remarks=remarks)
