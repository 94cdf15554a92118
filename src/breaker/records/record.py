"""One motion of a record: travel at even times in mm, the first motion, contacts and currents.

A ``Record`` holds what a file shows without the grid of a model; ``reader.Reader`` reads it, and
``curves`` puts it on a grid.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from breaker.common.numerals import in_digits
from breaker.model.quantities import Speed
from breaker.records.checks import doubts_in_words, of_no_drive, rest_remark
from breaker.records.contacts import ContactTimes
from breaker.records.currents import Currents
from breaker.records.grid import Gridded, on_grid
from breaker.records.measurements import Measured, Reading
from breaker.records.motion import LocatedMotion
from breaker.records.operations import Operation
from breaker.records.rejections import Remark


@dataclass(frozen=True)
class Record(LocatedMotion):
    """One motion of a record.

    Attributes:
        operation: Operation of the record, with the settings that its file states.
        settings: The section ``endurance.format``, complete, with those of the operation.
        rest: Reading of the open breaker, mm; it is subtracted on a grid.
        contact: Times of the contact and of the trigger.
        currents: Currents of the coil and of the motor.
        file_remarks: Remarks on the file.
        warning: Contradiction between the file's own statements and how it was read; "" is none.
    """

    operation: Operation
    settings: Mapping
    rest: float
    contact: ContactTimes
    currents: Currents
    file_remarks: tuple[str, ...]
    warning: str = ""

    @property
    def masked(self) -> int:
        """Number of doubtful samples of the motion, which are left out."""
        return int((self.doubts[self.inside] != "").sum())

    def on_grid(self, times: np.ndarray) -> Gridded:
        """Return the record on the times ``(t,)`` of a grid, ms around the first motion."""
        return on_grid(self.time[self.inside], self.left - self.rest, times, self.moves)

    def remarks_on(self, zero_sd: float | None = None) -> list[str]:
        """Return remarks on the record.

        Args:
            zero_sd: Standard deviation that a model assumes for the zero, mm; None compares
                nothing.
        """
        before, after = self.segment.before, self.segment.after
        time, left = self.time[self.inside], self.left
        done = (left - before) / (after - before)
        remarks = [
            *self.file_remarks,
            of_no_drive(self.motion, time, done, self.segment.stroke),
            rest_remark(self.segment, self.settings, self.motion, zero_sd),
            doubts_in_words(self.time, self.doubts),
            self._ripple_remark,
        ]
        return [remark for remark in remarks if remark]

    def measured(
        self, speeds: Sequence[Speed], contact: ContactTimes | None = None
    ) -> dict[str, Measured]:
        """Measure the quantities of the motion.

        Args:
            speeds: Definitions of the speeds.
            contact: Times of the contact, where another file has them; None for the record's own.
        """
        contact = contact or self.contact
        return self._reading.with_contact(contact, speeds, self.currents).quantities()

    @cached_property
    def _reading(self) -> Reading:
        return Reading(self, self.contact, ())

    @property
    def start_sd(self) -> float:
        """Standard deviation of the first motion, ms; see ``Reading.start_sd``."""
        return self._reading.start_sd

    @property
    def start_hidden(self) -> str:
        """Reason why the first motion has no value; "" if it has one."""
        return self._reading.start_hidden

    @property
    def _ripple_remark(self) -> str:
        return Remark("ripples", rms=in_digits(self.ripple, 2)) if self.ripple else ""
