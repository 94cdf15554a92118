r"""The prior of a type of breaker, learned from records of some of its drives.

Drives of one type share levers and dampers, and so the error of what networks infer from them. More
drives do not reduce this error, and the posterior of a drive is far wider than the spread of its
type. Therefore the model compares drives by the means ``x_b`` of their draws (logarithms), whose
own error shows from operation to operation: ``x_b = m + u_b + e_b``, ``u_b ~ N(0, diag(tau^2))``.
In a few drives one parameter deviates by more; the evidence for it is the log likelihood ratio.
Expectation maximisation estimates m and tau from the drives that do not deviate.
"""

import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import NamedTuple, Self

import numpy as np
import yaml

from breaker.common.document import Document, Remark, Section, Table, text_of
from breaker.common.numerals import in_digits
from breaker.common.text import bare, usual_spelling
from breaker.common.wording import Sentence
from breaker.configuration.definitions import family_of
from breaker.configuration.loading import WIDEST, defaults
from breaker.diagnosis.estimate import DriveRecord, Estimate
from breaker.diagnosis.session import Diagnosis
from breaker.diagnosis.words import say
from breaker.family.inputs import shrunk_variance
from breaker.family.networks import StateNetwork
from breaker.model.parameters import MOTIONS, NAMES, PARAMETERS, Size
from breaker.model.prior import Prior
from breaker.model.sensor import Sensor
from breaker.records.files import printable
from breaker.records.folder import is_folder, list_fleet, list_operations
from breaker.records.operations import MANIFEST, Operation
from breaker.shipped import HELD_BACK

FEWEST = 5
"""Drives of a type from which on one may deviate: of fewer, the spread is hardly known."""

DEVIATES = 6.0
"""Evidence that a drive deviates, nats: odds of 400, as a fleet has hundreds of drives."""

_DEVIATION = 0.3  # sd of a deviation, in logarithms: the largest usual wear
_LEAST_SPREAD = 0.1  # expected spread of a type, in log-sds of the prior of all drives
_KNOWN = 4.0  # drives or operations that an expected variance counts for
_SHARED = 0.6  # share of the posterior's variance that all drives of a type have in common
_MOST = 20  # records of one breaker and motion: more reduce no error that they share
_LEFT_OUT = 0.02  # mm at size 1: what no model describes in records of little noise


