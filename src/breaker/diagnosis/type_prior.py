r"""The prior of a type of breaker, learned from records of some of its drives.

Drives of one type share levers and dampers, and so the error of what networks infer from them. More
drives do not reduce this error, and the posterior of a drive is far wider than the spread of its
type. Therefore the model compares drives by the means ``x_b`` of their draws (logarithms), whose
own error shows from operation to operation: ``x_b = m + u_b + e_b`` with ``u_b ~ N(0,
diag(tau^2))``. In a small share of the drives one parameter deviates by more. Expectation
maximisation estimates m and tau from the drives that do not deviate. The evidence that a drive
deviates is the logarithm of the likelihood ratio.
"""

import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from itertools import chain, islice
from pathlib import Path
from typing import NamedTuple, Self

import numpy as np

from breaker.common.randomness import generator
from breaker.common.text import bare, usual_spelling
from breaker.configuration.definitions import family_of
from breaker.configuration.loading import defaults
from breaker.diagnosis.estimate import DriveRecord, Estimate
from breaker.diagnosis.reading import without_copies
from breaker.diagnosis.session import Diagnosis
from breaker.diagnosis.words import say
from breaker.family.inputs import shrunk_variance
from breaker.family.membership import choose_family
from breaker.family.networks import StateNetwork
from breaker.model.curves import travel
from breaker.model.parameters import MOTIONS, NAMES, Size
from breaker.model.prior import Prior
from breaker.model.sensor import Sensor
from breaker.records.files import printable
from breaker.records.folder import is_folder, list_fleet, list_operations
from breaker.records.operations import MANIFEST, Operation
from breaker.shipped import HELD_BACK

FEWEST = 5
"""Drives of a type from which on one may deviate: of fewer, the spread is hardly known."""

DEVIATES = 7.0
"""Evidence that a drive deviates, nats: odds of 1,100, as a fleet has hundreds of drives."""

_DEVIATING = 0.02  # share of drives that deviate, as before any record
_DEVIATION = 0.3  # sd of a deviation, in logarithms: the largest usual wear
_LEAST_SPREAD = 0.1  # expected spread of a type, in log-sds of the prior of all drives
_KNOWN = 4.0  # drives or operations that an expected variance counts for
_REPEATED = 0.2  # expected variance between operations, as a share of the posterior's
_WIDER = 1.5  # factor on that variance: operations of one day share a part that it lacks
_SHARED = 0.6  # share of the posterior's variance that all drives of a type have in common
_DRAWS = 500  # kept for each drive: quantiles of 5 % within 1 % of the probability
_ROUNDS, _SETTLED = 500, 1e-7  # of expectation maximisation; its last step, far below any spread

_MOST = 20  # records of one breaker and motion: more reduce no error that they share
WIDEST = 1.0
"""Largest log-sd of a prior, the bound of the configuration: a factor of 2.7 to either side."""

_WEAR_SDS = 3.0  # the largest usual wear, in sds of the room for it
_SHORT = 0.05  # share of the records that the grid may exceed, and that the workflow then rejects
_QUIET = 0.25  # quantile of the records' noise: half of them may follow a motion, and still ring
_LEFT_OUT = 0.02  # mm at size 1: what no model describes in records of little noise
_OPENINGS = 400  # simulated: 20 % of them is known to 2 %


class TypeDraws(NamedTuple):
    """Draws of the drives of a type.

    Attributes:
        mean: Mean of the logarithms of the parameters over all operations, ``(n, p)``.
        squares: Sum of products of the operations' deviations from it, ``(n, p, p)``.
        count: Operations, ``(n,)``.
        theta: Posterior draws, ``(n, d, p)``.
    """

    mean: np.ndarray
    squares: np.ndarray
    count: np.ndarray
    theta: np.ndarray

    @classmethod
    def of(cls, drives: Iterable[Sequence[np.ndarray]]) -> Self:
        """Summarise the draws ``(d, p)`` of one or more operations of each drive."""
        rows = []
        for operations in drives:
            means = np.array([np.log(theta).mean(axis=0) for theta in operations])
            off = means - means.mean(axis=0)
            theta = np.concatenate(operations)
            theta = theta[np.linspace(0, len(theta) - 1, _DRAWS).astype(int)]
            rows.append((means.mean(axis=0), off.T @ off, len(operations), theta))
        return cls(*map(np.array, zip(*rows, strict=True)))

    @property
    def posterior(self) -> np.ndarray:
        """Mean covariance of the logarithms of a drive's draws, ``(p, p)``."""
        return np.mean([np.cov(np.log(theta).T) for theta in self.theta], axis=0)

    def error(self) -> np.ndarray:
        """Return the covariance of each mean, from the scatter of operations, ``(n, p, p)``."""
        squares, seen = self.squares.sum(axis=0), float((self.count - 1).sum())
        one = _WIDER * shrunk_variance(squares, seen, _REPEATED * self.posterior, _KNOWN)
        return one / self.count[:, None, None]


