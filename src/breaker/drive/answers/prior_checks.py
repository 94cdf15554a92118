"""Checks of a fitted prior: the records it was made from, each breaker beside the others.

Each finding is a text and whether it is as it should be.
"""

from typing import NamedTuple

import numpy as np

from breaker.common.numerals import in_digits, in_p
from breaker.configuration.loading import UNLIKE
from breaker.drive.answers.type_model import FEWEST, ODD
from breaker.drive.answers.type_prior import FittedPrior
from breaker.drive.answers.type_records import Recorded
from breaker.model.equations import PRESSED
from breaker.model.parameters import NAMES

_LEAST_SUPPORT = 0.9


class Finding(NamedTuple):
    """What a check says: a text, and whether it is as it should be."""

    text: str
    good: bool = True


def check_fitted(fitted: FittedPrior, recorded: Recorded) -> dict[str, list[Finding]]:
    """Return what checks find of a prior and the records it was made from, by what is checked."""
    return {
        "breakers": [*_breakers(fitted), *_bounded(fitted)],
        "records in the family": _in_family(recorded),
        "each breaker beside the others": _odd(fitted),
        f"contact pressed, {PRESSED}": [_support(fitted)],
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


def _support(fitted: FittedPrior) -> Finding:
    share = float(np.exp(fitted.prior.log_support))
    text = f"in {in_digits(100 * share, 3)} % of the prior"
    if share >= _LEAST_SUPPORT:
        return Finding(text)
    return Finding(f"{text}; what presses the contact is hardly known", good=False)