class TypeDraws(NamedTuple):
    """Draws of the drives of a type.

    Attributes:
        mean: Mean of the logarithms of the parameters over all operations, ``(n, p)``.
        squares: Sum of products of the operations' deviations from it, ``(n, p, p)``.
        count: Operations, ``(n,)``.
        theta: Posterior draws, as many as of one operation, ``(n, d, p)``.
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
            off, theta = means - means.mean(axis=0), np.concatenate(operations)
            some = theta[:: len(operations)]
            rows.append((means.mean(axis=0), off.T @ off, len(operations), some))
        return cls(*map(np.array, zip(*rows, strict=True)))


def draws_of(estimates: Iterable[Estimate]) -> list[np.ndarray]:
    """Return the draws ``(d, p)`` of each operation; two motions may share them."""
    return [*{id(e.draws): e.draws.theta for e in estimates if e.draws}.values()]


@dataclass(frozen=True, eq=False)
class TypeOfBreaker:
    """A type of breaker, learned from drives.

    Attributes:
        medians: Medians of its drives, ``(p,)``.
        spread: Log-sds of the drives, ``(p,)``.
        doubt: Log-sds of the medians, ``(p,)``: few drives inform of them, and share an error.
        evidence: Evidence that a parameter of a drive deviates, nats, ``(n, p)``; -inf below
            ``FEWEST`` drives.
        off: Distance of a drive's mean from the median, share, ``(n, p)``.
    """

    medians: np.ndarray
    spread: np.ndarray
    doubt: np.ndarray
    evidence: np.ndarray
    off: np.ndarray

    @property
    def log_sds(self) -> np.ndarray:
        """Log-sds of a further drive, ``(p,)``."""
        return np.hypot(self.spread, self.doubt)


def learn_type(drawn: TypeDraws, usual: np.ndarray) -> TypeOfBreaker:
    """Learn a type from its drives; from one drive, take the spread of drives of any type, whose
    log-sds at one size are ``usual``, ``(p,)``.
    """
    x, posterior = drawn.mean, np.mean([np.cov(np.log(e).T) for e in drawn.theta], axis=0)
    n, p = x.shape
    squares, seen = drawn.squares.sum(axis=0), float((drawn.count - 1).sum())
    one = shrunk_variance(squares, seen, (1.0 - _SHARED) * posterior, _KNOWN)
    error = one / drawn.count[:, None, None]
    centre, least = np.median(x, axis=0), np.square(_LEAST_SPREAD * usual)
    variance = np.maximum(np.square(1.4826 * np.median(np.abs(x - centre), axis=0)), least)
    settled = False
    while not settled:
        before = np.exp(centre), variance
        log, mean, square = _components(x - centre, error, variance)
        log[:, 1:] -= DEVIATES  # odds of a deviation before any record
        share = np.exp(log - log.max(axis=1, keepdims=True))
        share /= share.sum(axis=1, keepdims=True)
        counts = share[:, :, None] * (1.0 - np.eye(p + 1, p, -1))  # without what deviates
        total = counts.sum(axis=(0, 1))
        centre = centre + (counts * mean).sum(axis=(0, 1)) / total
        variance = shrunk_variance((counts * square).sum(axis=(0, 1)), total, least, _KNOWN)
        settled = np.allclose(before, (np.exp(centre), variance), atol=0.0)
    log, _, _ = _components(x - centre, error, variance)
    evidence = log[:, 1:] - log[:, :1] if n >= FEWEST else np.full((n, p), -np.inf)
    few = (variance + np.diagonal(error.mean(axis=0))) / n
    doubt = np.sqrt(few + _SHARED * posterior.diagonal())
    spread = np.sqrt(variance) if n > 1 else usual
    return TypeOfBreaker(np.exp(centre), spread, doubt, evidence, np.expm1(x - centre))


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


def list_type(
    folders: Sequence[str | Path], motions: Sequence[str], of_type: str = ""
) -> dict[str, list[Operation]]:
    """List operations of the breakers in folders by motion, at most 20 of a breaker and motion.

    A breaker is one of the column ``breaker`` of a folder's table, or else a folder.

    Args:
        folders: Folders with a table, or with a subfolder for each motion.
        of_type: Type in the column ``type`` of a table, in any spelling.

    Raises:
        FileNotFoundError: If a folder has no operation of the motions.
        ValueError: If a table is wrong, has several types to choose from, or none of this name.
    """
    by_breaker: dict[tuple[str, str], list[Operation]] = {}
    types, last = set(), 0
    for folder in folders:
        name = printable(os.path.normpath(folder))
        if os.path.lexists(Path(folder, MANIFEST)):
            rows = [row for own in list_fleet(folder).values() for row in own if row[0] in motions]
            rows.sort(key=lambda row: (row[1].phase, row[1].number))
        else:  # a breaker may have records of one motion alone
            there = [motion for motion in motions if is_folder(Path(folder, motion))]
            rows = [(motion, e) for motion in there for e in list_operations(folder, motion)]
        if not rows:
            about = {"folder": name, "motions": " or ".join(motions)}
            raise FileNotFoundError(say("type-no-operation", **about))
        types |= {row.type for _, row in rows}
        for motion, row in rows:
            if not of_type or bare(row.type) == bare(of_type):
                own = replace(row, number=last + row.number, breaker=row.breaker or name)
                by_breaker.setdefault((motion, own.breaker), []).append(own)
        last += max(row.number for _, row in rows)  # numbers may repeat in another folder
    if not by_breaker or (not of_type and len(usual_spelling(types)) > 1):
        stated = ", ".join(sorted(map(printable, types - {""}))) or "-"
        raise ValueError(say("type-choose", type=printable(of_type), types=stated))
    listed: dict[str, list[Operation]] = {motion: [] for motion in motions}
    for (motion, _), every in by_breaker.items():
        places = np.linspace(0, len(every) - 1, min(len(every), _MOST)).round().astype(int)
        listed[motion] += [every[k] for k in places]
    return listed


@dataclass(frozen=True, eq=False)
class TypePrior:
    """The prior of a type of breaker, and the records from which it was learned.

    Attributes:
        levels: State network of the family of all records.
        estimates: Estimates of the usable records, by breaker.
        rejected: Reason why a record is not usable, for each of these.
        names, drawn: Breakers with a posterior, and their draws.
        learned: The type.
    """

    levels: StateNetwork
    estimates: Mapping[str, Sequence[Estimate]]
    rejected: Sequence[str]
    names: Sequence[str]
    drawn: TypeDraws
    learned: TypeOfBreaker

    @cached_property
    def records(self) -> dict[str, list[DriveRecord]]:
        """Usable records of all breakers, by motion."""
        every = [e.record for estimates in self.estimates.values() for e in estimates]
        found = {motion: [r for r in every if r.motion == motion] for motion in MOTIONS}
        return {motion: some for motion, some in found.items() if some}

    @cached_property
    def size(self) -> Size:
        """Size of drives of the family with the median stroke and duration of the records."""
        shapes = [record.shape for record in next(iter(self.records.values()))]
        median = np.median([(shape.stroke, shape.duration) for shape in shapes], axis=0)
        return Size(*(float(in_digits(v, 3)) for v in median / np.exp(self.levels.usual[:, 0])))

    @property
    def reference(self) -> Prior:
        """Prior of the family at the size of the type."""
        return Prior.from_settings(self.levels.settings["prior"]).sized(self.size)

    @cached_property
    def prior(self) -> Prior:
        """Prior of the type, with room for wear: changes that are spread evenly."""
        change = family_of(HELD_BACK)["wear"]["change"]
        ends = np.log1p([change.get(name, (0.0, 0.0)) for name in NAMES])
        log_sds = np.hypot(self.learned.log_sds, np.ptp(ends, axis=1) / np.sqrt(12.0))
        return Prior(self.learned.medians, np.minimum(log_sds, WIDEST))

    @cached_property
    def sensor(self) -> Sensor:
        """The default sensor with the records' noise, and a grid of whole samples within them."""
        usual, own = Sensor(**defaults()["sensor"]).sized(self.size), self.records.values()
        raws = [record.raw for some in own for record in some]
        sample = max(raw.step for raw in raws)
        before = min(raw.moves - raw.time[raw.inside][0] for raw in raws)
        after = min(raw.time[raw.inside][-1] - raw.moves for raw in raws)
        start, stop = max(usual.start, -max(before, sample)), min(usual.stop, after)
        step = sample * np.ceil(round((stop - start) / (usual.samples - 1) / sample, 3))
        samples = int(round((stop - start) / step, 3)) + 1
        # Of one motion: the rest before an opening may still ring of the closing.
        noise = min(np.median([record.raw.process[0] for record in some]) for some in own)
        noise = np.hypot(noise, _LEFT_OUT * self.size.lengths)
        found = {"start": start, "stop": start + step * (samples - 1), "noise_sd": noise}
        return replace(usual, samples=samples, **{k: round(float(v), 6) for k, v in found.items()})

    def settings(self) -> dict:
        """Return the sections of the configuration for drives of this type."""
        pairs = zip(NAMES, self.prior.medians, self.prior.log_sds.round(3).tolist(), strict=True)
        prior = {k: {"median": float(in_digits(m, 5)), "log_sd": sd} for k, m, sd in pairs}
        found = {"size": asdict(self.size), "prior": prior, "sensor": asdict(self.sensor)}
        found |= {"motions": [*self.records], "family": {"name": self.levels.settings["family"]}}
        return {key: value for key, value in found.items() if value != defaults()[key]}


