"""The state of a trend after some operations, stored so that later operations continue from it."""

import json
from dataclasses import dataclass, fields

import numpy as np
import xarray as xr

from breaker.wear.difference import Difference
from breaker.wear.hypotheses import Hypotheses
from breaker.wear.reference import Reference
from breaker.wear.steps import Watch
from breaker.wear.temperature import Warmth

__all__ = ["State"]

_DIMS = {
    "log_weight": ("hypothesis",),
    "mean": ("hypothesis", "state"),
    "cov": ("hypothesis", "state", "other_state"),
    "start": ("hypothesis",),
    "kind": ("hypothesis",),
    "scatter": ("hypothesis",),
    "start_variance": ("hypothesis",),
}  # of hypotheses, in the order of their fields
_PARTS = {
    "reference": Reference,
    "difference": Difference,
    "watch": Watch,
    "warmth": Warmth,
}  # where there are any


@dataclass(frozen=True)
class State:
    """All that the next operation needs from those before it.

    Attributes:
        hypotheses: Hypotheses after the last operation.
        reference: Where the trend started, None before there is a record.
        seen: Number of operations that were learnt from.
        first: Number of the first of all, or of the first after the last known event.
        alarms: Numbers of the operations since then at which a change was noticed, the last two.
        difference: What is known of the drive's difference from the model; None where the model is
            held to be right, or before there is a record.
        watch: What the next operation is compared with; likewise.
        warmth: Temperatures so far; None before there is one.
    """

    hypotheses: Hypotheses
    reference: Reference | None
    seen: int
    first: int
    alarms: tuple[int, ...]
    difference: Difference | None = None
    watch: Watch | None = None
    warmth: Warmth | None = None

    @property
    def since(self) -> int:
        """Operation of the last alarm or known event, the first of all without any."""
        return self.alarms[-1] if self.alarms else self.first

    def to_dataset(self) -> xr.Dataset:
        """Return the state as a dataset, exactly."""
        attrs = {"operation": self.hypotheses.operation, "seen": self.seen, "first": self.first}
        attrs |= {"alarms": list(self.alarms)}
        data = {name: (dims, getattr(self.hypotheses, name)) for name, dims in _DIMS.items()}
        for part in _PARTS:
            if (held := getattr(self, part)) is None:
                continue
            for each in fields(held):
                value = np.asarray(getattr(held, each.name))
                name = f"{part}_{each.name}"
                data[name] = ([f"{name}_{k}" for k in range(value.ndim)], value)
        return xr.Dataset(data, attrs={"known": json.dumps(attrs)})

    @classmethod
    def from_dataset(cls, data: xr.Dataset) -> "State":
        """Return the state of what ``to_dataset`` returned."""
        known = json.loads(data.attrs["known"])
        hypotheses = Hypotheses(known["operation"], *(data[name].values for name in _DIMS))
        held = {}
        for part, kind in _PARTS.items():
            names = [f"{part}_{each.name}" for each in fields(kind)]
            if names[0] in data:
                values = (data[name].values for name in names)
                held[part] = kind(*(each if each.ndim else each.item() for each in values))
        begun = hypotheses, held.pop("reference", None), known["seen"], known["first"]
        return cls(*begun, tuple(known["alarms"]), **held)
