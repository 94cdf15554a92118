"""The true state of the drive over a simulated endurance test, and when it exceeds limits."""

from collections.abc import Sequence

import numpy as np
import xarray as xr

from breaker.family.endurance import EnduranceTest
from breaker.model.curves import travel
from breaker.model.limits import Limit
from breaker.model.parameters import NAMES
from breaker.model.quantities import SPEEDS, Speed, quantities_of
from breaker.records.contacts import ContactTimes
from breaker.records.measurements import measure_curve

_STAGES = 41  # of a life, at which drives are simulated; wear is linear in between
_NEW = 50  # first operations; their mean is the reference of changes


def truth_of(
    test: EnduranceTest, motions: Sequence[str], times: np.ndarray, speeds: Sequence[Speed] = SPEEDS
) -> xr.Dataset:
    """Return the true state over the life, without the scatter from operation to operation.

    Returns:
        ``value (operation, parameter)``: true parameters. ``measured (operation, motion,
        quantity)``: quantities of a record without noise and with contact timing; nan if the record
        does not show one. ``difference (operation, motion)``: largest difference between the curves
        of drive and model at ``times``, mm.
    """
    sensor, knee = test.settings["sensor"], test.settings["wear"]["knee"]
    recorded = np.arange(-sensor["lead"], sensor["length"], 1.0 / sensor["rate"])
    operations = np.arange(1, test.operations + 1)
    stages = np.append(np.linspace(1, test.operations, _STAGES), knee * test.operations)
    stages = np.unique(np.clip(stages.round(), 1, test.operations)).astype(int)
    names = [name for motion in motions for name in quantities_of(motion, speeds, ("record",))]
    axes = {"operation": stages, "motion": list(motions), "quantity": list(dict.fromkeys(names))}
    measured = xr.DataArray(np.nan, axes, list(axes))
    difference = measured[..., 0].drop_vars("quantity").copy()
    for operation in stages.tolist():
        drive = test.worn(operation, scatter=False)
        for motion in motions:
            exact = travel(np.array([drive.theta]), times, motion).travel[0]
            off = np.abs(drive.travel(motion, times) - exact)
            difference.loc[operation, motion] = off.max()
            curve, switching = drive.operate(motion, recorded)
            contact = ContactTimes(switching if np.isfinite(switching) else np.nan, 0.0)
            try:
                values = measure_curve(recorded, curve, motion, contact=contact, speeds=speeds)
            except ValueError:  # the reader rejects this motion, too: the record is too short
                continue
            for name, value in values.items():
                measured.loc[operation, motion, name] = value.value
    theta = [test.worn(int(operation), scatter=False).theta for operation in operations]
    truth = xr.Dataset({"measured": measured, "difference": difference.assign_attrs(unit="mm")})
    return truth.interp(operation=operations).assign(
        value=xr.DataArray(theta, {"operation": operations, "parameter": list(NAMES)})
    )


def failure_times(truth: xr.Dataset, limits: Sequence[Limit]) -> dict[str, float]:
    """Return the operation at which the result of ``truth_of`` first exceeds each limit; nan if it
    never does. A quantity without a value in the model counts as exceeding.
    """
    times = {}
    for limit in limits:
        names = list(limit.quantities)
        if limit.of == "model":
            values = limit.evaluate(truth.value.values)
            excess = np.nan_to_num(limit.excess(values), nan=np.inf)
        elif limit.of == "change":
            value = truth.value.sel(parameter=names).values
            excess = limit.excess(100.0 * (value / value[:_NEW].mean(axis=0) - 1.0))
        else:
            seen = truth.measured.sel(motion=limit.motion, quantity=names)
            excess = limit.excess(seen.transpose("operation", "quantity").values)
        beyond = (excess > 0).all(axis=-1)
        times[limit.name] = float(truth.operation[beyond.argmax()]) if beyond.any() else np.nan
    return times