def fit_type(listed: Mapping[str, Sequence[Operation]], asked: Diagnosis) -> TypePrior:
    """Fit the prior of a type to records of its breakers, all in one family.

    Raises:
        ValueError: If no record can be used, or none has a posterior.
    """
    records = asked.read(listed)
    rejected = [record.reason for record in records if record.reason]
    if len(rejected) == len(records):
        first = " | ".join(rejected[:3])
        raise ValueError(say("type-no-record", count=len(rejected), reasons=first))
    estimates = asked.infer([record for record in records if not record.reason])
    by_breaker: dict[str, list[Estimate]] = {}
    for each in estimates:
        by_breaker.setdefault(each.record.operation.breaker, []).append(each)
    draws = {name: some for name, own in by_breaker.items() if (some := draws_of(own))}
    if not draws:
        reasons = sorted({each.why_not_inferred for each in estimates})
        raise ValueError(say("type-not-inferred", reasons="; ".join(reasons)))
    drawn = TypeDraws.of(draws.values())
    learned = learn_type(drawn, Prior.from_settings(defaults()["prior"]).log_sds)
    return TypePrior(estimates[0].levels, by_breaker, rejected, [*draws], drawn, learned)


def document_of(fitted: TypePrior) -> Document:
    """Return what was fitted to which records, and what to look at."""
    about = asdict(fitted.size) | {"noise": in_digits(fitted.sensor.noise_sd, 3)}
    about |= {"records": sum(map(len, fitted.records.values()))}
    about |= {"breakers": ", ".join(fitted.names)}
    remarks = [Remark(sentence, "WARNING: ") for sentence in warnings_of(fitted)]
    prior, usual, learned = fitted.prior, fitted.reference, fitted.learned
    medians = np.array([prior.medians, usual.medians]).T
    log_sds = np.array([usual.log_sds, prior.log_sds, learned.spread, learned.doubt]).T
    rows = [
        (f"{each.name} ({each.unit})", *(f"{m:.4g}" for m in some), *(f"{sd:.3f}" for sd in sds))
        for each, some, sds in zip(PARAMETERS, medians, log_sds, strict=True)
    ]
    head = "parameter", "median", "default", "its log_sd", "log_sd", "of drives", "of medians"
    title = say("type-rejected", count=len(fitted.rejected))
    rejected = [Section(title, [Remark(e) for e in fitted.rejected])] if fitted.rejected else []
    parts = [Section(parts=remarks), Table(head, rows), *rejected]
    return Document(summary=[say("type-source", **about)], parts=parts)


