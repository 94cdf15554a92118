"""Drives that may be the recorded one, and what a transducer like its own would record of them.

A posterior has parameters and the size of each mechanism. The laws and places of these, and random
forces, are drawn from the family; of many drives those are kept whose curves are next to the
record. Records of them have its step, noise and quantum, and are read as it is.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from breaker.common.randomness import systematic
from breaker.drive.answers.evidence import Answer, DriveRecord, Given
from breaker.drive.answers.inference import mean_of
from breaker.drive.answers.operation_scatter import usual_scatter
from breaker.drive.family.record_inputs import normalise_record
from breaker.drive.simulation.drive_family import Family
from breaker.drive.simulation.own_family import family_of
from breaker.drive.simulation.rich_drive import Drive
from breaker.drive.training.mechanism_sizes import drive_with
from breaker.mechanism.prior import Prior
from breaker.quantities.parameters import MOTIONS, NAMES
from breaker.quantities.size import Size, powers
from breaker.reading.records.contact_edges import Contact
from breaker.reading.records.motion import find_segment
from breaker.reading.records.normalised_shape import shape_of
from breaker.reading.records.raw_record import Raw

_EACH = 6  # drives that are tried for each that is kept
_TRIES = 20  # draws of laws for a drive that holds
_ENDS = 12.0  # durations after 10 % of the way, to which a record of another motion goes on
_MEMORY = 64  # samples, over which noise is coloured


@dataclass(frozen=True)
class Setup:
    """How records are taken of a drive.

    Attributes:
        records: Of each motion, how many; a mean of them is answered.
        noise: Factor on noise and quantum of the transducer.
    """

    records: dict[str, int]
    noise: float = 1.0


def sizes_of(
    answer: Answer, given: Given, theta: np.ndarray, rng: np.random.Generator
) -> list[Size]:
    """Return sizes of drives with parameters ``(n, p)``: as given, or else as the family's prior
    has them, which knows of any size what the parameters are.
    """
    if given.size is not None:
        return [given.size] * len(theta)
    prior = given.prior_of(answer.levels)
    whole = powers() / np.square(prior.log_sds)
    precision = whole @ powers().T
    middle = np.linalg.solve(precision, whole @ (np.log(theta) - np.log(prior.medians)).T).T
    spread = np.linalg.cholesky(np.linalg.inv(precision))
    logs = middle + rng.standard_normal(middle.shape) @ spread.T
    return [Size(*each) for each in np.exp(logs).tolist()]


def likely_drives(
    answers: Sequence[Answer], given: Given, count: int, rng: np.random.Generator
) -> list[Drive]:
    """Draw drives that may be the recorded one.

    Args:
        answers: Of one operation: of each motion at hand, with draws of both together.
        given: What is given beside the records.
        count: How many drives.

    Returns:
        As many drives, or fewer where hardly one works; none of a family of another simulator.
    """
    first = answers[0]
    settings = first.levels.settings["drives"]
    if settings.get("simulator"):
        return []
    family = family_of(Prior.from_settings(first.levels.settings["prior"]), settings)
    weights, found = np.ones(len(first.draws.theta)), []
    chosen = systematic(weights, _EACH * count, rng.random(), rng)
    sizes = sizes_of(first, given, first.draws.theta[chosen], rng)
    for i, size in zip(chosen.tolist(), sizes, strict=True):
        drive = _drive(family, first, i, size, rng)
        if drive is not None and np.isfinite(off := _off(drive, answers)):
            found.append((off, len(found), drive))
    return [drive for *_, drive in sorted(found)[:count]]


def _drive(
    family: Family, answer: Answer, i: int, size: Size, rng: np.random.Generator
) -> Drive | None:
    """A drive of the i-th draw; None if none of the tried laws holds it."""
    draws = answer.draws
    sizes = {name: float(each[i]) for name, each in draws.mechanisms.items()}
    sizes["build_up"] /= size.times
    shares = dict(family.settings["contacts"])
    slides = sizes["sliding_contact"] > 0.0
    kinds = ["sliding"] if slides else ["elastic", *["held"] * (sizes["contact_preload"] > 0.0)]
    weights = np.array([shares[kind] for kind in kinds]) + 1e-9
    kind = kinds[int(rng.choice(len(kinds), p=weights / weights.sum()))]
    seen = answer.record.seen
    stroke, duration = float(seen.stroke[0]) / size.lengths, float(seen.duration[0]) / size.times
    if "closing" not in answer.motions:
        duration = float(np.exp(answer.levels.usual[1, 0]))
    theta = (draws.theta[i] / size.factors).tolist()
    for _ in range(_TRIES):
        if (proposed := family.proposed(kind, rng)) is not None:
            drive = drive_with(proposed, theta, sizes, stroke, duration)
            if drive.holds:
                return drive.scaled(size)
    return None


def _off(drive: Drive, answers: Sequence[Answer]) -> float:
    """How far the curves of a drive are from its records, in squares of their noise; nan if it does
    not move.
    """
    total = 0.0
    for each in answers:
        seen, raw = each.record.seen, each.record.raw
        time = raw.step * np.arange(raw.segment.end - raw.segment.begin)
        try:
            way = drive.travel(each.record.motion, time - _release(each))
            way = shape_of(way if each.record.motion == "closing" else -way, raw.step).way
        except (FloatingPointError, ValueError):
            return np.nan
        left = (way - seen.way[0])[seen.present[0]] / seen.noise[0]
        total += float(np.square(left).sum())
    return total


def _release(answer: Answer) -> float:
    """Time from the first sample to the release as inferred, ms."""
    record = answer.record
    early = float(np.median(answer.draws.release[record.motion]))
    return record.tenth - float(record.raw.time[record.raw.segment.begin]) + early


def operated(
    drive: Drive, answers: Sequence[Answer], setup: Setup, rng: np.random.Generator
) -> list[Answer]:
    """Record a drive as a setup has it, and read the records.

    Args:
        drive: The drive.
        answers: Of the recorded drive, by whose transducer records are taken.
        setup: Which records are taken, and how.

    Returns:
        An answer without draws for each motion, a mean where it has several records.

    Raises:
        ValueError, FloatingPointError: If a record shows no motion.
    """
    by = {each.record.motion: each for each in answers}
    found = []
    for motion in (each for each in MOTIONS if each in setup.records):
        like, several = by.get(motion, answers[0]), setup.records[motion] > 1
        some = [
            _recorded(_scattered(drive, rng) if several else drive, motion, like, setup.noise, rng)
            for _ in range(setup.records[motion])
        ]
        found.append(mean_of(some) if several else some[0])
    return found


def _scattered(drive: Drive, rng: np.random.Generator) -> Drive:
    """A drive as it is in one of its operations, in which it holds its closed position, too."""
    sd = usual_scatter("", 1.0, 0.0)
    while True:
        factors = 1.0 + sd * rng.standard_normal(len(NAMES))
        values = {n: drive.value(n) * f for n, f in zip(NAMES, factors, strict=True)}
        if (found := drive.changed(**values)).holds:
            return found


def _recorded(
    drive: Drive, motion: str, like: Answer, finer: float, rng: np.random.Generator
) -> Answer:
    """One record of a motion, read as records are."""
    raw, same = like.record.raw, motion == like.record.motion
    release, count = _release(like), raw.segment.end - raw.segment.begin
    if not same:
        count = max(count, int((release + _ENDS * like.record.shape.duration) / raw.step))
    time = raw.step * np.arange(count)
    travel, switching = drive.operate(motion, time - release)
    whole = travel + _noise(raw, count, finer, rng)
    quantum = finer * raw.quantum
    whole = quantum * np.round(whole / quantum) if quantum else whole
    segment = find_segment(time, whole, motion)
    contact, sd = Contact(), raw.contact.sd
    if same and like.record.timed:
        contact = Contact(release + switching + sd * rng.standard_normal(), sd)
    about = {"motion": motion, "time": time, "whole": whole, "doubts": np.full(count, "")}
    about |= {"quantum": quantum, "segment": segment, "moves": release, "moves_sd": 0.0}
    made = replace(raw, **about, contact=contact)
    shape, seen = normalise_record(made)
    record = DriveRecord(raw.operation, motion, like.record.stated, "", made, shape, seen)
    return Answer(record, like.levels, like.match, speeds=like.speeds)


def _noise(raw: Raw, count: int, finer: float, rng: np.random.Generator) -> np.ndarray:
    """Noise of a record's process ``(count,)``, mm, without that of its quantum."""
    sd, colour = raw.process
    sd = np.sqrt(max(sd**2 - raw.quantum**2 / 12.0, 0.0))
    white = rng.standard_normal(count + _MEMORY)
    kernel = np.sqrt(1.0 - colour**2) * colour ** np.arange(_MEMORY)
    return finer * sd * np.convolve(white, kernel)[_MEMORY : _MEMORY + count]
