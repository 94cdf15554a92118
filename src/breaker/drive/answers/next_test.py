r"""Which test of a drive next: by how much each of some would narrow what is known of it.

What a test narrows is its expected posterior variance, by the law of total variance
``Var z = E Var(z | test) + Var E(z | test)``: a test is foretold, not done. Drives are drawn from
the present posterior; each gives a result of the test, which the same networks answer, by the same
weights, and the variances are averaged.

- A test that says a number (a fact, the time of a contact) needs no record: each draw of the
  posterior gives a result, by which all draws are weighed.
- A test that gives records is simulated (``likely_drives``), and so are the records at hand, of the
  same drives. The ratio of both mean variances multiplies the present variance.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from tqdm import tqdm

from breaker.common.plain_values import Plain, plainly
from breaker.common.randomness import generator
from breaker.drive.answers.evidence import WITH_CONTACT, Answer, AnswerSettings, Given
from breaker.drive.answers.identity import mixed
from breaker.drive.answers.inference import infer_together, mean_of, weigh_draws
from breaker.drive.answers.likely_drives import Setup, likely_drives, operated, sizes_of
from breaker.drive.family.mechanisms import MECHANISMS
from breaker.drive.family.untold import APART
from breaker.drive.simulation.rich_drive import Drive
from breaker.mechanism.limits import Limit
from breaker.quantities.moving_mass import MASS_QUANTITIES
from breaker.quantities.parameters import MOTIONS, NAMES
from breaker.quantities.size import Size

_DRAWS = 2000  # of the present posterior
_RESULTS = 400  # results of a test that says a number
_SIZES = 24  # sizes that the drive may have
_DRIVES = 32  # that are simulated
_EACH = 1000  # draws for each of these
_FEWEST = 16  # drives or sizes, of which a mean is no accident
_A = {"closing": "a closing", "opening": "an opening"}
_UNITS = {"build_up": "ms"}  # of mechanisms; all others are shares

UNSIMULATED = "hardly a drive like this one could be simulated"
"""Why a test that gives records is not foretold."""


@dataclass(frozen=True)
class Narrowing(Plain):
    """What a test would make of one quantity.

    Attributes:
        kind: "parameter", "mechanism" or "limit".
        unit: Of both sds: "%" of a parameter's value, that of the size of a mechanism, and "1" of
            a limit, which is exceeded (1) or not (0).
        now, expected: Sd of the posterior, and root of its mean variance after the test.
        error: Standard error of ``expected``, by the number of results that were simulated.
    """

    kind: str
    unit: str
    now: float
    expected: float
    error: float

    @property
    def gone(self) -> float:
        """Share of the variance that the test would take away."""
        return 1.0 - (self.expected / self.now) ** 2 if self.now > 0.0 else 0.0


@dataclass(frozen=True)
class Outlook(Plain):
    """What a test would tell.

    Attributes:
        name, what: In the configuration, and in words.
        cost: In its unit.
        gain: Mean share of the variance that goes, of what is asked for.
        per_cost: That over the cost.
        narrowing: By name of the quantity; none of a test that is not foretold.
        adds: Sds of quantities that are not known without it, percent.
        reason: Why it is not foretold; empty if it is.
    """

    name: str
    what: str
    cost: float
    gain: float
    per_cost: float
    narrowing: Mapping[str, Narrowing]
    adds: Mapping[str, float]
    reason: str = ""


@dataclass(frozen=True)
class Plan(Plain):
    """The tests of a pole, that with most narrowing for its cost first.

    Attributes:
        breaker, phase: Which pole; empty where none is named.
        records: How many records of each motion are at hand.
        asked: Names of what is to be narrowed.
        tests: Those that can be done.
        reason: Why there is none; empty if there is one.
    """

    breaker: str
    phase: str
    records: Mapping[str, int]
    asked: Sequence[str]
    tests: Sequence[Outlook]
    reason: str = ""


@dataclass(frozen=True)
class Plans(Plain):
    """Which tests to do next, of each pole, as ``breaker plan`` prints them.

    Attributes:
        poles: One after the other.
        rejected: Why records could not be used, by file.
        settings: What is given and asked for.
    """

    poles: Sequence[Plan]
    rejected: Mapping[str, str]
    settings: Mapping[str, object]


@dataclass(frozen=True, eq=False)
class _Present:
    """What is known of a pole now.

    Attributes:
        answers: One of each motion, with the same draws.
        given, settings: As of ``infer_drive``.
        limits: That what is inferred may exceed.
        withheld: Names of what is not told of it.
    """

    answers: Sequence[Answer]
    given: Given
    settings: AnswerSettings
    limits: Sequence[Limit]
    withheld: frozenset[str]

    @property
    def records(self) -> dict[str, int]:
        """How many records of each motion there are."""
        return {each.record.motion: each.records for each in self.answers}

    def rng(self, *purpose: str | int) -> np.random.Generator:
        """Return the generator of a purpose, of this pole."""
        operation = self.answers[0].record.operation
        return generator(self.settings.seed, "next test", operation.number, *purpose)

    def columns(self, answers: Sequence[Answer]) -> dict[str, np.ndarray]:
        """Return draws of all that may be narrowed, ``(d,)`` each: logarithms of parameters, sizes
        of mechanisms, and whether limits are exceeded.
        """
        logs = np.log(answers[0].draws.theta)
        found = {name: logs[:, k] for k, name in enumerate(NAMES) if name not in self.withheld}
        found |= answers[0].draws.mechanisms
        for limit in self.limits:
            by = next((each for each in answers if each.record.motion == limit.motion), None)
            if by is None or not all(map(by.is_inferred, limit.quantities)):
                continue
            if not self.withheld & set(limit.quantities):
                drawn = np.column_stack([by.inferred(name) for name in limit.quantities])
                found[limit.name] = limit.exceeded(drawn).astype(float)
        return found

    @cached_property
    def now(self) -> dict[str, np.ndarray]:
        """The columns of the present draws."""
        return self.columns(self.answers)

    @cached_property
    def variance(self) -> np.ndarray:
        """Of each of the columns, ``(q,)``."""
        return np.array([each.var() for each in self.now.values()])


@dataclass(frozen=True, eq=False)
class _Candidate:
    """A test that can be done.

    Attributes:
        name, what, cost: As of an outlook.
        numbers: What it says: draws of it and their sds of its error, ``(d,)`` each.
        setup: Which records it gives; None of one that gives none.
        sized: Whether it says the size.
        adds: As of an outlook.
    """

    name: str
    what: str
    cost: float
    numbers: Sequence[tuple[np.ndarray, np.ndarray]] = ()
    setup: Setup | None = None
    sized: bool = False
    adds: Mapping[str, float] = field(default_factory=dict)


def plan(
    answers: Sequence[Answer],
    given: Given,
    settings: AnswerSettings,
    limits: Sequence[Limit],
    tests: Mapping[str, Any],
    asked: Sequence[str] = (),
) -> Plans:
    """Foretell what each test would narrow, of each pole.

    Args:
        answers: What ``infer_drive`` returns of the records.
        given, settings: As of ``infer_drive``.
        limits: Those of the configuration.
        tests: The section ``next_tests`` of the configuration.
        asked: Names of what is to be narrowed; all parameters if there is none.

    Raises:
        ValueError: If something else is asked for than what may be narrowed.
    """
    rejected = {str(e.record.operation.file): e.record.reason for e in answers if e.record.reason}
    poles: dict[tuple, list[Answer]] = {}
    for each in answers:
        if not each.record.reason:
            pole = each.record.operation.breaker, each.record.operation.phase
            poles.setdefault(pole, []).append(each)
    several = {key[:2]: why for key, why in mixed([each.record for each in answers]).items()}
    found = []
    for pole, some in poles.items():
        if pole in several:
            found.append(Plan(*pole, {}, (), (), several[pole]))
        else:
            found.append(_plan_pole(some, given, settings, limits, tests, asked))
    about = {"seed": settings.seed, "known": dict(given.known), "narrow": [*asked]}
    return plainly(Plans(found, rejected, about | {"size": given.size and vars(given.size)}))


def _plan_pole(
    answers: Sequence[Answer],
    given: Given,
    settings: AnswerSettings,
    limits: Sequence[Limit],
    tests: Mapping[str, Any],
    asked: Sequence[str],
) -> Plan:
    """The tests of one pole, all of whose records can be used."""
    first = answers[0].record.operation
    usable = [each for each in answers if each.draws is not None]
    by = {m: [each for each in usable if each.record.motion == m] for m in MOTIONS}
    by = {motion: some for motion, some in by.items() if some}
    about = first.breaker, first.phase, {motion: len(some) for motion, some in by.items()}
    if not usable:
        return Plan(*about, (), (), answers[0].why_not_inferred)
    one = [mean_of(some) if len(some) > 1 else some[0] for some in by.values()]
    one = infer_together(one, given, replace(settings, draws=_DRAWS))
    if one[0].unresolved:
        return Plan(*about, (), (), one[0].why_not_inferred)
    if one[0].draws is not one[-1].draws:
        return Plan(*about, (), (), f"{APART}; take one of them by --motion")
    withheld = WITH_CONTACT if any(each.may_slide for each in one) else ()
    present = _Present(one, given, settings, limits, frozenset(withheld))
    if wrong := [name for name in asked if name not in present.now]:
        known = ", ".join(present.now)
        raise ValueError(f"--narrow {wrong[0]}: of this drive can be narrowed: {known}")
    asked = tuple(asked) or tuple(name for name in present.now if name in NAMES)
    found = _foretold(present, _candidates(present, tests), asked)
    return Plan(*about, asked, sorted(found, key=lambda each: -each.per_cost))


def _candidates(present: _Present, tests: Mapping[str, Any]) -> list[_Candidate]:
    """The tests that can be done; those whose cost is null are left out."""
    answers, given, records = present.answers, present.given, present.records
    draws, first = answers[0].draws, answers[0]
    costs = {name: each["cost"] for name, each in tests.items() if name != "facts"}
    found = []
    for name, fact in tests["facts"].items():
        if name not in given.known and fact["cost"] is not None:
            value = first.inferred(name)
            whole = value if name in NAMES else np.full_like(value, first.record.shape.stroke)
            said = ((value, fact["sd"] * whole),)
            found.append(_Candidate(name, fact["what"], fact["cost"], said))
    if untimed := [each for each in answers if not each.record.timed]:
        what = f"record the main contact beside the travel of {_of(untimed)}"
        sds = [np.array([each.record.raw.settings["timing_sd"]]) for each in untimed]
        times = [draws.switching[each.record.motion] for each in untimed]
        said = [*zip(times, sds, strict=True)]
        found.append(_Candidate("contact", what, costs["contact"], said))
    if given.size is None:
        what = "look up the size of the type, for --size"
        found.append(_Candidate("size", what, costs["size"], sized=True))
    if given.mass is None:
        sd = tests["moving_mass"]["sd"]
        logs = dict(zip(NAMES, np.log(draws.theta).std(axis=0), strict=True))
        adds = {e.name: 100.0 * float(np.hypot(logs[e.of], sd)) for e in MASS_QUANTITIES}
        what = "weigh the moving mass: forces in N, springs in N/m"
        found.append(_Candidate("moving_mass", what, costs["moving_mass"], adds=adds))
    more = tests["more_records"]["records"]
    what = f"take {more} more records of {_of(answers)}"
    setup = Setup({motion: count + more for motion, count in records.items()})
    found.append(_Candidate("more_records", what, costs["more_records"], setup=setup))
    for motion in set(MOTIONS) - set(records):
        setup, cost = Setup(records | {motion: 1}), costs["other_motion"]
        found.append(_Candidate("other_motion", f"record {_A[motion]}", cost, setup=setup))
    share = tests["finer_transducer"]["noise"]
    what = f"record again by a transducer with {100.0 * share:g} % of the noise"
    setup, cost = Setup(records, share), costs["finer_transducer"]
    found.append(_Candidate("finer_transducer", what, cost, setup=setup))
    return [each for each in found if each.cost is not None]


def _of(answers: Sequence[Answer]) -> str:
    return " and ".join(each.record.motion for each in answers)


def _foretold(
    present: _Present, candidates: Sequence[_Candidate], asked: Sequence[str]
) -> list[Outlook]:
    """What each candidate would tell."""
    setups = {each.name: each.setup for each in candidates if each.setup is not None}
    simulated = _by_records(present, setups) if setups else {}
    found = []
    for each in candidates:
        if each.setup is not None:
            shares = simulated.get(each.name)
        elif each.sized:
            shares = _by_size(present)
        else:
            shares = _by_numbers(present, each)
        found.append(_outlook(present, each, shares, asked))
    return found


def _outlook(
    present: _Present,
    candidate: _Candidate,
    shares: tuple[np.ndarray, np.ndarray] | None,
    asked: Sequence[str],
) -> Outlook:
    """A candidate with what it would tell, by shares of variances and their errors, ``(q,)``."""
    about = candidate.name, candidate.what, candidate.cost
    if shares is None:
        return Outlook(*about, 0.0, 0.0, {}, candidate.adds, UNSIMULATED)
    narrowing = {}
    for name, variance, share, error in zip(present.now, present.variance, *shares, strict=True):
        kind = "mechanism" if name in MECHANISMS else "limit"
        kind, factor = ("parameter", 100.0) if name in NAMES else (kind, 1.0)
        unit = {"parameter": "%", "limit": "1"}.get(kind, _UNITS.get(name, "1"))
        now = factor * np.sqrt(variance)
        expected = now * np.sqrt(share)
        sd = 0.5 * now * error / np.sqrt(share) if share > 0.0 else 0.0
        narrowing[name] = Narrowing(kind, unit, float(now), float(expected), float(sd))
    gain = float(np.mean([narrowing[name].gone for name in asked]))
    return Outlook(*about, gain, gain / candidate.cost, narrowing, candidate.adds)


def _shares(after: np.ndarray, before: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Ratio of mean variances ``(r, q)``, and its standard error, ``(q,)``; 1 where nothing is
    unknown before.
    """
    middle = before.mean(axis=0)
    unit = np.where(middle > 0.0, middle, 1.0)
    share = np.where(middle > 0.0, after.mean(axis=0) / unit, 1.0)
    left = (after - share * before) / unit
    return share, left.std(axis=0, ddof=1) / np.sqrt(len(after))


