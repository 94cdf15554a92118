"""Conditions that keep a configuration finite: memory, jobs, files, and drives that can move.

The schema bounds every number by itself. These rules bound what several of them make together, and
come with ``breaker.configuration.rules``. The bounds are far above what is of use; what they
exclude would end in a traceback, without memory, or not at all.
"""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from functools import cache, partial
from typing import Any

from breaker.configuration.yaml_sources import parse
from breaker.quantities.drive_conditions import (
    HURRYING,
    PRESSED,
    PRESSING,
    RELEASING,
    pressed_half_space,
    rate_of_named,
    why_not_pressed,
)
from breaker.quantities.parameters import NAMES, PARAMETERS, Parameter
from breaker.quantities.size import Size
from breaker.reading.files.folder_listing import list_breakers, list_fleet, list_once
from breaker.reading.files.format_settings import FORMAT, complete, lacking
from breaker.reading.files.operations_table import Operation
from breaker.shipped import DEFAULTS

_JOBS = 2000  # of a rule: Snakemake plans them in a minute
_FASTEST = 100.0  # 1/ms, rate of a drive: richer drives are simulated in steps of 0.02 ms
_TURNS = 1e6  # rate times length of a record: breaker.mechanism follows no more
_FAR = 5.0  # prior sd at which a drive still has to be that slow
_SUPPORT = 0.01  # least share of the prior in which the contact stays pressed
_LINKAGE = 0.1  # ms, least period that the simulation of a drive follows

FOLDER = (
    *("endurance.curves", "endurance.breaker", "endurance.phase", "endurance.events"),
    "motions",
)
"""What says which records are worked on."""

UNLIKE = 30.0
"""Times the reference drive's that a median may be: less than the root of a slip of 1,000."""


def _product(names: tuple[str, ...], most: float, *values: float) -> Iterator[str]:
    if (product := math.prod(values)) > most:
        pairs = zip(names[1:], values[1:], strict=True)
        listed = " times ".join(f"{name} ({value:g})" for name, value in pairs)
        yield (
            f"is {values[0]:g}, which makes {product:.3g} times {listed}: more than {most:.3g}, "
            "for which memory and disk are meant. Lower one of them."
        )


def _jobs(operations: int, size: int, curves: str | None) -> Iterator[str]:
    if operations / size > _JOBS and not curves:
        yield (
            f"makes more than {_JOBS} jobs. Lower it, or raise endurance.operations_per_job to "
            f"{math.ceil(operations / _JOBS)} or more."
        )


@cache
def _reference() -> Mapping[str, Mapping[str, float]]:
    content, _ = parse(DEFAULTS)
    return content["prior"]


def _unlike(parameter: Parameter, median: float, size: Mapping[str, float]) -> Iterator[str]:
    """A unit that is wrong by 1,000, or a drive of another size without its size."""
    expected = _reference()[parameter.name]["median"] * Size(**size).factor(parameter.unit)
    if not 1 / UNLIKE <= median / expected <= UNLIKE:
        yield (
            f"is {median:g}, {median / expected:,.4g} times that of the reference drive at this "
            f"size ({expected:.3g}). Its unit is {parameter.unit}. For a drive of another size, "
            "set size."
        )


def _support(prior: Mapping[str, Mapping[str, float]]) -> Iterator[str]:
    """The contact has to stay pressed now and then."""
    columns = ([prior[name][key] for name in NAMES] for key in ("median", "log_sd"))
    slope, offset = pressed_half_space(*columns)
    share = 0.5 * math.erfc(-offset / math.hypot(*slope) / math.sqrt(2))
    if share < _SUPPORT:
        yield (
            f"leaves the contact pressed ({PRESSED}) in {share:.1e} of its draws, but must in "
            f"{_SUPPORT:g} of them at least. Raise prior.{PRESSING}.median, or lower that of "
            f"{RELEASING}."
        )


def _followed(
    prior: Mapping[str, Mapping[str, float]], sensor: Mapping[str, float]
) -> Iterator[str]:
    """Drives far out in the prior can be followed to the end of a record."""
    far = {n: each["median"] * math.exp(_FAR * each["log_sd"]) for n, each in prior.items()}
    rate, length = rate_of_named(far), sensor["stop"] - sensor["start"]
    if rate > _FASTEST or rate * length > _TURNS:
        yield (
            f"has drives with a rate of {rate:.3g} / ms ({_FAR:g} log_sd above the medians), too "
            f"fast to follow over the {length:g} ms from sensor.start to sensor.stop. Lower a "
            f"median or log_sd of {HURRYING}."
        )


