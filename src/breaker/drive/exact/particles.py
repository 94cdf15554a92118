"""Particles that go from a prior of normal scores to a posterior: tempered, then walking.

Tempering raises the power of the likelihood from 0 to 1 in steps that leave half of the particles
(Del Moral et al. 2006, J. R. Stat. Soc. B 68, 411), and its weights, averaged over all rounds at a
power, give the evidence. Between the steps, and at the end for as long as the answer needs,
particles move in rounds. A round walks on the likelihood that an emulator tells, by trajectories
(Hamiltonian Monte Carlo) of the scores that move a drive smoothly, by drawing others anew, and by
jumps that the target knows (Green 1995, Biometrika 82, 711). Where a walk ends, the simulator says
with which probability the particle goes there (Liu 2001, Monte Carlo Strategies in Scientific
Computing, 9.4.3): the posterior is exact whatever the emulator tells, and a poor one only takes
longer. What is simulated teaches the next emulator; along which axes trajectories go is learned at
the same times, and not in between, so that a walk is reversible.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial, partialmethod

import numpy as np
from scipy.special import logsumexp

from breaker.common.randomness import systematic
from breaker.drive.exact.at_once import at_once
from breaker.drive.exact.residual_emulator import ResidualEmulator

_LEFT = 0.5  # effective share of the particles after a step of tempering
_HALVINGS = 60
_FIRST = 40_000  # draws of the prior, of which the first emulator learns
_KEPT = 120_000  # simulated drives, of which an emulator learns at most
_FAR = 400.0  # nats below the middle, times the power, of which none is
_RISES = 1.8  # of the power, from one emulator to the next
_LENGTH, _LEAPS = 2.0, (4, 32)  # of a trajectory, and its least and most steps
_INFORMED = 0.7  # variance of scores, below which the record shows them
_MOVES = {"_trajectory": 1, "_redrawn": 8}  # of a walk
_JUMPS = {"_switched": 8, "_exchanged": 8}  # of one, where the target knows any
_REDRAWN = 40.0  # scores, of which at most so many are drawn anew at once
_DEPENDENT = 3.0  # by how much the variance of evidence exceeds that of independent particles
_GIVEN_UP = 7.0  # nats below the likeliest kind, at which a kind is given up
_FOLLOWED = {"_trajectory": ("step", 0.7, 0.6), "_redrawn": ("redrawn", 0.25, 1.0)}
"""Sizes of moves, the shares that are taken to which they are led, and their most."""
_RATE = 0.3  # how fast


@dataclass(frozen=True, eq=False)
class Target:
    """What particles are led to.

    Attributes:
        unknowns: Scores m.
        numbers: What a drive's curves depend on, of scores ``(n, m)``, ``(n, q)``.
        inputs: What an emulator sees of these, ``(n, q)``.
        traced: This of scores, and what takes slopes by it to slopes by scores.
        residuals: Of these, in units of the noise, ``(n, r)``; nan of what is no drive.
        kinds: Which of the enumerated kinds scores are of, ``(n,)``.
        shares: Of kinds in the prior, ``(k,)``.
        fixed: Scores that tell the kind.
        asked: What is asked, of numbers, ``(n, a)``.
        redrawn: Draws scores anew that move no number, given these.
        switched: Jumps from scores, one of two ways, and tells with which ratio of densities, as
            ``FamilyScores.switched`` does; None if nothing can come or go.
    """

    unknowns: int
    numbers: Callable[[np.ndarray], np.ndarray]
    inputs: Callable[[np.ndarray], np.ndarray]
    traced: Callable[[np.ndarray], tuple[np.ndarray, Callable[[np.ndarray], np.ndarray]]]
    residuals: Callable[[np.ndarray], np.ndarray]
    kinds: Callable[[np.ndarray], np.ndarray]
    shares: np.ndarray
    fixed: Sequence[int]
    asked: Callable[[np.ndarray], np.ndarray]
    redrawn: Callable[[np.ndarray, np.random.Generator], np.ndarray]
    switched: Callable[..., tuple[np.ndarray, np.ndarray]] | None = None


@dataclass(eq=False)
class _Widths:
    """Sizes of moves, which follow how many are taken."""

    step: float = 0.15
    redrawn: float = 0.5

    def follow(self, name: str, target: float, most: float, taken: float) -> None:
        size = getattr(self, name) * np.exp(_RATE * (taken - target))
        setattr(self, name, float(np.clip(size, 0.005, most)))


@dataclass(eq=False)
class Particles:
    """Particles at a power of the likelihood.

    Attributes:
        target: What they are led to.
        size: How many they are, after the first tempering.
        rng: Of all moves.
        scores: ``(n, m)``.
        numbers: Their drives.
        log_like: Log likelihoods, ``(n,)``.
        ancestor: Which particle of the prior each descends from, ``(n,)``.
        kind: Of each, ``(n,)``: kinds are enumerated, and each has particles of its own.
        log_shares: Of each kind, the logarithm of its prior times its evidence so far, ``(k,)``;
            -inf of one that is given up.
        variances: Of these, by Monte Carlo, ``(k,)``.
        power: Of the likelihood.
        simulated: How many drives.
        visited: Log likelihoods after each round at this power: evidence is told by all of them.
        smooth: Scores that move a drive smoothly, ``(s,)``.
    """

    target: Target
    size: int
    rng: np.random.Generator
    scores: np.ndarray
    numbers: np.ndarray
    log_like: np.ndarray
    ancestor: np.ndarray
    kind: np.ndarray
    log_shares: np.ndarray
    variances: np.ndarray
    power: float = 0.0
    simulated: int = 0
    emulator: ResidualEmulator | None = None
    learned_at: float = 0.0
    widths: _Widths = field(default_factory=_Widths)
    seen: list = field(default_factory=list)
    visited: list = field(default_factory=list)
    smooth: np.ndarray | None = None
    axes: np.ndarray | None = None

    @classmethod
    def of_prior(cls, target: Target, n: int, rng: np.random.Generator) -> "Particles":
        """Draw from the prior many more than ``n``, of which the first tempering leaves n.

        Raises:
            ValueError: If hardly a draw of the prior moves.
        """
        new = cls(target, n, rng, *[np.empty(0)] * 7)
        scores = rng.standard_normal((_FIRST, target.unknowns))
        numbers, log_like = new.simulate(scores)
        works = np.flatnonzero(np.isfinite(log_like))
        if works.size < n:
            raise ValueError(f"of {_FIRST} draws of the family only {works.size} move")
        new.scores, new.numbers, new.log_like = scores[works], numbers[works], log_like[works]
        new.ancestor, new.kind = np.arange(works.size), target.kinds(scores[works])
        with np.errstate(divide="ignore"):
            drawn = np.bincount(new.kind, minlength=len(target.shares)) > 0
            new.log_shares = np.log(np.where(drawn, target.shares, 0.0))
        new.variances = np.zeros(len(target.shares))
        new.smooth = smooth_scores(target, scores[works[:40]])
        return new

    def simulate(self, scores: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Numbers of drives, and their log likelihoods, which emulators learn from."""
        halves = (partial(self._simulated, each) for each in np.array_split(scores, 2))
        numbers, residuals = map(np.concatenate, zip(*at_once(*halves), strict=True))
        self.simulated += len(scores)
        log_like = -0.5 * np.square(residuals).sum(axis=1)
        works = np.isfinite(log_like)
        inputs = self.target.inputs(numbers[works])
        self.seen.append((inputs, residuals[works].astype(np.float32), log_like[works]))
        return numbers, np.where(works, log_like, -np.inf)

    def _simulated(self, scores: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        numbers = self.target.numbers(scores)
        return numbers, self.target.residuals(numbers)

    def learn(self, steps: int) -> None:
        """Learn an emulator from the drives that are near enough at this power."""
        seen = [np.concatenate(each) for each in zip(*self.seen, strict=True)]
        near = self.power * (np.median(self.log_like) - seen[-1]) < _FAR
        chosen = np.flatnonzero(near)[-_KEPT:]
        inputs, residuals, log_like = (each[chosen] for each in seen)
        self.seen = [(inputs, residuals, log_like)]
        given = inputs, residuals, self.power, steps, self.rng
        self.emulator, self.learned_at = ResidualEmulator.fit(*given, self.emulator), self.power
        self._learn_axes()

    def _learn_axes(self) -> None:
        """Learn along which axes of the smooth scores, and how far, particles vary."""
        variances, axes = np.linalg.eigh(np.cov(self.scores[:, self.smooth].T))
        shown = variances < _INFORMED
        self.axes = axes * np.sqrt(np.where(shown, np.maximum(variances, 1e-4), 1.0))

    def learn_if_due(self, steps: int) -> None:
        """Learn an emulator where the power has risen enough since the last."""
        if self.emulator is None or self.power > _RISES * self.learned_at:
            self.learn(steps)

    def temper(self) -> None:
        """Raise the power as far as it leaves half of the particles of each kind, and draw these by
        their weights. A kind that is hardly possible is given up for the others.
        """
        there = np.flatnonzero(np.isfinite(self.log_shares))
        groups = [np.flatnonzero(self.kind == k) for k in there]
        count = self.size // there.size

        def enough(by: float) -> bool:  # a kind that is rare in the prior has fewer from the first
            return all(_left(self.log_like[g], by) >= _LEFT * min(count, g.size) for g in groups)

        low = high = 1.0 - self.power
        if not enough(high):
            low = 0.0
            for _ in range(_HALVINGS):
                middle = 0.5 * (low + high)
                low, high = (middle, high) if enough(middle) else (low, middle)
        visited = np.array(self.visited or [self.log_like])
        for k, group in zip(there, groups, strict=True):
            most = visited[:, group].max()
            means = np.exp(low * (visited[:, group] - most)).mean(axis=0)
            self.log_shares[k] += low * most + np.log(means.mean())
            self.variances[k] += _DEPENDENT * means.var() / means.mean() ** 2 / group.size
        self.log_shares[self.log_shares < self.log_shares.max() - _GIVEN_UP] = -np.inf
        self.power = 1.0 if low == 1.0 - self.power else self.power + low
        kept = [g for k, g in zip(there, groups, strict=True) if np.isfinite(self.log_shares[k])]
        counts = [each.size for each in np.array_split(np.arange(self.size), len(kept))]
        drawn = zip(kept, counts, strict=True)
        chosen = []
        for group, n in drawn:
            weights = np.exp(low * (self.log_like[group] - self.log_like[group].max()))
            chosen.append(group[systematic(weights, n, self.rng.random(), self.rng)])
        chosen = np.concatenate(chosen)
        for name in ("scores", "numbers", "log_like", "ancestor", "kind"):
            setattr(self, name, getattr(self, name)[chosen])
        self.visited = []
        self._learn_axes()

    @property
    def log_evidence(self) -> float:
        """Of the family so far, nats, but for a constant of the record."""
        return float(logsumexp(self.log_shares))

    @property
    def log_evidence_se(self) -> float:
        """Its standard error."""
        return float(np.sqrt(np.square(self.shares) @ self.variances))

    @property
    def shares(self) -> np.ndarray:
        """Posterior probability of each kind, ``(k,)``."""
        return np.exp(self.log_shares - self.log_evidence)

    @property
    def weights(self) -> np.ndarray:
        """Weights of particles, by the shares of their kinds, ``(n,)``; their sum is 1."""
        found = self.shares
        return found[self.kind] / np.bincount(self.kind, minlength=found.size)[self.kind]

    def effective_size(self, walked: np.ndarray) -> float:
        """How many independent draws tell the means of walked particles as well.

        Within a kind, means vary as those of families of one ancestor do; between kinds, as the
        evidence does.

        Args:
            walked: What is asked of each particle at each time, ``(t, n, a)``.
        """
        weights, over = self.weights, walked.mean(axis=0)
        middle, error = weights @ over, 0.0
        for k in np.flatnonzero(self.shares):
            own = self.kind == k
            of_kind = over[own].mean(axis=0)
            families = np.zeros((int(self.ancestor.max()) + 1, middle.size))
            np.add.at(families, self.ancestor[own], weights[own, None] * (over[own] - of_kind))
            error = error + np.square(families).sum(axis=0)
            error = error + self.shares[k] ** 2 * self.variances[k] * np.square(of_kind - middle)
        variance = weights @ np.square(walked - middle).mean(axis=0)
        return float((variance / error).min())

    @property
    def asked(self) -> np.ndarray:
        """What is asked of each, ``(n, a)``."""
        return self.target.asked(self.numbers)

    def round(self) -> tuple[float, float]:
        """Walk once.

        Returns:
            The share that goes where its walk ended, and the mean square of the way in what is
            asked, over its variance.
        """
        self.scores = self.target.redrawn(self.scores, self.rng)
        asked = self.asked
        walked, gained = self._walked()
        numbers, log_like = self.simulate(walked)
        ratio = self.power * (log_like - self.log_like) - gained
        to = np.log(self.rng.random(self.size)) < ratio
        self.scores[to], self.numbers[to], self.log_like[to] = walked[to], numbers[to], log_like[to]
        self.visited.append(self.log_like.copy())
        way = np.square(self.asked - asked).mean(axis=0) / asked.var(axis=0)
        return float(to.mean()), float(way.min())

    def _walked(self) -> tuple[np.ndarray, np.ndarray]:
        """Where particles walk on the emulator, ``(n, m)``, and what it says that they gain there,
        at the power, nats.
        """
        halves = zip(np.array_split(self.scores, 2), self.rng.spawn(2), strict=True)
        moves = _MOVES | (_JUMPS if self.target.switched else {})
        order = self.rng.permutation(np.repeat(list(moves), list(moves.values())))
        found = at_once(*(partial(self._half_walked, *each, order) for each in halves))
        scores, gained, shares = zip(*found, strict=True)
        for move, share in zip(order, np.mean(shares, axis=0), strict=True):
            if move in _FOLLOWED:
                self.widths.follow(*_FOLLOWED[move], share)
        return np.concatenate(scores), self.power * np.concatenate(gained)

    def _half_walked(self, scores, rng, order):
        """Where some walk, what they gain, and the share of each move that is taken."""
        first = log = self._log_like(scores)
        shares = []
        for move in order:
            scores, log, share = getattr(self, move)(scores, log, rng)
            shares.append(share)
        return scores, log - first, shares

    def _log_like(self, scores: np.ndarray) -> np.ndarray:
        """Log likelihoods by the emulator."""
        return self.emulator.log_likelihood(self.target.inputs(self.target.numbers(scores)))

    def _redrawn(self, scores, log, rng):
        """Some scores drawn anew, in whole or in part."""
        n, m = scores.shape
        count = np.exp(rng.uniform(0.0, np.log(_REDRAWN), n))
        size = self.widths.redrawn * np.sqrt(20.0 / count) * np.exp(0.5 * rng.standard_normal(n))
        part = (rng.random((n, m)) < (count / m)[:, None]) * np.clip(size, 0.0, 1.0)[:, None]
        there = np.sqrt(1.0 - part**2) * scores + part * rng.standard_normal((n, m))
        there[:, self.target.fixed] = scores[:, self.target.fixed]
        return self._chosen(scores, log, rng, there)

    def _switched(self, scores, log, rng, exchanged=False):
        """Jumps of the target."""
        return self._chosen(scores, log, rng, *self.target.switched(scores, exchanged, rng))

    _exchanged = partialmethod(_switched, exchanged=True)

    def _chosen(self, scores, log, rng, there, over=0.0):
        """What a Metropolis step takes of other scores, as far as the emulator tells.

        Args:
            over: Logarithm of the ratio of densities beside the likelihoods.
        """
        new = self._log_like(there)
        ok = np.log(rng.random(len(scores))) < self.power * (new - log) + over
        return np.where(ok[:, None], there, scores), np.where(ok, new, log), ok.mean()

    def _trajectory(self, scores, log, rng):
        """Where trajectories of the smooth scores end."""
        own, axes, n = self.smooth, self.axes, len(scores)
        step = self.widths.step * np.exp(0.2 * rng.standard_normal())
        leaps = int(np.clip(_LENGTH / step, *_LEAPS))
        speed = rng.standard_normal((n, own.size))
        there = scores.copy()
        first, slope = self._slope(there)
        begin = self.power * first + self._rest(there, speed)
        with np.errstate(invalid="ignore", over="ignore"):  # far beyond the drives that there are
            for _ in range(leaps):
                speed = speed + 0.5 * step * slope @ axes
                there[:, own] += step * speed @ axes.T
                new, slope = self._slope(there)
                speed = speed + 0.5 * step * slope @ axes
            gain = self.power * new + self._rest(there, speed) - begin
            share = np.exp(np.minimum(np.where(np.isfinite(gain), gain, -np.inf), 0.0))
        ok = rng.random(n) < share
        return np.where(ok[:, None], there, scores), np.where(ok, new, log), share.mean()

    def _rest(self, scores, speed):
        return -0.5 * (np.square(scores).sum(axis=1) + np.square(speed).sum(axis=1))

    def _slope(self, scores):
        """Log likelihoods by the emulator, and the slopes of the log densities at the power, by the
        smooth scores.
        """
        inputs, back = self.target.traced(scores)
        log, slopes = self.emulator.slopes(inputs)
        return log, self.power * back(slopes)[:, self.smooth] - scores[:, self.smooth]


def smooth_scores(target: Target, examples: np.ndarray) -> np.ndarray:
    """Which scores move an input smoothly, in any of some examples ``(n, m)``.

    Those that decide whether something is there do not.
    """
    inputs, back = target.traced(examples)
    moves = np.zeros(target.unknowns, dtype=bool)
    for one in np.eye(inputs.shape[1]):
        moves |= back(np.tile(one, (len(examples), 1))).any(axis=0)
    return np.flatnonzero(moves)


def _left(log_like: np.ndarray, by: float) -> float:
    """Effective number of particles with a power of their likelihoods as weights."""
    weights = np.exp(by * (log_like - log_like.max()))
    return float(weights.sum() ** 2 / np.square(weights).sum())
