"""Conditions on several sections of a configuration, and on the files that it names.

A condition yields keys, each with the problem of its value.
"""

from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from typing import Any

from breaker.common.named_functions import load
from breaker.configuration.definitions import family_of, types_of
from breaker.configuration.loading import of_motion
from breaker.configuration.settings import defaults
from breaker.model.equations import PRESSED
from breaker.model.limits import UNRESOLVED, from_list
from breaker.model.parameters import MOTIONS
from breaker.model.quantities import every_speed
from breaker.records.folder import list_breakers, list_operations, table_rows
from breaker.records.operations import event_words, renewed_by
from breaker.records.settings import complete

Config = Mapping[str, Any]
Problems = Iterator[tuple[str, str]]


def broken(config: Config, *, curves: bool) -> Problems:
    """Yield problems of combinations of settings that are valid one by one.

    ``curves`` is true to check settings of the workflow only: the folder ``endurance.curves`` and
    the user's functions. A command on records never runs functions that a file names.
    """
    conditions = (_curves, _costs, _prior, _limits, _names)
    for condition in (*conditions, *((_life, _own, _folder) if curves else ())):
        yield from condition(config)


def _refused(key: str, build: Callable, *given: Any) -> Problems:
    """Yield the reason if ``build`` refuses the values."""
    try:
        build(*given)
    except (OSError, ValueError) as error:
        yield key, f"cannot be used: {str(error).rstrip('.')}."


def _curves(config: Config) -> Problems:
    """Yield problems of too few simulated curves for a batch and for validation."""
    bank = config["bank"]["shards"] * config["bank"]["curves_per_shard"]
    parts = ("batch", "validation_curves", "held_out_curves")
    needs = max(sum(of_motion(config, m)["training"][key] for key in parts) for m in MOTIONS)
    if bank < needs:
        text = f"has {bank} curves (shards times curves_per_shard), but a training needs {needs}"
        yield "bank", f"{text} ({' + '.join(parts)}). Raise the former or lower these."
    family = config["family"]
    needs = sum(family["training"][key] for key in parts[1:])
    if family["drives"] <= needs:
        text = f"is {family['drives']}, but its training needs more than {needs}"
        yield "family.drives", f"{text} ({' + '.join(parts[1:])}). Raise it or lower these."


def _costs(config: Config) -> Problems:
    planning = config["planning"]
    if (failure := planning["failure_cost"]) <= planning["service_cost"]:
        yield "planning.failure_cost", f"is {failure:g}. Raise it above service_cost."


def _prior(config: Config) -> Problems:
    f, k_a, gap = (config["prior"][name]["median"] for name in ("f", "k_a", "L"))
    if f <= k_a * gap:
        text = f"has medians f {f:g} and k_a L {k_a * gap:g}, but the contact closes for {PRESSED}."
        yield "prior", f"{text} Raise prior.f.median, or lower that of k_a or L."


def _limits(config: Config) -> Problems:
    limits, motions, speeds = (config[key] for key in ("limits", "motions", "speeds"))
    for number, entry in enumerate(limits):
        yield from _refused(f"limits[{number}]", from_list, [entry], MOTIONS, every_speed(speeds))
    names = [limit["name"] for limit in limits if "name" in limit]
    if len({*names}) < len(names):
        yield "limits", "has a name twice. Rename one of them."
    if not any(entry.get("motion", motions[0]) in motions for entry in limits):
        yield "limits", f"has no limit of {' or '.join(motions)} (motions). Add one."
    yield from _refused("types", types_of, config)


def _names(config: Config) -> Problems:
    yield from _refused("family.name", family_of, config["family"]["name"])
    yield from _refused("endurance.format", complete, config["endurance"]["format"])


def _life(config: Config) -> Problems:
    """Yield limits that no forecast along a life can use; commands on records accept them."""
    for number, entry in enumerate(config["limits"]):
        with suppress(OSError, ValueError):  # ``_limits`` reports these
            limit = from_list([entry], MOTIONS, every_speed(config["speeds"]))[0]
            vague = [name for name in limit.quantities if name in UNRESOLVED]
            if limit.of == "change" and vague:
                text = f"has {limit.name}, but records do not resolve a change of "
                text += f"{' or '.join(vague)} along a life. Limit a measured quantity (of: record)"
                yield f"limits[{number}]", f"{text}, or remove it."


def _own(config: Config) -> Problems:
    """Yield the user's functions that are missing, fail, or return wrong shapes."""
    model = config["model"]
    named = {f"model.{key}": name for key, name in model.items() if name}
    for motion in config["motions"]:
        kind = of_motion(config, motion)["network"]["summary"]["kind"]
        named |= {"network.summary.kind": kind} if ":" in kind else {}
    tried = ""
    try:
        for key, name in named.items():
            tried = key
            load(name)
        if tried := next((key for key in named if key.startswith("model")), ""):
            from breaker.paper.joint_model import (
                Model,
            )  # compiled code, only for the user's functions

            for motion in config["motions"]:
                Model.from_settings({**config, "motion": motion}).try_out()
    except Exception as error:  # the user's code may raise any exception
        text = str(error) if isinstance(error, ValueError) else f"{type(error).__name__}: {error}"
        yield tried, f"is {named[tried]}, which cannot be used: {text} (docs/research/extend.md)."
    if model["simulator"] and model["prior"] and config["prior"] != defaults()["prior"]:
        yield "prior", "is not used: model.prior draws the parameters of your simulator. Remove it."


def _folder(config: Config) -> Problems:
    """Yield problems in the list of operations of one breaker; a fleet's rules check several."""
    endurance, unknown = config["endurance"], set()
    if (curves := endurance["curves"]) is None:
        return
    for motion in config["motions"]:
        yield from _refused("endurance.curves", _list, endurance, motion)
    with suppress(OSError, ValueError):  # ``_list`` reports these
        words = {word for _, row in table_rows(curves) for word in event_words(row.event)}
        unknown = words - renewed_by(endurance["events"]).keys()
    if unknown:
        names = ", ".join(sorted(unknown))
        yield "endurance.events", f"has no {names}, as operations.csv names. Add what it renews."


def _list(endurance: Config, motion: str) -> None:
    curves, breaker, phase = (endurance[key] for key in ("curves", "breaker", "phase"))
    if breaker or len(list_breakers(curves)) <= 1:
        list_operations(curves, motion, breaker=breaker, phase=phase)
