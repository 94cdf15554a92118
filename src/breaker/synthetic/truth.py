"""The truth of the stand-in: its parameters over its life, and how far the model is from it."""

from collections.abc import Sequence

import numpy as np
import xarray as xr

from breaker.mechanism import NAMES, travel
from breaker.synthetic.rigs import Rig

__all__ = ["truth_of"]


def truth_of(rig: Rig, motions: Sequence[str], times: np.ndarray) -> xr.Dataset:
    """Return the true parameters over the life, and how far the model at them is from the drive.

    Args:
        rig: The rig.
        motions: Motions to compare.
        times: Times at which they are compared, ``(t,)``, ms.

    Returns:
        Dataset over ``operation``, ``parameter`` and ``motion``: ``value (operation, parameter)``,
        without the scatter from operation to operation; ``without_change (longer, parameter)``, the
        same if the wear had gone on as it began, until it comes to the same end; and ``difference
        (operation, motion)``, the largest of the drive's curve from the model's, mm.
    """
    operations = np.arange(1, rig.settings["operations"] + 1)
    drives = [rig.worn(int(operation), scatter=False) for operation in operations]
    theta = np.array([drive.theta for drive in drives])
    longer = np.arange(1, rig.life_without_change + 1)
    steady = [rig.worn(int(each), scatter=False, changes=False).theta for each in longer]
    difference = [
        np.abs(
            np.stack([drive.travel(motion, times) for drive in drives])
            - travel(theta, times, motion).travel
        ).max(axis=1)
        for motion in motions
    ]
    return xr.Dataset(
        {
            "value": (("operation", "parameter"), theta),
            "without_change": (("longer", "parameter"), np.array(steady)),
            "difference": (("operation", "motion"), np.stack(difference, axis=-1), {"unit": "mm"}),
        },
        coords={"operation": operations, "longer": longer}
        | {"parameter": list(NAMES), "motion": list(motions)},
    )
