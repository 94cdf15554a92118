"""The prior of a type of breaker, learned from records of some of its drives.

Drives of one type share levers and dampers, so networks make a common error for all of them. More
drives do not reduce this error, and the posterior of a drive is far wider than the spread of its
type. The spread is therefore estimated from means of the logarithms of draws, and the error of
these means from repeated operations. Medians over drives are robust against a few that deviate.
"""

import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import NamedTuple, Self

import numpy as np
import yaml

from breaker.common.clean_text import bare, usual_spelling
from breaker.common.document import Document, Remark, Table, text_of
from breaker.common.numerals import in_digits
from breaker.configuration.data_files import family_of
from breaker.configuration.loading import WIDEST, defaults
from breaker.diagnosis.estimate import DriveRecord, Estimate
from breaker.diagnosis.sentences import Sentence, say
from breaker.diagnosis.session import Diagnosis
from breaker.family.inputs import shrunk_variance
from breaker.family.networks import StateNetwork
from breaker.model.parameters import MOTIONS, NAMES, Size
from breaker.model.prior import Prior
from breaker.model.sensor import Sensor
from breaker.records.files import printable
from breaker.records.folder import list_fleet
from breaker.records.operations import Operation
from breaker.shipped import FAMILIES

_LEAST_SPREAD = 0.1  # expected spread of a type, in log-sds of the prior of all drives
_KNOWN = 4.0  # weight of an expected variance, in drives or operations
_SHARED = 0.6  # share of the posterior's variance that all drives of a type have in common
_MOST = 20  # records of a breaker and motion that are used: more do not reduce their common error
_LEFT_OUT = 0.02  # mm at size 1: errors of the model, which records of little noise show


class DrawnType(NamedTuple):
    """A type of breaker, learned from posterior draws of its drives.

    Attributes:
        theta: Draws of each drive, as many as for one operation, ``(n, d, p)``.
        medians: Medians of the drives, ``(p,)``.
        log_sds: Log-sds of a further drive, ``(p,)``: spread of the drives, error of the medians
            of few drives, and error that all drives share.
    """

    theta: np.ndarray
    medians: np.ndarray
    log_sds: np.ndarray

    @classmethod
    def of(cls, drives: Iterable[Sequence[np.ndarray]], usual: np.ndarray) -> Self:
        """Learn a type from the draws ``(d, p)`` of one or more operations of each drive.

        The spread of a single drive is that of drives of any type: log-sds at one size, ``usual``.
        """
        means, theta = [], []
        for operations in drives:
            means.append(np.array([np.log(operation).mean(axis=0) for operation in operations]))
            theta.append(np.concatenate(operations)[:: len(operations)])
        x, n = np.array([logs.mean(axis=0) for logs in means]), len(means)
        posterior, count = np.log(theta).var(axis=1).mean(axis=0), np.array([*map(len, means)])
        squares = sum(len(logs) * logs.var(axis=0) for logs in means)
        known = (1.0 - _SHARED) * posterior
        error = shrunk_variance(squares, (count - 1).sum(), known, _KNOWN) * (1.0 / count).mean()
        median = np.median(x, axis=0)
        wide = np.square(1.4826 * np.median(np.abs(x - median), axis=0))  # robust variance
        between = n * np.maximum(wide - error, 0.0)
        variance = shrunk_variance(between, n, np.square(_LEAST_SPREAD * usual), _KNOWN)
        doubt = (variance + error) / n + _SHARED * posterior
        spread = variance if n > 1 else np.square(usual)
        return cls(np.array(theta), np.exp(median), np.sqrt(spread + doubt))


