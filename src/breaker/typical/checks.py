"""Checks of a fitted prior: limits, the curves it was made from, each breaker by the others.

Each finding is a text and whether it is as it should be.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from breaker.mechanism import NAMES, Limit
from breaker.model import Model, distance, generator, principal_components
from breaker.posterior import share_inside
from breaker.typical.fitted import FittedPrior

__all__ = ["Check", "Finding", "check_fitted"]

_DRAWS = 1000
_FAR = 3.0  # prior sd
_COMPONENTS = 10
_UNLIKE = 0.01  # p-value below which a record is unlike the prior's
_LEAST_SUPPORT = 0.9
_LEAST_BREAKERS = 3  # of which one can be left out


@dataclass(frozen=True)
class Finding:
    """What a check says.

    Attributes:
        text: In words.
        good: Whether it is as it should be.
    """

    text: str
    good: bool = True


@dataclass(frozen=True)
class Check:
    """A check and its findings.

    Attributes:
        name: What was checked.
        findings: One or more.
    """

    name: str
    findings: tuple[Finding, ...]


def check_fitted(
    fitted: FittedPrior,
    models: Mapping[str, Model],
    records: Mapping[str, Mapping[str, np.ndarray]],
    limits: Sequence[Limit],
    seed: int,
) -> list[Check]:
    """Check a fitted prior.

    Args:
        models: Joint model of each motion, with this prior.
        records: Records ``(n, t)``, mm, by breaker and motion.
        limits: Limits on the state of the drive, of these motions; none are not checked.
    """
    rng = generator(seed, "fit-prior checks")
    theta = fitted.prior.sample(_DRAWS, rng)
    return [
        Check("breakers", (_source(fitted), *_unfit(fitted))),
        Check("limits", tuple(_far_limits(limits, theta)) or (_NO_LIMITS,)),
        Check("curves in the prior's band", tuple(_in_band(models, records, rng))),
        Check("each breaker by the others", tuple(_left_out(fitted, seed))),
        Check("contact pressed, f > k_a L", (_support(fitted),)),
    ]


_NO_LIMITS = Finding("none were given beside those of the example; set your own, and fit again")


def _source(fitted: FittedPrior) -> Finding:
    if not fitted.alone:
        return Finding(f"{len(fitted.fits)} breakers")
    return Finding(
        "ONE breaker is the only source: its spread from breaker to breaker is a guess. If the "
        "records to be judged are those that the prior was made from, they count twice. The prior "
        "is wider for both; fit it again with records of other breakers of the type",
        good=False,
    )


def _unfit(fitted: FittedPrior) -> list[Finding]:
    text = "no parameters that fit its records were found, and it is left out; look at them"
    return [Finding(f"{name}: {text}", good=False) for name in fitted.unfit]


def _far_limits(limits: Sequence[Limit], theta: np.ndarray) -> list[Finding]:
    """Each value of a limit, in sds of what the prior expects of its quantity."""
    findings = []
    for limit in limits:
        values = limit.evaluate(theta)
        for (name, value, _), column in zip(limit.parts, values.T, strict=True):
            low, middle, high = np.nanquantile(column, [0.16, 0.5, 0.84])
            off = (value - middle) / (high - middle if value > middle else middle - low)
            text = f"{limit.name}: {name} {value:.4g} is {abs(off):.1f} sd of the prior"
            text += f" {'above' if off > 0 else 'below'} its median, {middle:.4g}"
            if good := abs(off) <= _FAR:
                findings.append(Finding(text))
            else:
                findings.append(Finding(f"{text}: it can hardly be exceeded; widen", good))
    return findings


def _in_band(
    models: Mapping[str, Model],
    records: Mapping[str, Mapping[str, np.ndarray]],
    rng: np.random.Generator,
) -> list[Finding]:
    """How many samples lie in the 95 % band of the prior's records, and how unlike each record is.

    The p-value is the share of the prior's records that are as far from their middle.
    """
    findings = []
    for motion, model in models.items():
        theta = model.prior.sample(_DRAWS, rng)
        onset = model.sensor.onset_sd * rng.standard_normal(_DRAWS)
        exact = model.curves(np.column_stack([theta, onset])[:, : len(model.names)])
        drawn = model.sensor.corrupt(exact, rng)
        low, high = np.quantile(drawn, [0.025, 0.975], axis=0)
        mean, weights = principal_components(exact, model.sensor, _COMPONENTS)
        farthest = distance(drawn, mean, weights)
        for name, by_motion in records.items():
            if motion not in by_motion:
                continue
            each = by_motion[motion]
            inside = share_inside(each, low, high).mean()
            off = distance(np.where(np.isnan(each), mean, each), mean, weights)
            p_values = (1 + (farthest >= off[:, None]).sum(axis=1)) / (1 + _DRAWS)
            unlike = int((p_values < _UNLIKE).sum())
            findings.append(
                Finding(
                    f"{name}, {motion}: {100 * inside:.0f} % of the samples of {len(each)} records "
                    f"in the 95 % band, least p {p_values.min():.2g}"
                    + (f"; {unlike} records are unlike the prior's" if unlike else ""),
                    good=not unlike,
                )
            )
    return findings


def _left_out(fitted: FittedPrior, seed: int) -> list[Finding]:
    """Each breaker's parameters, in sds of the prior that the others make and of its own."""
    count = len(fitted.fits)
    if count < _LEAST_BREAKERS:
        return [Finding(f"needs {_LEAST_BREAKERS} breakers or more, of which one is left out")]
    findings = []
    for name in fitted.fits:
        others = fitted.without(name, generator(seed, "fit-prior without", name)).prior
        mean, sd = fitted.own(name)
        sds = np.hypot(others.log_sds, sd * fitted.reference.log_sds)
        off = np.log(fitted.reference.destandardise(mean) / others.medians) / sds
        worst = int(np.abs(off).argmax())
        text = f"{name}: farthest off is {NAMES[worst]}, by {off[worst]:+.1f} sd"
        if good := abs(off[worst]) <= _FAR:
            findings.append(Finding(text))
        else:
            findings.append(Finding(f"{text}: is it of this type, and in order?", good))
    return findings


def _support(fitted: FittedPrior) -> Finding:
    share = float(np.exp(fitted.prior.log_support))
    text = f"in {100 * share:.3g} % of the prior"
    if share >= _LEAST_SUPPORT:
        return Finding(text)
    return Finding(f"{text}; what presses the contact is hardly known", good=False)
