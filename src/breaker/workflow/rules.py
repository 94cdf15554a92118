"""Conditions on several keys of the configuration, which a schema cannot express: ``RULES``.

A rule is a pair: keys, the first of which a message is about, and a function that takes what they
hold and returns what is wrong and the remedy, or None.
"""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from math import isnan
from typing import Any

from breaker.files import SWITCHING, event_words, list_operations
from breaker.mechanism import (
    MOTIONS,
    NAMES,
    Limit,
    check_fact,
    check_quantity,
    from_list,
    speeds_of,
)
from breaker.workflow.magnitudes import MAGNITUDES, refused

__all__ = ["RULES"]


def _at_most(limit: str, value: float, most: float) -> str | None:
    fault = f"is {value}, but must not exceed {limit} ({most}). Lower it, or raise {limit}."
    return fault if value > most else None


def _bank(bank: Mapping[str, int], training: Mapping[str, Any]) -> str | None:
    curves = bank["shards"] * bank["curves_per_shard"]
    needs = sum(training[key] for key in ("batch", "validation_curves", "held_out_curves"))
    if curves >= needs:
        return None
    return (
        f"has {curves} curves (shards times curves_per_shard), but a training needs {needs} (batch "
        "+ validation_curves + held_out_curves). Raise one of the first two, or lower one of these."
    )


