"""One motion of a record: travel at even times in mm, the first motion, contacts and currents.

A ``Record`` holds what a file shows without the grid of a model; ``reader.Reader`` reads it, and
``curves`` puts it on a grid.
"""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from breaker.common.numerals import in_digits
from breaker.model.quantities import Speed
from breaker.records.checks import doubts_in_words, of_no_drive, range_remark, rest_remark
from breaker.records.contacts import ContactTimes
from breaker.records.currents import Currents
from breaker.records.grid import Gridded, on_grid
from breaker.records.measurements import Measured, Reading
from breaker.records.motion import LocatedMotion
from breaker.records.noise import noise_remarks
from breaker.records.operations import Operation
from breaker.records.rejections import NotShownError, Remark


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

    def remarks_on(self, noise_sd: float | None = None, zero_sd: float | None = None) -> list[str]:
        """Return remarks on the record.

        Args:
            noise_sd, zero_sd: Standard deviations that a model assumes for the noise and the zero,
                mm; None compares nothing.
        """
        before, after = self.segment.before, self.segment.after
        time, left = self.time[self.inside], self.left
        done = (left - before) / (after - before)
        remarks = [
            *self.file_remarks,
            of_no_drive(self.motion, time, done, self.segment.stroke),
            rest_remark(self.segment, self.settings, self.motion, zero_sd, self._closed_rest),
            doubts_in_words(self.time, self.whole, self.doubts),
            self._ripple_remark,
            self._slip_remark,
            range_remark(time, left, self.moves, self.quantum),
        ]
        if noise_sd is None:
            remarks += noise_remarks(self.noise_at(self.step), None, self.step, time)
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
    def _closed_rest(self) -> tuple[float, float]:
        """Rest position after the motion and its sd, mm; NaN where the record does not show it."""
        with suppress(NotShownError):
            after, sign = self._reading.after, 1.0 if self.motion == "closing" else -1.0
            return sign * after.value, self._reading.trace.sd(after)
        return float("nan"), float("nan")

    @property
    def _slip_remark(self) -> str:
        off = self.unreturned
        return Remark("slipped-between", off=in_digits(off, 2)) if off else ""

    @property
    def _ripple_remark(self) -> str:
        swing, period = self.ripple
        if not swing:
            return ""
        return Remark("ripples", swing=in_digits(swing, 2), period=in_digits(period, 2))
