"""Conditions on magnitudes, and on the folder of records.

A median of the wrong unit, a prior of drives that hardly ever close, and records that cannot be
read. They come with ``breaker.configuration.rules``.
"""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from functools import cache, partial
from typing import Any

from breaker.configuration.yaml_sources import parse
from breaker.model.equations import PRESSED, pressed_half_space
from breaker.model.parameters import NAMES, PARAMETERS, Parameter, Size
from breaker.reading.files.folder_listing import list_breakers, list_fleet, list_once
from breaker.reading.files.format_settings import FORMAT, complete, lacking
from breaker.reading.files.operations_table import Operation
from breaker.shipped import DEFAULTS

_SUPPORT = 0.01  # least share of the prior in which the contact stays pressed
FOLDER = (
    *("endurance.curves", "endurance.breaker", "endurance.phase", "endurance.events"),
    "motions",
)
"""What says which records are worked on."""

UNLIKE = 30.0
"""Times the reference drive's that a median may be: less than the root of a slip of 1,000."""


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
            f"{_SUPPORT:g} of them at least. Raise prior.f.median, or lower that of k_a or L."
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


MAGNITUDES: tuple[tuple[tuple[str, ...], Callable[..., Iterator[str]]], ...] = (
    *(((f"prior.{each.name}.median", "size"), partial(_unlike, each)) for each in PARAMETERS),
    (("prior",), _support),
    (("endurance.format",), partial(refused, "cannot be used: {}", complete)),
    (("endurance.format", *FOLDER), _complete),
    (("known", "endurance.curves"), _no_facts),
)