def draws_of(estimates: Iterable[Estimate]) -> list[np.ndarray]:
    """Return the draws ``(d, p)`` of each operation; two motions may share them."""
    return [*{id(e.draws): e.draws.theta for e in estimates if e.draws}.values()]


@dataclass(frozen=True, eq=False)
class TypeOfBreaker:
    """A type of breaker, learned from drives.

    Attributes:
        medians: Medians of its drives, ``(p,)``.
        spread, known, shared: Log-sds, ``(p,)``: spread of the drives; uncertainty of the medians,
            of which few drives inform; error that the drives share.
        evidence: Evidence that a parameter of a drive deviates, nats, ``(n, p)``; -inf below
            ``FEWEST`` drives.
        off: Distance of a drive's mean from the median, share, ``(n, p)``.
    """

    medians: np.ndarray
    spread: np.ndarray
    known: np.ndarray
    shared: np.ndarray
    evidence: np.ndarray
    off: np.ndarray

    @cached_property
    def log_sds(self) -> np.ndarray:
        """Log-sds of all parts together, ``(p,)``."""
        return np.sqrt(np.sum(np.square((self.spread, self.known, self.shared)), axis=0))


def learn_type(drawn: TypeDraws, usual: np.ndarray) -> TypeOfBreaker:
    """Learn a type from its drives; from one drive, take the spread of drives of any type.

    Args:
        usual: Log-sds of the prior of drives of any type and one size, ``(p,)``.

    Example:
        Twenty drives that differ by 2 %, and one whose damping is 40 % larger:

        >>> rng = np.random.default_rng(1)
        >>> mean = 0.02 * rng.standard_normal((21, 7))
        >>> mean[4, 3] += 0.34
        >>> theta = np.exp(mean[:, None] + 0.1 * rng.standard_normal((21, 50, 7)))
        >>> drawn = TypeDraws(mean, np.tile(1e-4 * np.eye(7), (21, 1, 1)), np.full(21, 2), theta)
        >>> learned = learn_type(drawn, np.full(7, 0.2))
        >>> np.argwhere(learned.evidence > 6.0).tolist(), bool(learned.spread[3] < 0.04)
        ([[4, 3]], True)
    """
    x, error = drawn.mean, drawn.error()
    n, p = x.shape
    centre, least = np.median(x, axis=0), np.square(_LEAST_SPREAD * usual)
    variance = np.maximum(np.square(1.4826 * np.median(np.abs(x - centre), axis=0)), least)
    log_prior = np.log(np.append(1.0 - _DEVIATING, np.full(p, _DEVIATING / p)))
    for _ in range(_ROUNDS):
        log, mean, square = _components(x - centre, error, variance)
        share = np.exp(log + log_prior - (log + log_prior).max(axis=1, keepdims=True))
        share /= share.sum(axis=1, keepdims=True)
        counts = share[:, :, None] * (1.0 - np.eye(p + 1, p, -1))  # without what deviates
        total = counts.sum(axis=(0, 1))
        moved = (counts * mean).sum(axis=(0, 1)) / total
        variance = shrunk_variance((counts * square).sum(axis=(0, 1)), total, least, _KNOWN)
        centre = centre + moved
        if np.abs(moved).max() < _SETTLED:
            break
    log, _, _ = _components(x - centre, error, variance)
    evidence = log[:, 1:] - log[:, :1] if n >= FEWEST else np.full((n, p), -np.inf)
    known = np.sqrt((variance + np.diagonal(error.mean(axis=0))) / n)
    spread = np.sqrt(variance) if n > 1 else usual
    shared = np.sqrt(_SHARED * drawn.posterior.diagonal())
    return TypeOfBreaker(np.exp(centre), spread, known, shared, evidence, np.expm1(x - centre))


