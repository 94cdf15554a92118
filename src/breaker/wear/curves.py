"""A life, from the records of a drive as they were read."""

from collections.abc import Mapping, Sequence

import xarray as xr

from breaker.family import shipped_networks
from breaker.mechanism import Limit
from breaker.shipped import KINDS
from breaker.wear.events import Event
from breaker.wear.followed import follow_life
from breaker.wear.forecast import Future
from breaker.wear.readout import Readout
from breaker.wear.series import series_of
from breaker.wear.tracker import Tracker

__all__ = ["follow_curves"]


def follow_curves(
    data: Mapping[str, xr.Dataset],
    limits: Sequence[Limit],
    settings: Mapping,
    *,
    events: Mapping[int, Event] | None = None,
    temperatures: Mapping[int, float] | None = None,
) -> xr.Dataset:
    """Follow a drive by the networks that ship, and judge its limits: see ``follow_life``.

    Args:
        data: What ``records.read_curves`` returns of each motion.
        settings: ``wear_model``, that section of the configuration, ``misfit_p_value``, ``seed``.
        events, temperatures: By the number of an operation.

    Raises:
        ValueError: If no operation that is new has a record.
    """
    wear_model = settings["wear_model"]
    names: dict[str, list[str]] = {motion: [] for motion in data}
    for limit in limits:
        if limit.of == "record":
            names[limit.motion] += limit.quantities
    followed = {motion: list(dict.fromkeys(each)) for motion, each in names.items()}
    readout = Readout.of(
        series_of(
            data,
            wear_model["reference"],
            followed=followed,
            events=events,
            temperatures=temperatures,
        ),
        list(shipped_networks(*KINDS)),
        draws=wear_model["draws"],
        seed=settings["seed"],
        misfit_p_value=settings["misfit_p_value"],
    )
    tracker, future = Tracker.from_settings(wear_model), Future.from_settings(wear_model)
    return follow_life(readout, tracker, limits, future)
