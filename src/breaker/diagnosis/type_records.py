"""Records of the breakers of a type, from folders: which of them count, and what they say."""

import os
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple, Self

import numpy as np

from breaker.common.numerals import in_p
from breaker.common.spellings import bare, usual_spelling
from breaker.diagnosis.answer_words import differs_in_words
from breaker.diagnosis.estimate import DriveRecord, Estimate
from breaker.diagnosis.identity import without_copies
from breaker.diagnosis.session import Diagnosis
from breaker.family.membership import Match, choose_family
from breaker.family.networks import StateNetwork
from breaker.model.parameters import Size
from breaker.records.files import printable
from breaker.records.folder import list_fleet, list_operations
from breaker.records.operations import MANIFEST, Operation
from breaker.records.record import Record

_MOST = 20  # records of a breaker and a motion: more of them say no more of what breakers share
_ARRIVED = 0.05  # of the stroke, from the rest after the motion
_SHORT = 0.1  # share of the records of a motion that may be shorter than what is taken for all


class Span(NamedTuple):
    """How far a record goes around its first motion, ms, and its noise.

    Attributes:
        before: Rest before it.
        lasts: Until the drive stays at rest, or the record ends.
        after: Until the record ends, or the travel goes back.
        step: Between two samples.
        noise: Of a sample at rest, mm; nan where none is seen.
        rings: Whether the drive has moved before, and may not be at rest.
    """

    before: float
    lasts: float
    after: float
    step: float
    noise: float = np.nan
    rings: bool = False

    @classmethod
    def of(cls, raw: Record) -> Self:
        """Return that of one record."""
        time, segment = raw.time[raw.inside], raw.segment
        moving = np.abs(raw.left - segment.after) > _ARRIVED * segment.stroke
        lasts = time[np.flatnonzero(moving)[-1]] if moving.any() else raw.moves
        ends = (raw.moves - time[0], lasts - raw.moves, time[-1] - raw.moves)
        noise = max(raw.noise_at(raw.step).sd, raw.quantum / np.sqrt(12.0))
        return cls(*map(float, ends), float(f"{raw.step:.6g}"), noise, segment.begin > 0)


