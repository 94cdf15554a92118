"""Simulate an endurance test: a drive that the model does not fit wears out while a sensor records.

The endurance test of the paper is not public (paper, Sec. 7). This one has the seven parameters of
the model, which are the truth, and effects that the model lacks. Its rates of wear are assumptions.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr

from breaker.common.randomness import generator
from breaker.family.rich_drive import Drive, Elements
from breaker.model.curves import travel
from breaker.model.limits import Limit
from breaker.model.parameters import NAMES
from breaker.model.quantities import SPEEDS, Speed, quantities_of
from breaker.records.contacts import ContactTimes
from breaker.records.measurements import measure_curve

_STAGES = 41  # of a life, at which quantities are measured; wear is linear in between
_NEW = 50  # first operations, whose mean is the reference of changes


@dataclass(frozen=True)
class EnduranceTest:
    """The drive of an endurance test, its wear and its sensor.

    Attributes:
        new: Drive before the first operation.
        settings: What ``definitions.simulated_test`` returns.
        seed: Seed of the configuration.
    """

    new: Drive
    settings: Mapping
    seed: int

    @classmethod
    def from_settings(cls, settings: Mapping, seed: int) -> "EnduranceTest":
        """Build the test from what ``definitions.simulated_test`` returns.

        Raises:
            ValueError: If the drive has no closed position, new or at the end of its life.
        """
        theta = tuple(float(settings["parameters"][name]) for name in NAMES)
        test = cls(Drive(theta, Elements.from_settings(settings["effects"])), settings, seed)
        for operation in (1, test.operations):
            if not test.worn(operation, scatter=False).holds:
                raise ValueError(
                    f"at operation {operation} of the simulated test, the closing force does not "
                    "press the contact, or presses it past the dead centre; change f, k_a or L"
                )
        return test

    @property
    def operations(self) -> int:
        """Number of operations of the life."""
        return self.settings["operations"]

    def worn(self, operation: int, *, scatter: bool = True) -> Drive:
        """Return the drive at an operation, counted from 1.

        Parameters and effects that wear change linearly up to the knee, and ``faster`` times as
        fast after it, to their change at the end of life. Operations scatter around these values.
        """
        wear, life = self.settings["wear"], operation / self.operations
        knee, faster = wear["knee"], wear["faster"]
        way = min(life, knee) + faster * max(0.0, life - knee)
        share = way / (knee + faster * (1.0 - knee))
        rng = generator(self.seed, "rig wear", operation)  # these words seed the stated results
        changed = {}
        for name, change in sorted(wear["change"].items()):
            if change:
                noise = wear["scatter"] * rng.standard_normal() if scatter else 0.0
                changed[name] = self.new.value(name) * ((1.0 + change * share) * (1.0 + noise))
        return self.new.changed(**changed)

    def record(self, motion: str, operation: int) -> tuple[np.ndarray, np.ndarray]:
        """Return an operation as the sensor records it: times, ms, and travel, mm, ``(t,)``."""
        sensor = self.settings["sensor"]
        rng = generator(self.seed, "rig sensor", motion, operation)
        samples = round((sensor["lead"] + sensor["length"]) * sensor["rate"])
        times = np.arange(samples) / sensor["rate"]
        moves = sensor["lead"] + sensor["trigger_sd"] * rng.standard_normal()
        curve = self.worn(operation).travel(motion, times - moves)
        zero = sensor["zero_sd"] * rng.standard_normal()
        return times, curve + zero + sensor["noise_sd"] * rng.standard_normal(samples)


def truth_of(
    test: EnduranceTest, motions: Sequence[str], times: np.ndarray, speeds: Sequence[Speed] = SPEEDS
) -> xr.Dataset:
    """Return the true state over the life, without the scatter from operation to operation.

    Returns:
        Dataset over ``operation``, ``parameter``, ``motion`` and ``quantity``. ``value (operation,
        parameter)``: true parameters. ``measured (operation, motion, quantity)``: quantities of a
        record without noise and with contact timing; nan if the record does not show one.
        ``difference (operation, motion)``: largest difference of the drive's curve and the model's
        at ``times``, mm.
    """
    operations = np.arange(1, test.operations + 1)
    drives = [test.worn(int(operation), scatter=False) for operation in operations]
    theta = np.array([drive.theta for drive in drives])
    difference = []
    for motion in motions:
        curves = np.stack([drive.travel(motion, times) for drive in drives])
        difference.append(np.abs(curves - travel(theta, times, motion).travel).max(axis=1))
    return xr.Dataset(
        {
            "value": (("operation", "parameter"), theta),
            "measured": _measured(test, motions, speeds).interp(operation=operations),
            "difference": (("operation", "motion"), np.stack(difference, axis=-1), {"unit": "mm"}),
        },
        coords={"operation": operations, "parameter": list(NAMES), "motion": list(motions)},
    )


def _measured(test: EnduranceTest, motions: Sequence[str], speeds: Sequence[Speed]) -> xr.DataArray:
    """Return what records without noise show at some operations, one of them the knee of wear."""
    sensor, knee = test.settings["sensor"], test.settings["wear"]["knee"]
    times = np.arange(-sensor["lead"], sensor["length"], 1.0 / sensor["rate"])
    stages = np.append(np.linspace(1, test.operations, _STAGES), knee * test.operations)
    stages = np.unique(np.clip(stages.round(), 1, test.operations)).astype(int)
    names = [name for motion in motions for name in quantities_of(motion, speeds, ("record",))]
    axes = {"operation": stages, "motion": list(motions), "quantity": list(dict.fromkeys(names))}
    measured = xr.DataArray(np.nan, axes, list(axes))
    for operation in stages.tolist():
        drive = test.worn(operation, scatter=False)
        for motion in motions:
            curve, switching = drive.operate(motion, times)
            contact = ContactTimes(switching if np.isfinite(switching) else np.nan, 0.0)
            try:
                values = measure_curve(times, curve, motion, contact=contact, speeds=speeds)
            except ValueError:  # the reader rejects this motion, too: the record is too short
                continue
            for name, value in values.items():
                measured.loc[operation, motion, name] = value.value
    return measured


def failure_times(truth: xr.Dataset, limits: Sequence[Limit]) -> dict[str, float]:
    """Return the operation at which a true state first exceeds each limit; nan if it never does.

    Args:
        truth: What ``truth_of`` returns.
        limits: Limits of the model's quantities, of quantities of records, or of changes.
    """
    source, times = _Truth(truth), {}
    for limit in limits:
        beyond = (limit.read(source) > 0).all(axis=-1)
        times[limit.name] = float(truth.operation[beyond.argmax()]) if beyond.any() else np.nan
    return times


@dataclass(frozen=True)
class _Truth:
    """Excess of each part of a limit, ``(operation, parts)``, by the source of the limit."""

    truth: xr.Dataset

    def of_model(self, limit: Limit) -> np.ndarray:
        """Return the excess of quantities of the model; infinite if the model lacks one."""
        return np.nan_to_num(limit.excess(limit.evaluate(self.truth.value.values)), nan=np.inf)

    def of_change(self, limit: Limit) -> np.ndarray:
        """Return the excess of changes in percent since the first operations."""
        value = self.truth.value.values[:, [NAMES.index(name) for name in limit.quantities]]
        return limit.excess(100.0 * (value / value[:_NEW].mean(axis=0) - 1.0))

    def of_record(self, limit: Limit) -> np.ndarray:
        """Return the excess of quantities of records; nan if a record does not show one."""
        measured = self.truth.measured.sel(motion=limit.motion, quantity=list(limit.quantities))
        return limit.excess(measured.transpose("operation", "quantity").values)