def list_type(
    folders: Sequence[str | Path], motions: Sequence[str], of_type: str = ""
) -> dict[str, list[Operation]]:
    """List operations of the breakers in folders by motion, at most 20 of a breaker and motion.

    The column ``breaker`` of a folder's table names the breakers; otherwise a folder is a breaker.

    Args:
        folders: Folders with a table.
        of_type: Type in the column ``type`` of a table, in any spelling.

    Raises:
        FileNotFoundError: If a folder has no table, or no operation of the motions.
        ValueError: If a table is wrong, or has several types to choose from, or not this type.
    """
    rows: list[tuple[str, Operation]] = []
    for folder in folders:
        name = printable(os.path.normpath(folder))
        last = max((row.number for _, row in rows), default=0)  # numbers may repeat in each folder
        new = [row for part in list_fleet(folder).values() for row in part if row[0] in motions]
        if not new:
            words = {"folder": name, "motions": " or ".join(motions)}
            raise FileNotFoundError(say("type-no-operation", **words))
        for motion, row in new:
            number, breaker = last + row.number, row.breaker or name
            rows.append((motion, replace(row, number=number, breaker=breaker)))
    types = {row.type for _, row in rows}
    chosen = [row for row in rows if not of_type or bare(row[1].type) == bare(of_type)]
    if not chosen or (not of_type and len(usual_spelling(types)) > 1):
        stated = ", ".join(sorted(map(printable, types - {""}))) or "-"
        raise ValueError(say("type-choose", type=printable(of_type), types=stated))
    by_breaker: dict[tuple[str, str], list[Operation]] = {}
    for motion, row in sorted(chosen, key=lambda pair: (pair[1].phase, pair[1].number)):
        by_breaker.setdefault((motion, row.breaker), []).append(row)
    listed: dict[str, list[Operation]] = {motion: [] for motion in motions}
    for (motion, _), of_breaker in by_breaker.items():
        listed[motion] += of_breaker[:: -(-len(of_breaker) // _MOST)]
    return listed


@dataclass(frozen=True, eq=False)
class TypePrior:
    """The prior of a type of breaker, and the records from which it was learned.

    Attributes:
        levels: State network of the family of all records.
        estimates: Estimates of the usable records, by breaker.
        rejected: Reasons of the unusable records, one for each.
        names, drawn: Breakers with a posterior, and the type that was learned from them.
    """

    levels: StateNetwork
    estimates: Mapping[str, Sequence[Estimate]]
    rejected: Sequence[str]
    names: Sequence[str]
    drawn: DrawnType

    @cached_property
    def records(self) -> dict[str, list[DriveRecord]]:
        """Usable records of all breakers, by motion."""
        usable = [e.record for estimates in self.estimates.values() for e in estimates]
        by_motion = {motion: [r for r in usable if r.motion == motion] for motion in MOTIONS}
        return {motion: records for motion, records in by_motion.items() if records}

    @cached_property
    def size(self) -> Size:
        """Size of drives of the family with the median stroke and duration of the records."""
        shapes = [record.shape for record in next(iter(self.records.values()))]
        median = np.median([(shape.stroke, shape.duration) for shape in shapes], axis=0)
        return Size(*(float(in_digits(v, 3)) for v in median / np.exp(self.levels.usual[:, 0])))

    @cached_property
    def prior(self) -> Prior:
        """Prior of the type, widened by uniformly distributed wear."""
        change = family_of(FAMILIES[0])["wear"]["change"]
        ends = np.log1p([change.get(name, (0.0, 0.0)) for name in NAMES])
        log_sds = np.hypot(self.drawn.log_sds, np.ptp(ends, axis=1) / np.sqrt(12.0))
        return Prior(self.drawn.medians, np.minimum(log_sds, WIDEST))

    @cached_property
    def sensor(self) -> Sensor:
        """The default sensor with the noise of the records, and a grid of their samples."""
        usual, by_motion = Sensor(**defaults()["sensor"]).sized(self.size), self.records.values()
        raws = [record.raw for records in by_motion for record in records]
        sample = max(raw.step for raw in raws)
        before = min(raw.moves - raw.time[raw.inside][0] for raw in raws)
        after = min(raw.time[raw.inside][-1] - raw.moves for raw in raws)
        start, stop = max(usual.start, -max(before, sample)), min(usual.stop, after)
        step = sample * np.ceil(round((stop - start) / (usual.samples - 1) / sample, 3))
        samples = int(round((stop - start) / step, 3)) + 1
        # The lower noise of both motions: the drive may still ring of a closing before an opening.
        noise = min(np.median([e.raw.process[0] for e in records]) for records in by_motion)
        noise = np.hypot(noise, _LEFT_OUT * self.size.lengths)
        grid = {"start": start, "stop": start + step * (samples - 1), "noise_sd": noise}
        return replace(usual, samples=samples, **{k: round(float(v), 6) for k, v in grid.items()})

    def settings(self) -> dict:
        """Return the sections of the configuration for drives of this type."""
        pairs = zip(NAMES, self.prior.medians, self.prior.log_sds.round(3).tolist(), strict=True)
        prior = {k: {"median": float(in_digits(m, 5)), "log_sd": sd} for k, m, sd in pairs}
        content = {"size": asdict(self.size), "prior": prior, "sensor": asdict(self.sensor)}
        content |= {"motions": [*self.records], "family": {"name": self.levels.settings["family"]}}
        return {key: value for key, value in content.items() if value != defaults()[key]}


def fit_type(listed: Mapping[str, Sequence[Operation]], diagnosis: Diagnosis) -> TypePrior:
    """Fit the prior of a type to records of its breakers, all in one family.

    Raises:
        ValueError: If no record can be used, or none has a posterior.
    """
    records = diagnosis.read(listed)
    rejected = [record.reason for record in records if record.reason]
    if len(rejected) == len(records):
        first = " | ".join(rejected[:3])
        raise ValueError(say("type-no-record", count=len(rejected), reasons=first))
    estimates = diagnosis.infer([record for record in records if not record.reason])
    by_breaker: dict[str, list[Estimate]] = {}
    draws: dict[str, dict[int, np.ndarray]] = {}
    for estimate in estimates:
        name = estimate.record.operation.breaker
        by_breaker.setdefault(name, []).append(estimate)
        if estimate.draws:  # both motions of an operation may share draws
            draws.setdefault(name, {})[id(estimate.draws)] = estimate.draws.theta
    if not draws:
        reasons = sorted({estimate.why_not_inferred for estimate in estimates})
        raise ValueError(say("type-not-inferred", reasons="; ".join(reasons)))
    operations = [[*by_operation.values()] for by_operation in draws.values()]
    drawn = DrawnType.of(operations, Prior.from_settings(defaults()["prior"]).log_sds)
    return TypePrior(estimates[0].levels, by_breaker, rejected, [*draws], drawn)


def document_of(fitted: TypePrior) -> Document:
    """Return the document of a fitted prior: its records, warnings and rejected records."""
    values = asdict(fitted.size) | {"noise": in_digits(fitted.sensor.noise_sd, 3)}
    values |= {"records": sum(map(len, fitted.records.values()))}
    values |= {"breakers": ", ".join(fitted.names)}
    remarks = [Remark(sentence, "WARNING: ") for sentence in warnings_of(fitted)]
    title = say("type-rejected", count=len(fitted.rejected))
    reasons = [Remark(reason) for reason in fitted.rejected]
    rejected = [Table(title=title, rows=reasons)] if reasons else []
    summary = [say("type-source", **values)]
    return Document(summary=summary, parts=[Table(rows=remarks), *rejected])


def warnings_of(fitted: TypePrior) -> list[Sentence]:
    """Return warnings about breakers and about drives with dampers."""
    warnings = [say("type-one-breaker")] if len(fitted.names) == 1 else []
    for name, estimates in fitted.estimates.items():
        if reasons := [e.why_not_inferred for e in estimates if not e.draws]:
            counts = {"count": len(reasons), "records": len(estimates), "reason": reasons[0]}
            warnings.append(say("type-left-out", breaker=name, **counts))
    family = fitted.levels.settings["family"]
    if "opening" in fitted.records and family != defaults()["family"]["name"]:
        warnings.append(say("type-damped", family=family))
    return warnings


def configuration_lines(settings: Mapping, document: Document) -> str:
    """Return settings as YAML below the document as comments."""
    first = replace(document, summary=[say("type-title"), *document.summary])
    comments = "".join(f"# {line}".rstrip() + "\n" for line in text_of(first).splitlines())
    return comments + "\n" + yaml.safe_dump(settings, default_flow_style=None, sort_keys=False)