def _moves(rig: Mapping[str, Any]) -> Iterator[str]:
    """The rig closes, and can be followed, in new condition and at the end of its life."""
    new, change = rig["parameters"], rig["wear"]["change"]
    worn = {name: value * (1.0 + change.get(name, 0.0)) for name, value in new.items()}
    for condition, at in (("in new condition", new), ("at the end of its life", worn)):
        if why := why_not_pressed(at):
            yield (
                f"does not press its contact {condition}: {why}. Raise {PRESSING}, or lower "
                f"{RELEASING}."
            )
            return
        if (rate := rate_of_named(at)) > _FASTEST:
            yield (
                f"has a rate of {rate:.3g} / ms {condition}, too fast to follow. Lower {HURRYING}."
            )
            return


def _off_or_above(least: float, value: float) -> Iterator[str]:
    if value != 0 and value < least:
        yield f"is {value:g}, but must be 0 (off) or at least {least:g}."


def _linkages(elements: Mapping[str, Any], strength: float = 1.0) -> Iterator[str]:
    low, high = elements["linkage"]
    if high != 0 and strength != 0 and low * strength < _LINKAGE:
        yield (
            f"has linkage: [{low:g}, {high:g}], times the strength {strength:g}, but a period must "
            f"be 0 throughout (rigid) or at least {_LINKAGE:g} ms."
        )


def refused(form: str, build: Callable, *given: Any, **more: Any) -> Iterator[str]:
    """Yield why something cannot be built of values, in words around it, if it cannot."""
    try:
        build(*given, **more)
    except (OSError, ValueError) as error:
        yield form.format(error)


def _complete(form: Mapping[str, Any], curves: str | None, *others: Any) -> Iterator[str]:
    """What no record can do without, and neither the section nor the record's row states."""
    stated = [] if curves else [{}]
    for motion in others[-1] if curves else ():
        with suppress(OSError, ValueError):  # which another rule says
            stated += [each.settings for each in listed(curves, *others[:-1], [motion])]
    distinct = {repr(each): each for each in stated}.values()
    missing = filter(None, (lacking({**FORMAT, **form, **each}) for each in distinct))
    yield from (f"cannot be used: {text}." for text in dict.fromkeys(missing))


def listed(
    curves: str,
    breaker: str | None,
    phase: str | None,
    events: Mapping[str, Sequence[str]],
    motions: Sequence[str],
) -> list[Operation]:
    """List what is worked on, by ``FOLDER``: of one breaker some motions, or all of several."""
    if is_fleet(curves, breaker):
        fleet = list_fleet(curves, phase=phase, events=events)
        return [each for some in fleet.values() for _, each in some]
    which = (breaker, phase, *sorted(events))
    return [each for motion in motions for each in list_once(curves, motion, *which)]


def is_fleet(curves: str, breaker: str | None) -> bool:
    """Say whether several breakers are worked on: none of those in a table is chosen."""
    return breaker is None and len(list_breakers(curves)) > 1


def _no_facts(known: Mapping[str, Sequence[float]], _curves: str | None) -> Iterator[str]:
    """Facts where records are those of ``endurance.curves``: the workflow's."""
    if known:
        yield (
            f"has {', '.join(known)}, but no step of the workflow takes facts. Leave it empty, and "
            "give them to `breaker infer`, by --known or a file of --config."
        )


_PRODUCTS = {
    ("bank.curves_per_shard", "bank.shards", "sensor.samples"): 1e10,
    ("rig.operations", "rig.sensor.rate", "rig.sensor.length"): 2e8,
    ("validation.draws", "validation.curves"): 2e7,
    ("endurance.draws", "endurance.operations_per_job"): 2e7,
}

MAGNITUDES: tuple[tuple[tuple[str, ...], Callable[..., Iterator[str]]], ...] = (
    *((names, partial(_product, names, most)) for names, most in _PRODUCTS.items()),
    (("rig.operations", "endurance.operations_per_job", "endurance.curves"), _jobs),
    (("rig",), _moves),
    *(((f"prior.{each.name}.median", "size"), partial(_unlike, each)) for each in PARAMETERS),
    (("prior",), _support),
    (("prior", "sensor"), _followed),
    (("sensor.onset_sd",), partial(_off_or_above, 0.001)),
    (("rig.elements.linkage",), partial(_off_or_above, _LINKAGE)),
    (("rigs.elements", "rigs.strength"), _linkages),
    (("endurance.format",), partial(refused, "cannot be used: {}", complete)),
    (("endurance.format", *FOLDER), _complete),
    (("known", "endurance.curves"), _no_facts),
)