def warnings_of(fitted: TypePrior) -> list[Sentence]:
    """Return warnings about breakers, and about what the prior lacks."""
    names, learned = fitted.names, fitted.learned
    said = [say("type-one-breaker")] if len(names) == 1 else []
    for name, estimates in fitted.estimates.items():
        if name not in names:
            said.append(say("type-left-out", breaker=name, reason=estimates[0].why_not_inferred))
        elif outside := sum(e.misfit for e in estimates):
            said.append(say("type-outside", breaker=name, count=outside, records=len(estimates)))
    for name, evidence, off in zip(names, learned.evidence, learned.off, strict=True):
        k = int(evidence.argmax())
        if evidence[k] >= DEVIATES:
            about = {"parameter": NAMES[k], "off": 100.0 * off[k], "evidence": evidence[k]}
            said.append(say("type-deviates", breaker=name, **about))
    if wide := [NAMES[k] for k in np.flatnonzero(fitted.prior.log_sds == WIDEST)]:
        said.append(say("type-wide", parameters=", ".join(wide), widest=WIDEST))
    family = fitted.levels.settings["family"]
    if "opening" in fitted.records and family != defaults()["family"]["name"]:
        said.append(say("type-damped", family=family))
    return said


def configuration_lines(settings: Mapping, document: Document) -> str:
    """Return settings as YAML below the document as comments."""
    first = replace(document, summary=[say("type-title"), *document.summary])
    comments = "".join(f"# {line}".rstrip() + "\n" for line in text_of(first).splitlines())
    return comments + "\n" + yaml.safe_dump(settings, default_flow_style=None, sort_keys=False)