def _by_numbers(present: _Present, candidate: _Candidate) -> tuple[np.ndarray, np.ndarray]:
    """Shares of a test that says numbers, by weights of the present draws; 1 if it says none."""
    if not candidate.numbers:
        return np.ones(len(present.now)), np.zeros(len(present.now))
    columns = np.column_stack([*present.now.values()])
    rng = present.rng("numbers", candidate.name)
    truths = rng.choice(len(columns), _RESULTS, replace=False)
    log = np.zeros((_RESULTS, len(columns)))
    for values, sds in candidate.numbers:
        sds = np.broadcast_to(sds, values.shape)[truths, None]
        said = values[truths, None] + sds * rng.standard_normal((_RESULTS, 1))
        log -= 0.5 * np.square((values - said) / sds)
    weights = np.exp(log - log.max(axis=1, keepdims=True))
    after = _variances(columns, weights)
    return _shares(after, np.broadcast_to(present.variance, after.shape))


def _variances(columns: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Variances of draws ``(d, q)`` by weights ``(r, d)``, ``(r, q)``."""
    weights = weights / weights.sum(axis=-1, keepdims=True)
    off = columns - columns.mean(axis=0)
    return np.maximum(weights @ np.square(off) - np.square(weights @ off), 0.0)


def _variance_of(
    present: _Present, answers: Sequence[Answer], size: Size | None, rng: np.random.Generator
) -> np.ndarray | None:
    """Variances of what networks answer of records, ``(q,)``; None where no draw is possible."""
    seen = {each.record.motion: each.record.seen for each in answers}
    draws = present.answers[0].levels.draw(seen, _EACH, rng, size=size)
    left, new, shares = weigh_draws(answers, draws, present.given, size)
    columns = present.columns(new)
    wanted = np.column_stack([columns[name] for name in present.now])
    return _variances(wanted, shares[None])[0] if left else None


def _by_size(present: _Present) -> tuple[np.ndarray, np.ndarray] | None:
    """Shares of a test that says the size; None where the networks hardly answer with one."""
    rng, first = present.rng("size"), present.answers[0]
    theta = first.draws.theta[rng.choice(len(first.draws.theta), _SIZES, replace=False)]
    sizes = sizes_of(first, present.given, theta, rng)
    after = [_variance_of(present, present.answers, size, rng) for size in sizes]
    after = np.array([each for each in after if each is not None])
    if len(after) < _FEWEST:
        return None
    return _shares(after, np.broadcast_to(present.variance, after.shape))


def _by_records(
    present: _Present, setups: Mapping[str, Setup]
) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Shares of tests that give records, by name; none where hardly a drive can be simulated."""
    drives = likely_drives(present.answers, present.given, _DRIVES, present.rng("drives"))
    every = {"": Setup(present.records), **setups}
    found = {name: [] for name in every}
    for k, drive in enumerate(tqdm(drives, desc="drives that it may be", mininterval=1)):
        try:
            some = {name: _after(present, drive, setup, k) for name, setup in every.items()}
        except (FloatingPointError, ValueError):  # a drive whose record would be refused
            continue
        if all(each is not None for each in some.values()):
            for name, each in some.items():
                found[name].append(each)
    if len(found[""]) < _FEWEST:
        return {}
    before, *after = (np.array(each) for each in found.values())
    return {name: _shares(each, before) for name, each in zip(setups, after, strict=True)}


def _after(present: _Present, drive: Drive, setup: Setup, k: int) -> np.ndarray | None:
    """Variances after records of the k-th drive; of all setups by the same random numbers."""
    rng = present.rng("records", k)
    answers = operated(drive, present.answers, setup, rng)
    return _variance_of(present, answers, present.given.size, present.rng("answers", k))