def _components(
    off: np.ndarray, error: np.ndarray, variance: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the log likelihoods of drives without a deviation and with one in each parameter,
    ``(n, 1 + p)``, and mean and mean square of their own part then, ``(n, 1 + p, p)``.
    """
    p = off.shape[1]
    wider = variance + _DEVIATION**2 * np.vstack([np.zeros(p), np.eye(p)])
    inverse = np.linalg.inv(error[:, None] + wider[:, :, None] * np.eye(p))
    pulled = np.einsum("nkij,nj->nki", inverse, off)
    log = 0.5 * np.linalg.slogdet(inverse)[1] - 0.5 * np.einsum("nki,ni->nk", pulled, off)
    mean = wider * pulled
    own = wider - np.square(wider) * np.diagonal(inverse, axis1=2, axis2=3)
    return log, mean, np.square(mean) + own


# ---- records -------------------------------------------------------------------------------------


def list_type(
    folders: Sequence[str | Path], motions: Sequence[str], of_type: str = ""
) -> list[dict[str, list[Operation]]]:
    """List the operations of the breakers in each folder, by motion, at most 20 of a breaker.

    A breaker is one of the column ``breaker`` of a folder's table, or else a folder.

    Args:
        folders: Folders with a table, or with a subfolder for each motion.
        of_type: Type in the column ``type`` of a table, in any spelling.

    Raises:
        FileNotFoundError: If a folder has no operation of the motions.
        ValueError: If a table is wrong, has several types to choose from, or none of this name.
    """
    listed, types = [], set()
    for folder in folders:
        name = printable(os.path.normpath(folder))
        by_breaker: dict[tuple[str, str], list[Operation]] = {}
        for motion, operation in _rows(folder, motions):
            types.add(operation.type)
            if not of_type or bare(operation.type) == bare(of_type):
                own = replace(operation, breaker=operation.breaker or name)
                by_breaker.setdefault((motion, own.breaker), []).append(own)
        chosen: dict[str, list[Operation]] = {}
        for (motion, _), every in by_breaker.items():
            places = np.linspace(0, len(every) - 1, min(len(every), _MOST)).round().astype(int)
            chosen.setdefault(motion, []).extend(every[k] for k in places)
        listed.append(chosen)
    if not any(listed) or (not of_type and len(usual_spelling(types)) > 1):
        stated = ", ".join(sorted(map(printable, types - {""}))) or "-"
        raise ValueError(say("type-choose", type=printable(of_type), types=stated))
    return listed


def _rows(folder: str | Path, motions: Sequence[str]) -> list[tuple[str, Operation]]:
    """Return motion and operation of each row of a folder's table, or of its files by motion."""
    if os.path.lexists(Path(folder, MANIFEST)):
        rows = [row for own in list_fleet(folder).values() for row in own if row[0] in motions]
        rows.sort(key=lambda row: (row[1].breaker, row[1].phase, row[1].number))
    else:  # a breaker may have records of one motion alone
        there = [motion for motion in motions if is_folder(Path(folder, motion))]
        rows = [(motion, e) for motion in there for e in list_operations(folder, motion)]
    if not rows:
        name = printable(folder)
        raise FileNotFoundError(say("type-no-operation", folder=name, motions=" or ".join(motions)))
    return rows


# ---- the prior -----------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class TypePrior:
    """The prior of a type of breaker, and the records from which it was learned.

    Attributes:
        levels: State network of the family of all records.
        estimates: Estimates of the usable records, by breaker.
        rejected: Reason why a record is not usable, for each of these.
        names: Breakers with a posterior.
        drawn: Draws of these breakers.
        learned: Medians and spread of the type.
    """

    levels: StateNetwork
    estimates: Mapping[str, Sequence[Estimate]]
    rejected: Sequence[str]
    names: Sequence[str]
    drawn: TypeDraws
    learned: TypeOfBreaker

    @property
    def records(self) -> list[DriveRecord]:
        """Usable records of all breakers."""
        return [e.record for estimates in self.estimates.values() for e in estimates]

    @property
    def motions(self) -> list[str]:
        """Motions of the records."""
        return [motion for motion in MOTIONS if any(r.motion == motion for r in self.records)]

    @cached_property
    def size(self) -> Size:
        """Size of drives of the family with the median stroke and duration of the records."""
        shapes = [r.shape for r in self.records if r.motion == self.motions[0]]
        median = np.median([(shape.stroke, shape.duration) for shape in shapes], axis=0)
        return Size(*(_rounded(v, 3) for v in median / np.exp(self.levels.usual[:, 0])))

    @property
    def reference(self) -> Prior:
        """Prior of the family at the size of the type."""
        return Prior.from_settings(self.levels.settings["prior"]).sized(self.size)

    @cached_property
    def wear(self) -> np.ndarray:
        """Log-sds of the room for wear, ``(p,)``."""
        change = family_of(HELD_BACK)["wear"]["change"]
        ends = np.array([change.get(name, (0.0, 0.0)) for name in NAMES])
        return np.abs(np.log1p(ends)).max(axis=1) / _WEAR_SDS

    @cached_property
    def prior(self) -> Prior:
        """Prior of the type, with the room for wear."""
        log_sds = np.hypot(self.learned.log_sds, self.wear)
        return Prior(self.learned.medians, np.minimum(log_sds, WIDEST))

    @property
    def intervals(self) -> np.ndarray:
        """Quantiles of 5, 50 and 95 % of each breaker by itself, ``(3, b, p)``."""
        return np.quantile(self.drawn.theta, [0.05, 0.5, 0.95], axis=1)

    def swinging(self, seed: int) -> float:
        """Return the share of simulated openings that swing back by more than half of their way.

        The two-spring model has no dampers: with little damping nothing else stops an opening.
        """
        usual = Sensor(**defaults()["sensor"]).sized(self.size).times
        theta = self.prior.sample(_OPENINGS, generator(seed, "fit-prior openings"))
        onset = np.zeros(_OPENINGS)
        ways = travel(theta, usual[usual >= 0.0], "opening", onset=onset).travel
        return float(np.mean([np.ptp(w[w.argmin() :]) > 0.5 * np.ptp(w) for w in ways]))

    def sensor(self) -> Sensor:
        """Return the default sensor at this size, with the noise of the records and a grid of
        whole samples within them.
        """
        usual, raws = Sensor(**defaults()["sensor"]).sized(self.size), [r.raw for r in self.records]
        ends = [(r.moves - r.time[r.inside][0], r.time[r.inside][-1] - r.moves) for r in raws]
        before, after = np.quantile(ends, _SHORT, axis=0, method="lower").tolist()
        sample = max(r.step for r in raws)
        start, stop = max(usual.start, -max(before, sample)), min(usual.stop, after)
        step = sample * np.ceil(round((stop - start) / (usual.samples - 1) / sample, 3))
        samples = int(round((stop - start) / step, 3)) + 1
        noise = [max(r.noise_at(r.step).sd, r.quantum / np.sqrt(12.0)) for r in raws]
        quiet = np.nanquantile(noise, _QUIET) if np.isfinite(noise).any() else usual.noise_sd
        noise = np.hypot(quiet, _LEFT_OUT * self.size.lengths)
        found = {"start": start, "stop": start + step * (samples - 1), "noise_sd": noise}
        return replace(usual, samples=samples, **{k: _rounded(v, 6) for k, v in found.items()})

    def settings(self) -> dict:
        """Return the sections of the configuration for drives of this type."""
        pairs = zip(self.prior.medians, self.prior.log_sds, strict=True)
        values = [{"median": _rounded(m, 5), "log_sd": _rounded(sd, 3)} for m, sd in pairs]
        found = {"size": asdict(self.size), "prior": dict(zip(NAMES, values, strict=True))}
        found |= {"sensor": asdict(self.sensor()), "motions": self.motions}
        found["family"] = {"name": self.levels.settings["family"]}
        return {key: value for key, value in found.items() if value != defaults()[key]}


def fit_type(listed: Sequence[Mapping[str, list[Operation]]], asked: Diagnosis) -> TypePrior:
    """Fit the prior of a type to records of its breakers, all in one family.

    Args:
        listed: Operations by folder and motion, from ``list_type``.
        asked: How to read and infer them, and which families to try.

    Raises:
        ValueError: If no record can be used, or none has a posterior.
    """
    read = [asked.read(by_motion) for by_motion in listed]
    once = iter(without_copies([*chain.from_iterable(read)]))
    folders = [[*islice(once, len(records))] for records in read]
    usable = [r for records in folders for r in records if not r.reason]
    rejected = [r.reason for records in folders for r in records if r.reason]
    if not usable:
        first = " | ".join(rejected[:3])
        raise ValueError(say("type-no-record", count=len(rejected), reasons=first))
    levels, _, _ = choose_family(
        asked.families(),
        lambda levels: [(r.motion, levels.match(r.motion, r.seen)) for r in usable],
        asked.settings.misfit_p_value,
    )
    asked = replace(asked, families=lambda: [levels])
    estimates: dict[str, list[Estimate]] = {}
    for records in folders:  # numbers of operations may repeat in another folder
        for estimate in asked.infer([r for r in records if not r.reason]):
            estimates.setdefault(estimate.record.operation.breaker, []).append(estimate)
    draws = {name: draws_of(own) for name, own in estimates.items()}
    names = [name for name, operations in draws.items() if operations]
    if not names:
        reasons = {e.why_not_inferred for own in estimates.values() for e in own}
        raise ValueError(say("type-not-inferred", reasons="; ".join(sorted(reasons))))
    drawn = TypeDraws.of(draws[name] for name in names)
    learned = learn_type(drawn, Prior.from_settings(defaults()["prior"]).log_sds)
    return TypePrior(levels, estimates, rejected, names, drawn, learned)


def _rounded(value: float, digits: int) -> float:
    return float(f"{value:.{digits}g}")
