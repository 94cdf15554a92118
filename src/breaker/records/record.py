"""One motion of a record: travel at even times in mm, the first motion, contacts and currents.

A ``Record`` does not depend on the grid of a model; ``reader.Reader`` reads it, and ``curves`` puts
it on a grid.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import isfinite
from typing import TYPE_CHECKING

import numpy as np

from breaker.common.numerals import in_digits
from breaker.model.quantities import Speed
from breaker.records.checks import doubts_in_words, of_no_drive, open_rest, unsteady_remark
from breaker.records.contacts import ContactTimes
from breaker.records.currents import Currents
from breaker.records.measurements import Measured, Reading
from breaker.records.motion import LocatedMotion
from breaker.records.noise import noise_remarks
from breaker.records.operations import Operation
from breaker.records.rejections import Remark

if TYPE_CHECKING:
    from breaker.records.curves import Grid


@dataclass(frozen=True)
class Record(LocatedMotion):
    """One motion of a record."""

    operation: Operation  # operation of the record, with the settings that its file states
    settings: Mapping  # the section endurance.format, complete, with settings of the operation
    rest: float  # reading of the open breaker, mm; it is subtracted on a grid
    contact: ContactTimes  # times of the contact and of the trigger
    currents: Currents  # current of the coil, and resistance of the contact
    file_remarks: tuple[str, ...]  # remarks on the file
    # contradiction between statements of the file and its reading; "" if there is none
    warning: str = ""

    @property
    def masked(self) -> int:
        """Number of doubtful samples of the motion, which are left out."""
        return int((self.doubts[self.inside] != "").sum())

    @property
    def resistance(self) -> np.ndarray:
        """Resistance of the contact, ``(n,)``, µΩ; nan without a channel or its unit."""
        return self.currents.channel("contact")

    @cached_property
    def no_drive(self) -> str:
        """Reason why no drive moves so, in which case no limit is judged; or ""."""
        return of_no_drive(self.motion, self.time[self.inside], self.done, self.segment.stroke)

    def remarks_on(self, grid: "Grid | None" = None) -> list[str]:
        """Return remarks on the record, and on how it fits the errors that a model assumes."""
        zero_sd = grid.zero_sd if grid else None
        remarks = [
            *self.file_remarks,
            self.no_drive,
            open_rest(self.segment, self.settings, self.motion, zero_sd)[1],
            doubts_in_words(self.time, self.doubts),
        ]
        ends = filter(isfinite, self.reading.ends)
        remarks += [Remark("range-ends", level=in_digits(level, 4)) for level in ends]
        if self.ripple:
            remarks.append(Remark("ripples", rms=in_digits(self.ripple, 2)))
        time = self.time[self.inside]
        remarks.append(unsteady_remark(time, self.left, self.moves, self.segment))
        if grid and grid.onset_sd and self.moves_sd > grid.onset_sd:
            shown = in_digits(self.moves_sd, 2)
            remarks.append(Remark("onset-vague", sd=shown, assumed=grid.onset_sd))
        if grid and grid.noise_sd is not None:
            every = float(grid.times[1] - grid.times[0]) / self.step
            remarks += noise_remarks(self.noise, grid.noise_sd, every)
        return [remark for remark in remarks if remark]

    def measured(
        self, speeds: Sequence[Speed], contact: ContactTimes | None = None
    ) -> dict[str, Measured]:
        """Measure the quantities of the motion; contact times may come from another file."""
        contact = contact or self.contact
        return self.reading.with_contact(contact, speeds, self.currents).quantities()

    @cached_property
    def reading(self) -> Reading:
        """Measurement of the travel, without speeds."""
        return Reading(self, self.contact, ())