def _layers(series: Mapping[str, Any], kind: str, samples: int) -> str | None:
    if kind != "time_series":
        return None
    counts = {name: len(series[name]) for name in ("channels", "kernels", "strides")}
    if len(set(counts.values())) > 1:
        words = ", ".join(f"{count} {name}" for name, count in counts.items())
        return f"has {words}. All three need one entry for each convolution."
    steps = samples
    for kernel, stride in zip(series["kernels"], series["strides"], strict=True):
        steps = max(0, (steps - kernel) // stride + 1)
    if series["skip"] <= steps:
        return None
    return (
        f"skips {series['skip']} steps, but the convolutions leave {steps}. "
        "Lower skip, a kernel or a stride."
    )


def _solver(reference: int, candidates: Sequence[int]) -> str | None:
    fault = f"is {reference}, but must be more than any of solver.candidates ({max(candidates)})."
    return fault if reference <= max(candidates) else None


def _other_seed(name: str, seed: int, other: int) -> str | None:
    fault = f"is {seed}, which {name} is too. A second look needs another number."
    return fault if seed == other else None


def _range(ends: Sequence[float]) -> str | None:
    low, high = ends
    return None if low < high else f"is {ends}, but the first must be less than the second."


def _from_to(section: Mapping[str, Any]) -> str | None:
    """A section at any depth of ranges from and to, which may be equal."""
    wrong = []
    for name, value in section.items():
        if isinstance(value, Mapping):
            below = _from_to(value)
            wrong += [f"{name}: {below}"] if below else []
        elif value[0] > value[1]:
            wrong.append(f"{name} is {value}, but the first must not exceed the second.")
    return " ".join(wrong) or None


def _wear(wear: Mapping[str, Any]) -> str | None:
    """Counts of what changes, against what there is to change."""
    names = [name in NAMES for name in wear["change"]]
    for kind, there in (("parameters", sum(names)), ("elements", len(names) - sum(names))):
        least, most = wear[kind]
        if not least <= most <= there:
            return (
                f"has {kind}: {wear[kind]}, but the first must not exceed the second, nor the "
                f"second the number of {kind} that can change ({there})."
            )
    return None


_speeds = partial(refused, "cannot be used. {}.", speeds_of)


def _limits(
    entries: Sequence[Mapping[str, Any]],
    motions: Sequence[str],
    speeds: Mapping[str, Sequence[str] | None],
) -> str | None:
    if _speeds(speeds):
        return None
    names, defined = [entry["name"] for entry in entries], speeds_of(speeds)
    wrong = [
        f"{name}: there are two limits of this name. Give one another name."
        for name in sorted({each for each in names if names.count(each) > 1})
    ]
    wrong += filter(None, (refused("{}", Limit.from_settings, each, defined) for each in entries))
    if wrong:
        return f"cannot be used. {' '.join(wrong)}"
    # There may be limits of motions that are not worked on, but not only such.
    if not any(entry.get("motion") in (*motions, None) for entry in entries):
        return f"has no limit of {' or '.join(motions)} (motions). Add one."
    return None


def _known(
    known: Mapping[str, Sequence[float]],
    speeds: Mapping[str, Sequence[str] | None],
    posterior: str,
) -> str | None:
    if _speeds(speeds):
        return None
    defined, wrong = speeds_of(speeds), []
    for name in known:
        complaints = [check_quantity(name, motion, defined) for motion in MOTIONS]
        if all(complaints):
            wrong.append("cannot be used. " + " ".join(complaints))
    wrong += [
        f"has {name}: {fact}, which {complaint}"
        for name, fact in known.items()
        if (complaint := check_fact(*fact))
    ]
    if known and posterior != "corrected":
        wrong.append(
            f"names {', '.join(known)}, which networks do not know, but endurance.posterior is "
            f"{posterior}. Set it to corrected, or leave the facts out."
        )
    return " ".join(wrong) or None


def _choice(choice: str | None, curves: str | None) -> str | None:
    if choice is None or curves is not None:
        return None
    return f"is {choice}, but the stand-in is one breaker with one phase. Set it to null."


def _events(events: Mapping[str, Sequence[str]]) -> str | None:
    """Names of events, each of which must be there once, however it is written."""
    named, wrong = {}, []
    for key in events:
        if not event_words(key):
            wrong.append(f"has {key!r}, which is no name of an event. Write a word.")
        for word in event_words(key):
            if word in named:
                wrong.append(f"has {word!r} in {named[word]!r} and in {key!r}. Leave one out.")
            named[word] = key
    return " ".join(wrong) or None


def _reference(reference: int | Sequence[int]) -> str | None:
    """The first operations, or the first and the last of those that are new."""
    wrong = not isinstance(reference, int) and reference[0] > reference[1]
    return f"is {reference}, but the first comes before the last. Swap them." if wrong else None


def _curves(
    curves: str | None,
    motions: Sequence[str],
    breaker: str | None,
    phase: str | None,
    events: Mapping[str, Sequence[str]],
) -> str | None:
    if curves is None or _events(events):
        return None
    which = {"breaker": breaker, "phase": phase, "events": events}
    found = (refused("{}", list_operations, curves, motion, **which) for motion in motions)
    wrong = dict.fromkeys(filter(None, found))  # a table is wrong for both motions alike
    return f"cannot be used: {'. '.join(wrong)}." if wrong else None


def _shown(
    entries: Sequence[Mapping[str, Any]],
    motions: Sequence[str],
    speeds: Mapping[str, Sequence[str] | None],
    curves: str | None,
    breaker: str | None,
    phase: str | None,
    contact: str | int | None,
    trigger: str | int | None,
) -> str | None:
    """Limits on what records show by a contact or trigger alone, where none is stated."""
    if curves is None or _limits(entries, motions, speeds):
        return None
    defined, wrong = speeds_of(speeds), []
    timed = [each.name for each in defined if each.of_event]
    needs = dict.fromkeys((*timed, *SWITCHING.values()), "contact") | {"latch_time": "trigger"}
    for limit in from_list(entries, motions, defined, of=["record"]):
        try:
            rows = list_operations(curves, limit.motion, breaker=breaker, phase=phase)
        except (OSError, ValueError):
            return None  # which another rule says
        lacking = {}  # what no record shows, and the column of the table that could state it
        if contact is None and all(isnan(row.switching) for row in rows):
            lacking["contact"] = SWITCHING[limit.motion]
        if trigger is None and all(isnan(row.trigger) for row in rows):
            lacking["trigger"] = "trigger"
        wrong += [
            f"{limit.name}: no record shows {name} without the {needs[name]}. Set endurance.format."
            f"{needs[name]}_column, or state {lacking[needs[name]]} in operations.csv."
            for name in limit.quantities
            if needs.get(name) in lacking
        ]
    return f"cannot be used. {' '.join(wrong)}" if wrong else None


_AT_MOST = {  # a key, and the one that it must not exceed
    **{f"training.{motion}.evaluate_every": f"training.{motion}.steps" for motion in MOTIONS},
    **{f"network.{motion}.summary.components": "sensor.samples" for motion in MOTIONS},
    "validation.judged_curves": "validation.curves",
    "correction.smallest_size": "correction.draws",
    "correction.fit_size": "correction.round_draws",
}

RULES: tuple[tuple[tuple[str, ...], Callable[..., str | None]], ...] = (
    *((keys, partial(_at_most, keys[1])) for keys in _AT_MOST.items()),
    *((("bank", f"training.{motion}"), _bank) for motion in MOTIONS),
    *(
        ((f"{summary}.time_series", f"{summary}.kind", "sensor.samples"), _layers)
        for summary in (f"network.{motion}.summary" for motion in MOTIONS)
    ),
    (("solver.reference", "solver.candidates"), _solver),
    (("validation.second_seed", "validation.seed"), partial(_other_seed, "validation.seed")),
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
    (
        (
            *("limits", "motions", "speeds", "endurance.curves", "endurance.breaker"),
            *("endurance.phase", "endurance.format.contact_column"),
            "endurance.format.trigger_column",
        ),
        _shown,
    ),
    (("known", "speeds", "endurance.posterior"), _known),
    *(((f"endurance.{name}", "endurance.curves"), _choice) for name in ("breaker", "phase")),
    (("endurance.events",), _events),
    (("wear_model.reference",), _reference),
    (
        (
            *("endurance.curves", "motions", "endurance.breaker", "endurance.phase"),
            "endurance.events",
        ),
        _curves,
    ),
    *MAGNITUDES,
)
