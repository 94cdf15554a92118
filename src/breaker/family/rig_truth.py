"""The truth of the stand-in: its parameters over its life, what records of it would show without
noise, and how far the model is from it.
"""

from collections.abc import Sequence

import numpy as np
import xarray as xr

from breaker.family.endurance_rig import Rig
from breaker.model.curves import travel
from breaker.model.parameters import NAMES
from breaker.model.quantities import SPEEDS, Speed, quantities_of
from breaker.records.contacts import ContactTimes
from breaker.records.measurements import measure_curve

_STAGES = 41  # of a life, at which quantities are measured; what wears is smooth in between


def truth_of(
    rig: Rig, motions: Sequence[str], times: np.ndarray, speeds: Sequence[Speed] = SPEEDS
) -> xr.Dataset:
    """Return the true parameters and quantities over the life, and how far the model is from them.

    Returns:
        Dataset over ``operation``, ``parameter``, ``motion`` and ``quantity``, all without the
        scatter from operation to operation: ``value (operation, parameter)``; ``measured
        (operation, motion, quantity)``, what a record of the drive shows without noise and with
        contact timing, nan where it shows nothing; and ``difference (operation, motion)``, the
        largest of the drive's curve from the model's at ``times``, mm.
    """
    operations = np.arange(1, rig.settings["operations"] + 1)
    drives = [rig.worn(int(operation), scatter=False) for operation in operations]
    theta = np.array([drive.theta for drive in drives])
    difference = []
    for motion in motions:
        curves = np.stack([drive.travel(motion, times) for drive in drives])
        difference.append(np.abs(curves - travel(theta, times, motion).travel).max(axis=1))
    return xr.Dataset(
        {
            "value": (("operation", "parameter"), theta),
            "difference": (("operation", "motion"), np.stack(difference, axis=-1), {"unit": "mm"}),
        },
        coords={"operation": operations, "parameter": list(NAMES), "motion": list(motions)},
    ).assign(measured=_measured(rig, operations, motions, speeds))


def _measured(
    rig: Rig, operations: np.ndarray, motions: Sequence[str], speeds: Sequence[Speed]
) -> xr.DataArray:
    """What records without noise show, over operation, motion and quantity."""
    sensor, knee = rig.settings["sensor"], rig.settings["wear"]["knee"]
    times = np.arange(-sensor["lead"], sensor["length"], 1.0 / sensor["rate"])
    stages = np.append(np.linspace(1, operations[-1], _STAGES), knee * rig.settings["operations"])
    stages = np.unique(np.clip(stages.round(), 1, operations[-1])).astype(int)
    names = list(dict.fromkeys(n for m in motions for n in quantities_of(m, speeds, ("record",))))
    seen = np.full((len(stages), len(motions), len(names)), np.nan)
    for i, operation in enumerate(stages.tolist()):
        drive = rig.worn(operation, scatter=False)
        for j, motion in enumerate(motions):
            curve, switching = drive.operate(motion, times)
            contact = ContactTimes(switching if np.isfinite(switching) else np.nan, 0.0)
            try:
                found = measure_curve(times, curve, motion, contact=contact, speeds=speeds)
            except ValueError:  # the sensor's record does not hold the motion: it is rejected, too
                continue
            for name, each in found.items():
                seen[i, j, names.index(name)] = each.value
    columns = seen.reshape(len(stages), -1).T
    values = np.stack([np.interp(operations, stages, each) for each in columns], axis=-1)
    return xr.DataArray(
        values.reshape(len(operations), *seen.shape[1:]),
        {"operation": operations, "motion": list(motions), "quantity": names},
        ("operation", "motion", "quantity"),
    )
