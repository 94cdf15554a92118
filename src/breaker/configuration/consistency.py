"""Conditions on several sections of a configuration, and on the files that it names.

The arguments of a condition are the sections that it compares. It yields a key, and what is wrong
with its value; ``broken`` calls those whose sections are right by themselves.
"""

import inspect
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from contextlib import suppress
from typing import Any

from breaker.common.named_functions import load
from breaker.configuration.definitions import ADVICE, advice_of, family_of, types_of
from breaker.configuration.loading import UNLIKE, of_motion
from breaker.configuration.settings import defaults
from breaker.model.equations import PRESSED
from breaker.model.limits import UNRESOLVED, from_list
from breaker.model.parameters import MOTIONS, PARAMETERS, Size
from breaker.model.quantities import every_speed
from breaker.records.folder import list_breakers, list_fleet, list_operations
from breaker.records.operations import event_words
from breaker.records.settings import FORMAT, complete, lacking

Found = Iterator[tuple[tuple[str | int, ...], str]]


def broken(config: Mapping[str, Any], wrong: Collection[str], *, curves: bool) -> Found:
    """Yield what is wrong with sections together, but for those that are ``wrong`` by themselves;
    ``curves`` tells whether to look at the folder ``endurance.curves`` and at own functions.
    """
    conditions = (_trainings, _costs, _prior, _limits, _names, _family)
    # Only the workflow uses these: a command on records runs no function that a file names.
    for condition in (*conditions, *([_followed, _own, _folder] if curves else [])):
        names = inspect.signature(condition).parameters
        if not {*names} & {*wrong}:
            yield from condition(*(config[name] for name in names))


def _refused(key: tuple, build: Callable, *given: Any) -> Found:
    """Yield why something cannot be built of values, if it cannot."""
    try:
        build(*given)
    except (OSError, ValueError) as error:
        yield key, f"cannot be used: {str(error).rstrip('.')}."


def _distinct(key: tuple, names: Iterable[str], meant: Callable = lambda name: [name]) -> Found:
    """Yield names that mean nothing, or the same as an earlier one."""
    seen: set[str] = set()
    for name in names:
        words = {*meant(name)} - {""}
        if not words or words & seen:
            yield key, f"has {name!r}, which means nothing, or the same as another. Rename it."
        seen |= words


def _trainings(network, training, by_motion, bank, sensor, validation) -> Found:
    config = {"network": network, "training": training, "by_motion": by_motion}
    curves = bank["shards"] * bank["curves_per_shard"]
    for motion in MOTIONS:
        own = of_motion(config, motion)
        keys = ("batch", "validation_curves", "held_out_curves")
        needs = sum(own["training"][key] for key in keys)
        if curves < needs:
            text = f"has {curves} curves (shards times curves_per_shard), but the training of "
            text += f"{motion} needs {needs} ({' + '.join(keys)}). Raise the former or lower these."
            yield ("bank",), text
        if (parts := own["network"]["summary"]["components"]) > (most := sensor["samples"]):
            text = f"is {parts}, but must not exceed sensor.samples ({most}). Change one of them."
            yield ("network", "summary", "components"), text
    if (judged := validation["judged_curves"]) > (most := validation["curves"]):
        text = f"is {judged}, but must not exceed curves ({most}). Change one of them."
        yield ("validation", "judged_curves"), text


def _costs(planning) -> Found:
    if (failure := planning["failure_cost"]) <= planning["service_cost"]:
        text = f"is {failure:g}, so no service pays. Raise it above service_cost."
        yield ("planning", "failure_cost"), text


def _prior(prior, size) -> Found:
    """A unit that is wrong by 1,000, a drive of another size, or a contact that never closes."""
    medians = defaults()["prior"]
    for parameter in PARAMETERS:
        median = prior[parameter.name]["median"]
        usual = medians[parameter.name]["median"] * Size(**size).factor(parameter.unit)
        if not 1 / UNLIKE <= median / usual <= UNLIKE:
            text = f"is {median:g}, {median / usual:,.4g} times that of a drive of this size, "
            text += f"{usual:.3g}. Its unit is {parameter.unit}. For another size, set size."
            yield ("prior", parameter.name, "median"), text
    f, k_a, gap = (prior[name]["median"] for name in ("f", "k_a", "L"))
    if f <= k_a * gap:
        text = f"has medians f {f:g} and k_a L {k_a * gap:g}, but the contact closes for {PRESSED}."
        yield ("prior",), f"{text} Raise prior.f.median, or lower that of k_a or L."