@dataclass(frozen=True, eq=False)
class Recorded:
    """Records of the breakers of a type, and what is inferred of them.

    Attributes:
        levels: Network of the family.
        tried: How the records of each motion fit families, by name: those tried before it, and it.
        answers: What is inferred of each usable record, by breaker.
        rejected: Why records were rejected, one text for each.
        left_out: How many records were not read since there are enough.
        spans: How far usable records go, by motion.
        types: Types of breaker that the table or the files name, each once, however it is spelt.
    """

    levels: StateNetwork
    tried: Mapping[str, Sequence[tuple[str, Match]]]
    answers: Mapping[str, Sequence[Estimate]]
    rejected: Sequence[str]
    left_out: int
    spans: Mapping[str, Sequence[Span]]
    types: Sequence[str] = ()

    def fit_in_words(self, family: str) -> str:
        """Say how far the records of each motion are from a family that was tried, and where."""
        by: dict[str, list[Match]] = defaultdict(list)
        for motion, match in self.tried[family]:
            by[motion].append(match)
        said = []
        for motion, matches in by.items():
            middle = sorted(matches, key=lambda each: each.p_value)[(len(matches) - 1) // 2]
            where = differs_in_words(middle.parts)
            said.append(f"{motion} {in_p(middle.p_value)}" + (where and f", {where}"))
        return "; ".join(said)

    @property
    def span(self) -> Span:
        """What nearly all records of either motion have before and after, the longest motion, and
        the longest step.
        """
        each = [np.array(spans)[:, :4] for spans in self.spans.values()]
        short = [np.quantile(spans, _SHORT, axis=0, method="lower") for spans in each]
        before, _, after, _ = np.min(short, axis=0).tolist()
        _, lasts, _, step = np.concatenate(each).max(axis=0).tolist()
        return Span(before, lasts, after, step)

    @property
    def noise_sd(self) -> float:
        """Median noise of a sample at rest, mm; nan if none is seen."""
        each = [span for spans in self.spans.values() for span in spans if span.noise >= 0.0]
        quiet = [span.noise for span in each if not span.rings] or [span.noise for span in each]
        return float(np.median(quiet)) if quiet else np.nan

    @property
    def records(self) -> dict[str, dict[str, list[Estimate]]]:
        """Answers by breaker and motion."""
        found: dict[str, dict[str, list[Estimate]]] = {}
        for name, answers in self.answers.items():
            for each in answers:
                found.setdefault(name, {}).setdefault(each.record.motion, []).append(each)
        return found

    @property
    def motions(self) -> list[str]:
        """Motions that any breaker has."""
        return list(dict.fromkeys(motion for each in self.records.values() for motion in each))

    @property
    def size(self) -> Size:
        """Size of drives of the family with the stroke and the duration of these: of the first
        motion that a breaker has.
        """
        first = [
            each.record.shape for by in self.records.values() for each in next(iter(by.values()))
        ]
        seen = np.median([(each.stroke, each.duration) for each in first], axis=0)
        return Size(*(float(f"{each:.3g}") for each in seen / np.exp(self.levels.usual[:, 0])))


def list_breakers(
    folders: Sequence[str | Path], motions: Sequence[str], of_type: str = ""
) -> dict[str, dict[str, list[Operation]]]:
    """List the operations of the breakers in folders, by motion and breaker.

    A breaker is one of the column ``breaker`` of a folder's table, or else a folder; its phases
    count as records of it.

    Args:
        folders: Each as ``endurance.curves``: with a table, or with a folder for each motion.
        motions: Which to look for; one that no folder has is left out.
        of_type: Take those alone that the column ``type`` of a table states to be of this type, in
            any spelling; all where it is empty.

    Raises:
        ValueError: If a table is wrong, or states no such type. The message says what to do.
        FileNotFoundError: If a folder has no operation of any motion.
    """
    found: dict[str, dict[str, list[Operation]]] = {m: defaultdict(list) for m in motions}
    types, troubles = set(), []
    for folder, name in ((each, printable(os.path.normpath(each))) for each in folders):
        own: list[str] = []
        rows = list(_rows(folder, motions, own))
        if not rows:  # a breaker that is named is not to be left out in silence
            raise FileNotFoundError(_none([folder], own))
        troubles += own
        for motion, each in rows:
            types.add(each.type)
            if motion in found and (not of_type or bare(each.type) == bare(of_type)):
                found[motion][each.breaker or name].append(each)
    if any(found.values()):
        return found
    if not (types and of_type):
        raise FileNotFoundError(_none(folders, troubles))
    stated = f"these: {', '.join(sorted(types - {''}))}" if any(types) else "none"
    raise ValueError(
        f"no operation is of type {printable(of_type)}: of types, the column type of "
        f"{MANIFEST} states {stated}"
    )


def _rows(
    folder: str | Path, motions: Sequence[str], troubles: list[str]
) -> Iterator[tuple[str, Operation]]:
    """Motions and operations in a folder, in their order; why it has none goes to the troubles."""
    if os.path.lexists(Path(folder, MANIFEST)):
        rows = [row for some in list_fleet(folder).values() for row in some]
        yield from sorted(rows, key=lambda row: (row[1].breaker, row[1].phase, row[1].number))
        if not {motion for motion, _ in rows} & {*motions}:
            troubles.append(f"{Path(folder, MANIFEST)} has no operation of {' or '.join(motions)}")
        return
    for motion in motions:
        try:
            yield from ((motion, each) for each in list_operations(folder, motion))
        except FileNotFoundError as error:  # a breaker may have one motion alone
            troubles.append(str(error))


def read_breakers(
    listed: Mapping[str, Mapping[str, Sequence[Operation]]],
    assessment: Diagnosis,
) -> Recorded:
    """Read some records of breakers, and infer them, all in one family.

    Args:
        listed: Their operations by motion and breaker, of ``list_breakers``.
        assessment: How they are read and inferred, and which families are tried.

    Raises:
        ValueError: If no record can be used. The message says what to do.
    """
    found: dict[str, dict[str, list[DriveRecord]]] = defaultdict(lambda: defaultdict(list))
    read, names, rejected, left_out = [], [], [], 0
    for motion, breakers in listed.items():
        for name, every in breakers.items():
            some = [every[i] for i in _spread(len(every))]
            left_out += len(every) - len(some)
            read += assessment.read({motion: some})
            names += [name] * (len(read) - len(names))
    for name, each in zip(names, without_copies(read), strict=True):  # of all breakers
        if each.reason:
            rejected.append(each.reason)
        else:  # of one name in two folders, operations have numbers of their own in each
            found[name][os.path.dirname(each.operation.file)].append(each)
    usable = [
        each for folders in found.values() for records in folders.values() for each in records
    ]
    if not usable:
        raise ValueError(
            f"none of {len(rejected)} records can be used; check endurance.format and the "
            "folder. The first reasons: " + " | ".join(rejected[:3])
        )
    levels, tried = _family_of(usable, assessment.families(), assessment.settings.misfit_p_value)
    own = replace(assessment, families=lambda: [levels])
    answers = {
        name: [answer for records in folders.values() for answer in own.infer(records)]
        for name, folders in found.items()
    }
    spans: dict[str, list[Span]] = defaultdict(list)
    for each in usable:
        spans[each.motion].append(Span.of(each.raw))
    types = usual_spelling(filter(None, (e.operation.type or e.stated.type for e in usable)))
    return Recorded(levels, tried, answers, rejected, left_out, spans, [*types.values()])


def _family_of(
    records: Sequence[DriveRecord], families: Iterable[StateNetwork], least: float
) -> tuple[StateNetwork, dict[str, list[tuple[str, Match]]]]:
    """The family of records, and how they fit all that were tried, it last."""
    tried: dict[str, list[tuple[str, Match]]] = {}

    def match(levels: StateNetwork) -> list[tuple[str, Match]]:
        found = [(each.motion, levels.match(each.motion, each.seen)) for each in records]
        return tried.setdefault(levels.settings["family"], found)

    levels, matches, _ = choose_family(families, match, least)
    name = levels.settings["family"]
    return levels, {key: tried[key] for key in tried if key != name} | {name: matches}


def _none(folders: Sequence[str | Path], troubles: Sequence[str]) -> str:
    """Why no folder has a record, and what to do."""
    absent = [printable(each) for each in folders if not os.path.isdir(each)]
    if absent:
        return f"there is no folder {', '.join(absent)}"
    return (
        f"{troubles[0]}. `breaker inspect {printable(folders[0])}` proposes a table of the "
        "operations, breakers and phases in a folder"
    )


def _spread(count: int) -> np.ndarray:
    """Numbers of the records that count, spread over all."""
    return np.unique(np.linspace(0, count - 1, min(count, _MOST)).round().astype(int))
