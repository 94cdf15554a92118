"""What a trend knows after some operations: stored, so that later ones go on from it."""

import json
from dataclasses import dataclass

import numpy as np
import xarray as xr

from breaker.mechanism import NAMES
from breaker.wear.changepoint import Hypotheses
from breaker.wear.reference import Reference

__all__ = ["State"]


@dataclass(frozen=True)
class State:
    """All that the next operation needs of those before it.

    Attributes:
        hypotheses: Hypotheses after the last operation.
        reference: Where the trend started, None before there is a record.
        seen: Operations that were learnt from.
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
        s = self.hypotheses
        dims = {"mean": ("hypothesis", "state"), "cov": ("hypothesis", "state", "other_state")}
        fields = {
            name: (dims.get(name, ("hypothesis",)), getattr(s, name))
            for name in ("log_weight", "mean", "cov", "start", "kind", "scatter")
        }
        known = {"operation": s.operation, "seen": self.seen, "first": self.first}
        p = len(NAMES)
        start = self.reference or Reference(np.full(p, np.nan), {}, np.full((p, p), np.nan))
        known |= {"alarms": list(self.alarms), "p_values": start.p_values}
        return xr.Dataset(
            fields
            | {
                "centre": ("parameter", start.centre),
                "spread": (("parameter", "other_parameter"), start.spread),
            },
            attrs={"known": json.dumps(known)},
        )

    @classmethod
    def from_dataset(cls, data: xr.Dataset) -> "State":
        """Return the state of what ``to_dataset`` returned."""
        known = json.loads(data.attrs["known"])
        names = ("log_weight", "mean", "cov", "start", "kind", "scatter")
        hypotheses = Hypotheses(known["operation"], *(data[name].values for name in names))
        reference = None
        if known["p_values"]:
            reference = Reference(data.centre.values, known["p_values"], data.spread.values)
        return cls(hypotheses, reference, known["seen"], known["first"], tuple(known["alarms"]))