def _limits(limits, types, motions, speeds) -> Found:
    defined = every_speed(speeds)
    for number, entry in enumerate(limits):
        yield from _refused(("limits", number), from_list, [entry], MOTIONS, defined)
    yield from _distinct(("limits",), [limit["name"] for limit in limits if "name" in limit])
    if not any(entry.get("motion", motions[0]) in motions for entry in limits):
        yield ("limits",), f"has no limit of {' or '.join(motions)} (motions). Add one."
    yield from _refused(("types",), types_of, {"types": types, "speeds": speeds})


def _followed(limits, speeds) -> Found:
    """Limits that no life can be followed to; a command on records may have them."""
    for number, entry in enumerate(limits):
        with suppress(OSError, ValueError):  # what ``_limits`` refuses
            one = from_list([entry], MOTIONS, every_speed(speeds))[0]
            if one.of == "change" and (vague := [q for q in one.quantities if q in UNRESOLVED]):
                text = f"has {one.name}, but records do not resolve a change of "
                text += f"{' or '.join(vague)} along a life. Limit a measured quantity (of: record)"
                yield ("limits", number), f"{text}, or remove it."


def _names(family, advice, endurance) -> Found:
    yield from _refused(("family", "name"), family_of, family["name"])
    if unknown := [name for name in advice if name not in advice_of()]:
        yield ("advice",), f"has {', '.join(unknown)}, but must name entries of {ADVICE.name}."
    yield from _refused(("endurance", "format"), complete, endurance["format"])
    yield from _distinct(("endurance", "events"), endurance["events"], event_words)


def _family(family) -> Found:
    keys = ("validation_curves", "held_out_curves")
    needs = sum(family["training"][key] for key in keys)
    if (drives := family["drives"]) <= needs:
        text = f"is {drives}, but its training needs more than {needs} ({' + '.join(keys)}). Raise "
        yield ("family", "drives"), text + "the former or lower these."


def _own(model, prior, sensor, network, by_motion, motions) -> Found:
    """Functions of your own that are not there, fail, or return other shapes than they must."""
    both = {"network": network, "training": {}, "by_motion": by_motion}
    named = {("model", key): name for key, name in model.items() if name}
    for motion in motions:
        kind = of_motion(both, motion)["network"]["summary"]["kind"]
        named |= {("network", "summary", "kind"): kind} if ":" in kind else {}
    settings, tried = {"model": model, "prior": prior, "sensor": sensor}, ()
    try:
        for key, name in named.items():
            tried = key
            load(name)
        if tried := next((key for key in named if key[0] == "model"), ()):
            from breaker.paper.joint_model import Model  # compiled code, for own functions alone

            for motion in motions:
                Model.from_settings(settings | {"motion": motion}).try_out()
    except Exception as error:  # whatever code of others may raise
        text = str(error) if isinstance(error, ValueError) else f"{type(error).__name__}: {error}"
        yield tried, f"is {named[tried]}, which cannot be used: {text} (docs/research/extend.md)."


def _folder(endurance, motions, known) -> Found:
    """Operations that cannot be listed, or whose records lack a setting."""
    stated: list[Mapping] = []
    for key in ("breaker", "phase"):
        if endurance["curves"] is None and endurance[key] is not None:
            text = "needs endurance.curves: the simulated test has one breaker. Set it to null."
            yield ("endurance", key), text
    for motion in motions:
        yield from _refused(
            ("endurance", "curves"), lambda on: stated.extend(_stated(endurance, on)), motion
        )
    for text in {lacking({**FORMAT, **endurance["format"], **row}) for row in stated} - {""}:
        yield ("endurance", "format"), f"cannot be used: {text}."
    if known:
        yield ("known",), "is not used by the workflow: give it to `breaker infer`. Leave it empty."


def _stated(endurance: Mapping, motion: str) -> list[Mapping]:
    """Return what the table states of each operation: of a motion, or of several breakers."""
    curves, breaker, phase, events = map(endurance.get, ("curves", "breaker", "phase", "events"))
    if curves is None:
        return [{}]
    if breaker is None and len(list_breakers(curves, events)) > 1:
        fleet = list_fleet(curves, phase=phase, events=events)
        return [row.settings for some in fleet.values() for _, row in some]
    chosen = {"breaker": breaker, "phase": phase, "events": events}
    return [operation.settings for operation in list_operations(curves, motion, **chosen)]
