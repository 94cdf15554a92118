"""The exact posterior of one operation in a family of drives, and how far its network is off.

Unknown are all numbers by which the family draws a drive, its kind of contact, the release of each
record, and where it is not given its size. The likelihood is that of the samples: the noise that
the record shows at rest, about the reading of the simulated drive, with a zero that is free. What
the family's networks were trained on is integrated out by them; here particles carry it.

Release and size are laid onto the record: a drive is released so that its 10 % of the way come when
those of the record do, but for a score, and is as large as the stroke and the duration of the
record say, but for two. As neither tells anything of a drive beside its own curve, their priors are
flat.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from breaker.common.randomness import generator, systematic
from breaker.drive.answers.draw_weights import SURPRISING
from breaker.drive.answers.evidence import Answer, AnswerSettings, ExactFindings, Given
from breaker.drive.answers.inference import with_draws
from breaker.drive.exact.family_scores import FamilyScores
from breaker.drive.exact.particles import Particles, Target
from breaker.drive.exact.record_samples import RecordSamples
from breaker.drive.exact.simulated_motions import landmarks, readings
from breaker.drive.family.level_network import LevelDraws
from breaker.drive.family.mechanisms import MECHANISMS
from breaker.drive.simulation.drive_family import Family
from breaker.drive.simulation.rich_drive import ELEMENTS
from breaker.drive.training.mechanism_sizes import mechanism_sizes
from breaker.mechanism.prior import Prior
from breaker.quantities.parameters import NAMES
from breaker.quantities.size import powers

PARTICLES = 1000
ENOUGH = 400.0
"""Effective size at which an answer is enough."""
LEAST = 50.0
"""Effective size below which it is not told."""

_LAID = 0.1  # sd of a release in durations, and of the logarithms of a size, about the record's
_MOVED, _MOST = 1.0, 12  # mean square of the way at a power, over the variance; and rounds at most
_EARLY, _LATE = 700, 2000  # steps of training an emulator on the way, and at the posterior
_DRIVES = 200_000  # on the way to the posterior; from fine records of large drives it is longer
_LEARNED = (0, 10, 30)  # rounds at the posterior before which an emulator is learned anew
_FEWEST, _ROUNDS = 10, 60  # rounds, of whose second half draws are
_BEFORE = 4000  # drives of the family, by which evidence is told
_DRIVE, _CONTACT = len(NAMES) + len(ELEMENTS), len(NAMES) + ELEMENTS.index("contact")


@dataclass(eq=False)
class _Operation:
    """The records of one operation, and the drives that may have made them.

    Numbers of a drive are those of a drive of size 1, the two scores of its size, and one of each
    release.

    Attributes:
        answers: What networks infer of each record.
        given: What is given beside them.
        scores: What makes drives.
        samples: Of each record.
    """

    answers: Sequence[Answer]
    given: Given
    scores: FamilyScores
    samples: Sequence[RecordSamples]

    @property
    def target(self) -> Target:
        """What particles are led to."""
        return Target(
            unknowns=self.scores.unknowns + 2 + len(self.answers),
            numbers=self.numbers,
            inputs=self.scores.gates.seen,
            traced=self.traced,
            residuals=self.residuals,
            kinds=self.scores.contact,
            shares=self.scores.shares,
            fixed=[0],
            asked=self.log_parameters,
            redrawn=self.scores.redrawn,
            switched=self.scores.switched if self.scores.presence else None,
        )

    def numbers(self, scores: np.ndarray) -> np.ndarray:
        """Numbers of drives of scores ``(n, m)``, ``(n, p + e + 2 + r)``."""
        return self._made(scores)[0]

    def traced(self, scores: np.ndarray) -> tuple[np.ndarray, Callable[[np.ndarray], np.ndarray]]:
        """What emulators see of these, and what takes slopes by it to slopes by the scores."""
        numbers, back = self._made(scores)
        gates = self.scores.gates

        def taken_back(slopes: np.ndarray) -> np.ndarray:
            by = gates.back(numbers, slopes)
            return np.column_stack([back(by[:, :_DRIVE]), by[:, _DRIVE:]])

        return gates.seen(numbers), taken_back

    def _made(self, scores):
        """Numbers of drives, and what takes slopes by those of the family to its scores."""
        own, laid = np.split(scores, [self.scores.unknowns], axis=1)
        numbers, back = self.scores.traced(own)
        return np.column_stack([numbers, laid]), back

    def log_parameters(self, numbers: np.ndarray) -> np.ndarray:
        """Logarithms of the parameters but for those of a size that is laid on, ``(n, p)``."""
        return np.log(numbers[:, : len(NAMES)])

    def simulate(self, numbers: np.ndarray) -> tuple[LevelDraws, list[np.ndarray]]:
        """Drives without their mechanisms, and the readings of each record, ``(n, t)``."""
        drives, laid = np.ascontiguousarray(numbers[:, :_DRIVE]), numbers[:, _DRIVE:]
        releases, switchings, travels, units = {}, {}, [], None
        for i, (answer, samples) in enumerate(zip(self.answers, self.samples, strict=True)):
            motion, shape = answer.record.motion, answer.record.shape
            closes = motion == "closing"
            stroke, tenth, half = landmarks(drives, self.scores.touch, closes).T
            if units is None:
                own = np.column_stack([shape.stroke / stroke, shape.duration / (half - tenth)])
                units = own * np.exp(_LAID * laid[:, :2])
                if (size := self.given.size) is not None:
                    units = np.where(np.isfinite(own), [size.lengths, size.times], np.nan)
            begins = _LAID * shape.duration * laid[:, 2 + i] - units[:, 1] * tenth
            travel, switching = readings(drives, closes, samples.times, begins, units)
            releases[motion], switchings[motion] = begins, switching
            travels.append(travel)
        theta = drives[:, : len(NAMES)] * np.exp(np.log(units) @ powers())
        return LevelDraws(theta, releases, switchings), travels

    def residuals(self, numbers: np.ndarray) -> np.ndarray:
        """Of the samples of all records, and of contacts that count, in sds, ``(n, r)``."""
        draws, travels = self.simulate(numbers)
        found = [s.residuals(t) for s, t in zip(self.samples, travels, strict=True)]
        for answer in self.timed:
            record = answer.record
            off = draws.switching[record.motion] - record.switched
            found.append(off[:, None] / record.raw.contact.sd)
        return np.hstack(found)

    @property
    def timed(self) -> list[Answer]:
        """Answers whose record has a contact that counts."""
        return [e for e in self.answers if e.record.timed and abs(e.surprise) <= SURPRISING]

    def draws(self, numbers: np.ndarray) -> tuple[LevelDraws, np.ndarray]:
        """Drives with sizes of mechanisms, and squares of their residuals, ``(n, r)``."""
        found, travels = self.simulate(numbers)
        residuals = [s.residuals(t) for s, t in zip(self.samples, travels, strict=True)]
        sizes = self.sizes(numbers)
        times = np.exp(
            (np.log(found.theta / numbers[:, : len(NAMES)]) @ np.linalg.pinv(powers()))[:, 1]
        )
        sizes["build_up"] = sizes["build_up"] * times
        squares = np.column_stack([np.square(each).sum(axis=1) for each in residuals])
        return replace(found, mechanisms={name: sizes[name] for name in MECHANISMS}), squares

    def sizes(self, numbers: np.ndarray) -> dict[str, np.ndarray]:
        """Sizes of mechanisms of drives of size 1, ``(n,)`` each."""
        drives = np.ascontiguousarray(numbers[:, :_DRIVE])
        stroke, tenth, half = landmarks(drives, self.scores.touch, True).T
        theta, elements = np.split(drives, [len(NAMES)], axis=1)
        return mechanism_sizes(theta, elements, drives[:, _CONTACT], stroke, half - tenth)


def exactly(
    answers: Sequence[Answer],
    given: Given,
    settings: AnswerSettings,
    progress: Callable[[str], None] = lambda _: None,
) -> list[Answer]:
    """Infer operations exactly in the family that their networks have chosen.

    Args:
        answers: What ``infer_drive`` returns. Rejected and foreign records stay as they are.
        given, settings: As of ``infer_drive``.
        progress: Takes a line for each step.

    Returns:
        The answers with draws of the exact posterior, and what it found, ``exact``; with a remark
        where it was not reached.

    Raises:
        ValueError: If a family has a simulator of its own.
    """
    groups: dict[tuple, list[Answer]] = {}
    for each in answers:
        if each.levels is not None and not each.misfit:
            operation = each.record.operation
            alone = each.motions if len(each.motions) == 1 else ()
            key = operation.number, operation.breaker, operation.phase, alone
            groups.setdefault(key, []).append(each)
    found = {}
    for k, (key, group) in enumerate(groups.items(), start=1):
        rng = generator(settings.seed, "exact posterior", *map(str, key))
        which = f"operation {key[0]} ({k} of {len(groups)}): " if len(groups) > 1 else ""

        def tell(line: str, which: str = which) -> None:
            progress(which + line)

        for new in _exact(group, given, settings, rng, tell):
            found[id(new.record)] = new
    return [found.get(id(each.record), each) for each in answers]


def _exact(answers, given, settings, rng, progress) -> list[Answer]:
    """The answers of one operation, exactly."""
    levels = answers[0].levels
    if simulator := levels.settings["drives"].get("simulator"):
        raise ValueError(
            f"the family {levels.settings['family']} is of another simulator, {simulator}, which "
            "tells no density of its drives: leave out --exact"
        )
    family = Family(Prior.from_settings(levels.settings["prior"]), levels.settings["drives"])
    records = [each.record for each in answers]
    samples = [
        RecordSamples.of(each.raw, each.tenth, each.shape.stroke, each.shape.duration)
        for each in records
    ]
    operation = _Operation(answers, given, FamilyScores.of(family, rng), samples)
    particles = Particles.of_prior(operation.target, PARTICLES, rng)
    lead(particles, progress)
    if particles.power < 1.0:
        said = (
            f"not exact: with {particles.simulated} drives the likelihood was reached to the power "
            f"{particles.power:.2g}; the networks' answer stands"
        )
        return [replace(each, remarks=(*each.remarks, said)) for each in answers]
    numbers, effective = walk(particles, progress)
    return _told(operation, particles, numbers, effective, settings)


def lead(particles: Particles, progress: Callable[[str], None]) -> None:
    """Lead particles to the posterior, or as near as so many drives bring them."""
    while particles.power < 1.0 and particles.simulated < _DRIVES:
        particles.temper()
        particles.learn_if_due(_EARLY)
        moved, rounds = 0.0, 0
        while moved < _MOVED and rounds < _MOST:
            taken, way = particles.round()
            moved, rounds = moved + way, rounds + 1
        progress(
            f"likelihood to the power {particles.power:.2g}: {particles.simulated} drives, "
            f"{taken:.0%} taken, moved {moved:.2f} in {rounds} rounds"
        )


def walk(particles: Particles, progress: Callable[[str], None]) -> tuple[np.ndarray, float]:
    """Walk until the effective size of the second half of the way is enough.

    Returns:
        Numbers of drives on it ``(d, q)``, and the effective size.
    """
    asked, numbers, effective = [], [], 0.0
    weights, rng = particles.weights, particles.rng
    for count in range(_ROUNDS):
        if count in _LEARNED:
            particles.learn(_LATE)
        taken, _ = particles.round()
        asked.append(particles.asked)
        numbers.append(particles.numbers[systematic(weights, len(weights), rng.random(), rng)])
        if count + 1 >= _FEWEST and not (count + 1) % 5:
            late = np.array(asked[len(asked) // 2 :])
            effective = particles.effective_size(late)
            progress(f"effective size {effective:.0f} of {ENOUGH:.0f}, {taken:.0%} taken")
            if effective >= ENOUGH:
                break
    return np.concatenate(numbers[len(numbers) // 2 :]), effective


def _told(operation, particles, numbers, effective, settings) -> list[Answer]:
    """The answers with draws of the exact posterior."""
    rng = particles.rng
    chosen = rng.permutation(len(numbers))[: settings.draws]
    draws, squares = operation.draws(numbers[chosen])
    told = with_draws(operation.answers, draws, operation.given, effective, LEAST, rng)
    contact = numbers[:, _CONTACT]
    about = {
        "effective_size": effective,
        "drives": particles.simulated,
        "log_evidence": particles.log_evidence,
        "log_evidence_se": particles.log_evidence_se,
        "contacts": operation.scores.shares_of(contact),
        "evidence": _evidence(operation, numbers[chosen], effective, rng),
    }
    found = []
    for i, (answer, new) in enumerate(zip(operation.answers, told, strict=True)):
        samples, both = operation.samples[i], [new.draws, answer.draws]
        logs = None if None in both else [np.log(each.theta) for each in both]
        exact = ExactFindings(
            family=answer.levels.settings["family"],
            p_value=float(samples.p_values(squares[:, i]).mean()),
            residual=samples.sd * float(np.sqrt(squares[:, i].mean() / samples.free)),
            noise=samples.sd,
            gap=None if logs is None else divergence(*logs),
            **about,
        )
        remarks = new.remarks
        if LEAST <= new.effective_size < ENOUGH:
            said = (
                f"few independent draws ({new.effective_size:.0f}, aimed at {ENOUGH:.0f}): ends of "
                "intervals and evidence differ from one seed to another"
            )
            remarks = (*remarks, said)
        found.append(replace(new, exact=exact, remarks=remarks))
    return found


def _evidence(operation, numbers, effective, rng) -> dict[str, float]:
    """Of each mechanism, and each kind of contact, that some drives of the family have, the
    logarithm of the odds that the drive has it, less that of drives of the family.
    """
    before = operation.scores.sample(_BEFORE, rng)

    def shares(there: np.ndarray) -> dict[str, float]:
        sizes = operation.sizes(there)
        kinds = operation.scores.shares_of(there[:, _CONTACT])
        return {name: float((sizes[name] > 0.0).mean()) for name in MECHANISMS} | kinds

    def log_odds(share: float, size: float) -> float:
        least = 0.5 / max(size, 1.0)
        share = min(max(share, least), 1.0 - least)
        return float(np.log(share / (1.0 - share)))

    after = shares(numbers)
    return {
        name: log_odds(after[name], effective) - log_odds(share, len(before))
        for name, share in shares(before).items()
        if 0.0 < share < 1.0
    }


def divergence(exact: np.ndarray, other: np.ndarray) -> float:
    """Kullback-Leibler divergence of two sets of draws ``(d, p)``, taken for normal, nats."""
    off = other.mean(axis=0) - exact.mean(axis=0)
    one, two = (np.cov(each, rowvar=False) for each in (exact, other))
    ratio = np.linalg.solve(two, one)
    square = off @ np.linalg.solve(two, off)
    return 0.5 * float(np.trace(ratio) - len(off) + square - np.linalg.slogdet(ratio)[1])
