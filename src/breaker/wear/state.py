"""The state of a trend after some operations, stored so that later operations continue from it."""

import json
from dataclasses import dataclass

import numpy as np
import xarray as xr

from breaker.mechanism import NAMES
from breaker.wear.changepoint import Hypotheses
from breaker.wear.reference import Reference

__all__ = ["State"]

_DIMS = {
    "log_weight": ("hypothesis",),
    "mean": ("hypothesis", "state"),
    "cov": ("hypothesis", "state", "other_state"),
    "start": ("hypothesis",),
    "kind": ("hypothesis",),
    "scatter": ("hypothesis",),
}  # of hypotheses, in the order of their fields


@dataclass(frozen=True)
class State:
    """All that the next operation needs from those before it.

    Attributes:
        hypotheses: Hypotheses after the last operation.
        reference: Where the trend started, None before there is a record.
        seen: Number of operations that were learnt from.
        first: Number of the first.
        alarms: Numbers of the operations at which a change was noticed, the last two.
    """

    hypotheses: Hypotheses
    reference: Reference | None
    seen: int
    first: int
    alarms: tuple[int, ...]

    @property
    def since(self) -> int:
        """Operation of the last alarm, the first of all without one."""
        return self.alarms[-1] if self.alarms else self.first

    def to_dataset(self) -> xr.Dataset:
        """Return the state as a dataset, exactly."""
        h, p, known = self.hypotheses, len(NAMES), self.reference
        if known is None:
            known = Reference(np.full(p, np.nan), {}, np.full((p, p), np.nan), np.nan)
        attrs = {"operation": h.operation, "seen": self.seen, "first": self.first}
        attrs |= {"alarms": list(self.alarms)}
        attrs |= {"p_values": known.p_values, "agreement": known.agreement}
        return xr.Dataset(
            {name: (dims, getattr(h, name)) for name, dims in _DIMS.items()}
            | {
                "centre": ("parameter", known.centre),
                "spread": (("parameter", "other_parameter"), known.spread),
            },
            attrs={"known": json.dumps(attrs)},
        )

    @classmethod
    def from_dataset(cls, data: xr.Dataset) -> "State":
        """Return the state of what ``to_dataset`` returned."""
        known = json.loads(data.attrs["known"])
        hypotheses = Hypotheses(known["operation"], *(data[name].values for name in _DIMS))
        reference = None
        if known["p_values"]:
            about = data.centre.values, known["p_values"], data.spread.values, known["agreement"]
            reference = Reference(*about)
        return cls(hypotheses, reference, known["seen"], known["first"], tuple(known["alarms"]))
