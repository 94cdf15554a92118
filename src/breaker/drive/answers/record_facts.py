"""A record of one motion, and what networks and its file say of it."""

from dataclasses import dataclass

import numpy as np

from breaker.drive.family.network_inputs import NormalisedRecords
from breaker.reading.files.operations_table import Operation
from breaker.reading.files.preamble import Preamble
from breaker.reading.records.normalised_shape import Shape
from breaker.reading.records.raw_record import Raw


@dataclass(frozen=True, eq=False)
class DriveRecord:
    """One motion of an operation.

    Attributes:
        operation, motion: What it is of.
        stated: What stands above the samples of its file.
        reason: Why it cannot be used; empty if it can.
        raw: The record as it is in its file, if it can be used.
        shape, seen: What networks see of it.
        warning: What its file states against how it was read, to be said before anything else.
    """

    operation: Operation
    motion: str
    stated: Preamble
    reason: str = ""
    raw: Raw | None = None
    shape: Shape | None = None
    seen: NormalisedRecords | None = None
    warning: str = ""

    @property
    def timed(self) -> bool:
        """Whether its contact was seen to switch."""
        return bool(np.isfinite(self.raw.contact.time))

    @property
    def tenth(self) -> float:
        """Time of 10 % of the way, from which networks count, ms of the file."""
        return float(self.raw.time[self.raw.segment.begin]) + self.shape.origin
