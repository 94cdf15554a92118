"""Conditions on several sections of a configuration, and on the files that it names.

A condition yields keys, each with the problem of its value.
"""

from collections.abc import Callable, Iterator, Mapping
from typing import Any

from breaker.configuration.data_files import family_of, types_of
from breaker.configuration.loading import of_motion
from breaker.model.equations import PRESSED
from breaker.model.limits import UNRESOLVED, from_list
from breaker.model.parameters import MOTIONS
from breaker.model.quantities import every_speed
from breaker.records.folder import list_operations, table_rows
from breaker.records.operations import event_words, renewed_by
from breaker.records.settings import complete

Config = Mapping[str, Any]
Problems = Iterator[tuple[str, str]]


def broken(config: Config, *, curves: bool) -> Problems:
    """Yield problems of combinations of settings that are valid one by one.

    ``curves`` is true to check settings of the workflow only, such as the folder
    ``endurance.curves``. No check runs functions that a file names; the first job does.
    """
    yield from _numbers(config)
    yield from _limits(config, curves)
    yield from _refused("types", types_of, config)
    yield from _refused("family.name", family_of, config["family"]["name"])
    yield from _refused("endurance.format", complete, config["endurance"]["format"])
    if curves:
        yield from _refused("endurance.curves", _list, config)


def _refused(key: str, build: Callable, *given: Any) -> Problems:
    """Yield the reason if ``build`` refuses the values."""
    try:
        build(*given)
    except (OSError, ValueError) as error:
        yield key, f"cannot be used: {str(error).rstrip('.')}."


def _numbers(config: Config) -> Problems:
    """Yield problems of sizes of trainings, costs, and medians of the prior."""
    parts = ("batch", "validation_curves", "held_out_curves")
    bank = config["bank"]["shards"] * config["bank"]["curves_per_shard"]
    needs = max(sum(of_motion(config, m)["training"][key] for key in parts) for m in MOTIONS)
    if bank < needs:
        text = f"has {bank} curves (shards times curves_per_shard), but a training needs {needs}"
        yield "bank", f"{text} ({' + '.join(parts)}). Raise the former or lower these."
    drives, training = config["family"]["drives"], config["family"]["training"]
    if drives <= (needs := training["validation_curves"] + training["held_out_curves"]):
        text = f"is {drives}. Its training needs more than validation_curves + held_out_curves"
        yield "family.drives", f"{text}, which is {needs}."
    planning = config["planning"]
    if (failure := planning["failure_cost"]) <= planning["service_cost"]:
        yield "planning.failure_cost", f"is {failure:g}. Raise it above service_cost."
    f, k_a, gap = (config["prior"][name]["median"] for name in ("f", "k_a", "L"))
    if f <= k_a * gap:
        text = f"has medians f {f:g} and k_a L {k_a * gap:g}, but the contact closes for {PRESSED}."
        yield "prior", f"{text} Raise prior.f.median, or lower that of k_a or L."


def _limits(config: Config, curves: bool) -> Problems:
    """Yield wrong limits, and limits that no forecast along a life can use."""
    limits, motions, speeds = (config[key] for key in ("limits", "motions", "speeds"))
    for number, entry in enumerate(limits):
        try:
            (limit, *_) = from_list([entry], MOTIONS, every_speed(speeds))
        except ValueError as error:
            yield f"limits[{number}]", f"cannot be used: {str(error).rstrip('.')}."
            continue
        vague = [name for name in limit.quantities if name in UNRESOLVED]
        if curves and limit.of == "change" and vague:
            text = f"has {limit.name}, but records do not resolve a change of {' or '.join(vague)}"
            yield f"limits[{number}]", f"{text}. Limit a measured quantity (of: record), or none."
    names = [limit["name"] for limit in limits if "name" in limit]
    if len({*names}) < len(names):
        yield "limits", "has a name twice. Rename one of them."
    if not any(entry.get("motion", motions[0]) in motions for entry in limits):
        yield "limits", f"has no limit of {' or '.join(motions)} (motions). Add one."


def _list(config: Config) -> None:
    """List the operations of a life; a fleet's rules list those of several breakers."""
    curves, breaker, phase = (config["endurance"][key] for key in ("curves", "breaker", "phase"))
    if curves is None:
        return
    if breaker or len({row.breaker for _, row in table_rows(curves)}) <= 1:
        for motion in config["motions"]:
            list_operations(curves, motion, breaker=breaker, phase=phase)
        if config["types"]:
            raise ValueError("types is for a fleet. Write the limits of this breaker into limits")
    words = {word for _, row in table_rows(curves) for word in event_words(row.event)}
    if unknown := words - renewed_by(config["endurance"]["events"]).keys():
        names = ", ".join(sorted(unknown))
        raise ValueError(f"endurance.events lacks {names}. Add what each event renews")
