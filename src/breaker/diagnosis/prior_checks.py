"""Checks of a fitted prior: limits, the records it was made from, each breaker beside the others.

Each finding is a text and whether it is as it should be.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from breaker.common.numerals import in_digits, in_p
from breaker.common.randomness import generator
from breaker.configuration.loading import UNLIKE
from breaker.diagnosis.type_model import FEWEST, ODD
from breaker.diagnosis.type_prior import SWINGING, FittedPrior, swings_back
from breaker.diagnosis.type_records import Recorded
from breaker.model.equations import PRESSED
from breaker.model.limits import Limit
from breaker.model.parameters import NAMES

_DRAWS = 1000
_FAR = 3.0  # prior sd
_LEAST_SUPPORT = 0.9


class Finding(NamedTuple):
    """What a check says: a text, and whether it is as it should be."""

    text: str
    good: bool = True


def check_fitted(
    fitted: FittedPrior,
    recorded: Recorded,
    limits: Sequence[Limit],
    seed: int,
) -> dict[str, list[Finding]]:
    """Return what checks of a fitted prior find, by what is checked.

    Args:
        recorded: The records that it was made from.
        limits: Limits on the state of the drive, of these motions; none are not checked.
    """
    rng = generator(seed, "fit-prior checks")
    theta = fitted.prior.sample(_DRAWS, rng)
    return {
        "breakers": [*_breakers(fitted), *_bounded(fitted)],
        "limits": _far_limits(limits, theta),
        "records in the family": _in_family(recorded),
        "each breaker beside the others": _odd(fitted),
        f"contact pressed, {PRESSED}": [_support(fitted)],
        "openings of the two-spring model": [_stopped(fitted, recorded, seed)],
    }


def _breakers(fitted: FittedPrior) -> list[Finding]:
    """How many there are, and which are left out."""
    source = Finding(f"{len(fitted.names)} breakers")
    if fitted.alone:
        source = Finding(
            "ONE breaker is the only source: its spread from breaker to breaker is a guess. If the "
            "records to be judged are those that the prior was made from, they count twice. The "
            "prior is wider for both; fit it again with records of other breakers of the type",
            good=False,
        )
    text = "nothing is inferred of any of its records, and it is left out; look at them"
    return [source, *(Finding(f"{name}: {text}", good=False) for name in fitted.unfit)]


def _bounded(fitted: FittedPrior) -> list[Finding]:
    """Log-sds and medians that the configuration would refuse."""
    findings = []
    if wide := np.flatnonzero(fitted.spread_seen > fitted.widest).tolist():
        seen = ", ".join(f"{NAMES[i]} {in_digits(fitted.spread_seen[i], 3)}" for i in wide)
        bound = in_digits(fitted.widest.min(), 3)
        text = (
            f"log-sds of {seen} are bounded to {bound}, the largest that the "
            "configuration takes: these records leave the spread next to unknown. Are all breakers "
            "of one type? More breakers of the type tell it"
        )
        findings.append(Finding(text, good=False))
    if fitted.unlike:
        text = (
            f"medians of {', '.join(fitted.unlike)} are bounded, as these records lead to some "
            f"{UNLIKE:.0f} times or a {UNLIKE:.0f}th of the reference drive's: they hardly tell "
            "them"
        )
        findings.append(Finding(text, good=False))
    return findings


def _far_limits(limits: Sequence[Limit], theta: np.ndarray) -> list[Finding]:
    """Each value of a limit, in sds of what the prior expects of its quantity."""
    if not limits:
        return [Finding("none were given beside those of the example; set your own, and fit again")]
    findings = []
    for limit in limits:
        values = limit.evaluate(theta)
        for (name, value, _), column in zip(limit.parts, values.T, strict=True):
            low, middle, high = np.nanquantile(column, [0.16, 0.5, 0.84])
            off = (value - middle) / (high - middle if value > middle else middle - low)
            text = f"{limit.name}: {name} {in_digits(value, 4)} is {abs(off):.1f} sd of the prior"
            text += f" {'above' if off > 0 else 'below'} its median, {in_digits(middle, 4)}"
            findings.append(_near(off, text, "it can hardly be exceeded; widen"))
    return findings


def _in_family(recorded: Recorded) -> list[Finding]:
    """How the records of each breaker fit the family."""
    *others, family = recorded.tried
    findings = [
        Finding(
            f"family {family}, which fits better than {each}, where they have "
            f"{recorded.fit_in_words(each)}"
        )
        for each in others
    ]
    for name, by_motion in recorded.records.items():
        for motion, each in by_motion.items():
            out = sum(answer.misfit for answer in each)
            median = np.median([answer.match.p_value for answer in each])
            text = f"{name}, {motion}: {len(each)} records, median {in_p(median)}"
            said = f"{text}; {out} are out of the family, and left out" if out else text
            findings.append(Finding(said, good=not out))
    return findings


def _odd(fitted: FittedPrior) -> list[Finding]:
    """Of each breaker the parameter in which it is farthest off its type, as in a fleet."""
    if len(fitted.names) < FEWEST:
        return [Finding(f"needs {FEWEST} breakers or more, of which one may be odd")]
    findings = []
    for name, evidence, off in zip(
        fitted.names, fitted.learned.evidence, fitted.learned.off, strict=True
    ):
        k = int(evidence.argmax())
        text = (
            f"{name}: farthest off is {NAMES[k]}, by {100.0 * off[k]:+.0f} %; evidence that it is "
            f"odd {evidence[k]:.1f} nats"
        )
        odd = evidence[k] >= ODD
        said = f"{text}: is it of this type, and in order?" if odd else text
        findings.append(Finding(said, good=not odd))
    return findings


def _near(off: float, text: str, warning: str) -> Finding:
    """What is off by so many sds, and the warning where these are too many."""
    return Finding(text) if abs(off) <= _FAR else Finding(f"{text}: {warning}", good=False)


def _stopped(fitted: FittedPrior, recorded: Recorded, seed: int) -> Finding:
    """Whether the model stops the openings that the workflow would simulate."""
    share = swings_back(fitted.prior, recorded.size, seed)
    text = f"{in_digits(100.0 * share, 2)} % swing back by more than half of their way"
    if share <= SWINGING:
        return Finding(text)
    said = (
        f"{text}: dampers stop these drives, and the model has none. So the workflow's networks of "
        "openings would be of other drives, and its reader rejects such curves"
    )
    if "closing" in recorded.motions:
        said += "; motions: [closing] leaves them out. breaker infer takes openings all the same"
    return Finding(said, good=False)


def _support(fitted: FittedPrior) -> Finding:
    share = float(np.exp(fitted.prior.log_support))
    text = f"in {in_digits(100 * share, 3)} % of the prior"
    if share >= _LEAST_SUPPORT:
        return Finding(text)
    return Finding(f"{text}; what presses the contact is hardly known", good=False)
