"""Conditions on several keys of the configuration, which a schema cannot express: ``RULES``.

A rule is a pair: keys, the first of which a message is about, and a function that takes what they
hold and yields what is wrong and the remedy.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from typing import Any

from breaker.configuration.inspection_interval import interval_of
from breaker.configuration.magnitudes import FOLDER, MAGNITUDES, listed, refused
from breaker.model.limits import entries_of_type, from_list
from breaker.model.parameters import MOTIONS, NAMES
from breaker.model.quantities import check_fact, check_quantity, every_speed, speeds_of
from breaker.reading.files.operations_table import event_words
from breaker.reading.files.word_meanings import bare


def _at_most(limit: str, value: float, most: float) -> Iterator[str]:
    if value > most:
        yield f"is {value}, but must not exceed {limit} ({most}). Lower it, or raise {limit}."


def _bank(bank: Mapping[str, int], training: Mapping[str, Any]) -> Iterator[str]:
    curves = bank["shards"] * bank["curves_per_shard"]
    needs = sum(training[key] for key in ("batch", "validation_curves", "held_out_curves"))
    if curves < needs:
        yield (
            f"has {curves} curves (shards times curves_per_shard), but a training needs {needs} "
            "(batch + validation_curves + held_out_curves). Raise one of the first two, or lower "
            "one of these."
        )


def _solver(reference: int, candidates: Sequence[int]) -> Iterator[str]:
    if reference <= max(candidates):
        yield f"is {reference}, but must be more than any of solver.candidates ({max(candidates)})."


def _other_seed(second: int, seed: int) -> Iterator[str]:
    if second == seed:
        yield f"is {second}, which validation.seed is too. A second look needs another number."


def _range(ends: Sequence[float]) -> Iterator[str]:
    low, high = ends
    if low >= high:
        yield f"is {ends}, but the first must be less than the second."


def _from_to(section: Mapping[str, Any]) -> Iterator[str]:
    """A section at any depth of ranges from and to, which may be equal."""
    for name, value in section.items():
        if isinstance(value, Mapping):
            if below := " ".join(_from_to(value)):
                yield f"{name}: {below}"
        elif value[0] > value[1]:
            yield f"{name} is {value}, but the first must not exceed the second."


def _wear(wear: Mapping[str, Any]) -> Iterator[str]:
    """Counts of what changes, against what there is to change."""
    names = [name in NAMES for name in wear["change"]]
    for kind, there in (("parameters", sum(names)), ("elements", len(names) - sum(names))):
        least, most = wear[kind]
        if not least <= most <= there:
            yield (
                f"has {kind}: {wear[kind]}, but the first must not exceed the second, nor the "
                f"second the number of {kind} that can change ({there})."
            )
            return


def _some_cost(service: float) -> Iterator[str]:
    if not service:
        yield (
            "is 0, so a service costs nothing and would always be due. State a cost, in the unit "
            "of planning.failure_cost."
        )


def _dearer(failure: float, service: float) -> Iterator[str]:
    if service and failure <= service:
        yield (
            f"is {failure:g}, not more than planning.service_cost ({service:g}): then no service "
            "pays. Raise it, or lower planning.service_cost."
        )


_speeds = partial(refused, "cannot be used. {}.", speeds_of)


def _limits(
    entries: Sequence[Mapping[str, Any]],
    motions: Sequence[str],
    speeds: Mapping[str, Sequence[str] | None],
) -> Iterator[str]:
    if any(_speeds(speeds)):
        return
    defined, limits, wrong = every_speed(speeds), [], []
    for entry in entries:
        try:
            limits += from_list([entry], MOTIONS, defined)
        except ValueError as error:
            wrong.append(str(error))
    names = [entry["name"] for entry in entries if "name" in entry]
    names += [limit.name for limit in limits if limit.pair]
    wrong += [
        f"{name}: there are two limits of this name. Give one another name."
        for name in sorted({each for each in names if names.count(each) > 1})
    ]
    if wrong:
        yield f"cannot be used. {' '.join(wrong)}"
    # There may be limits of motions that are not worked on, but not only such.
    elif not any(limit.motion in (*motions, "") for limit in limits):
        yield f"has no limit of {' or '.join(motions)} (motions). Add one."


def _by_type(
    by_type: Mapping[str, Mapping[str, Sequence[float | None]]],
    speeds: Mapping[str, Sequence[str] | None],
) -> Iterator[str]:
    """Limits by type, and types, each of which must be there once, however it is spelt."""
    if any(_speeds(speeds)):
        return
    defined, spelt = every_speed(speeds), {}
    for name, ranges in by_type.items():
        if not bare(name):
            yield f"has {name!r}, which is no name of a type. Write one."
        elif (before := spelt.setdefault(bare(name), name)) != name:
            yield f"has {before} and {name}, which are one type. Put both together."
        try:
            entries_of_type(ranges, defined)
        except ValueError as error:
            yield f"cannot be used: {name}: {error}"


def _known(
    known: Mapping[str, Sequence[float]],
    speeds: Mapping[str, Sequence[str] | None],
) -> Iterator[str]:
    if any(_speeds(speeds)):
        return
    defined = speeds_of(speeds)
    for name in known.keys() - {"mass"}:
        complaints = [check_quantity(name, motion, defined) for motion in MOTIONS]
        if all(complaints):
            yield "cannot be used. " + " ".join(complaints)
    for name, fact in known.items():
        if complaint := check_fact(name, *fact):
            yield f"has {name}: {fact}, which {complaint}"


def _contact_lag(contact_lag: Mapping[str, Sequence[float]]) -> Iterator[str]:
    for motion, (_, sd) in contact_lag.items():
        if motion not in MOTIONS:
            yield f"has {motion}, but can have {' and '.join(MOTIONS)} alone."
        if sd <= 0.0:
            yield f"has {motion} with the standard deviation {sd:g}, but must have one above 0."


def _choice(choice: str | None, curves: str | None) -> Iterator[str]:
    if choice is not None and curves is None:
        yield f"is {choice}, but the stand-in is one breaker with one phase. Set it to null."


def _events(events: Mapping[str, Sequence[str]]) -> Iterator[str]:
    """Names of events, each of which must be there once, however it is written."""
    named = {}
    for key in events:
        if not event_words(key):
            yield f"has {key!r}, which is no name of an event. Write a word."
        for word in event_words(key):
            if word in named:
                yield f"has {word!r} in {named[word]!r} and in {key!r}. Leave one out."
            named[word] = key


def _reference(reference: int | Sequence[int]) -> Iterator[str]:
    """The first operations, or the first and the last of those that are new."""
    if not isinstance(reference, int) and reference[0] > reference[1]:
        yield f"is {reference}, but the first comes before the last. Swap them."


def _curves(curves: str | None, *others: Any) -> Iterator[str]:
    *which, events, motions = others
    if curves is None or any(_events(events)):
        return
    each = (refused("{}", listed, curves, *which, events, [motion]) for motion in motions)
    if wrong := dict.fromkeys(text for found in each for text in found):  # a table is, for both
        yield f"cannot be used: {'. '.join(wrong)}."


_AT_MOST = {  # a key, and the one that it must not exceed
    **{f"training.{motion}.evaluate_every": f"training.{motion}.steps" for motion in MOTIONS},
    **{f"network.{motion}.summary.components": "sensor.samples" for motion in MOTIONS},
    "validation.judged_curves": "validation.curves",
    "correction.smallest_size": "correction.draws",
    "correction.fit_size": "correction.round_draws",
}

RULES: tuple[tuple[tuple[str, ...], Callable[..., Iterator[str]]], ...] = (
    *((keys, partial(_at_most, keys[1])) for keys in _AT_MOST.items()),
    *((("bank", f"training.{motion}"), _bank) for motion in MOTIONS),
    (("solver.reference", "solver.candidates"), _solver),
    (("validation.second_seed", "validation.seed"), _other_seed),
    *(((f"family.{name}",), _range) for name in ("strength", "held_preload", "touch")),
    *(
        ((name,), _from_to)
        for name in (
            *("rigs.elements", "rigs.wear.change"),
            *("family.elements", "family.more", "family.wear.change"),
        )
    ),
    (("rigs.wear",), _wear),
    (("speeds",), _speeds),
    (("limits", "motions", "speeds"), _limits),
    (("limits_by_type", "speeds"), _by_type),
    (("known", "speeds"), _known),
    (("contact_lag",), _contact_lag),
    *(((f"endurance.{name}", "endurance.curves"), _choice) for name in ("breaker", "phase")),
    (("endurance.events",), _events),
    (("wear_model.reference",), _reference),
    (("planning.service_cost",), _some_cost),
    (("planning.failure_cost", "planning.service_cost"), _dearer),
    (("planning.inspection",), partial(refused, "{}", interval_of)),
    (FOLDER, _curves),
    *MAGNITUDES,
)
