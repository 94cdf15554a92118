"""Judge how the reader handles damaged files.

A good record of the model is written in a layout, damaged, and read like a user who knows the
drive: the format states the layout, the rate, and the stroke within 1.5 %. The outcome is

- rejected, with a reason;
- right: every kept sample is within 0.3 mm of the good file or of the true travel, for a first
  motion within 0.2 ms;
- masked: right, with samples left out as doubtful;
- flagged: wrong, with a remark, while the good file has no remark;
- silent: wrong, without a remark. This should not occur.

The sensor has a noise of 0.05 mm, so that noise does not explain 0.3 mm. Any error other than a
rejection, and any file that takes more than 2 s, is a defect.
"""

import signal
import tempfile
import time as clock
import warnings
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
import xarray as xr

from breaker.common.randomness import generator
from breaker.model.curves import travel
from breaker.model.parameters import MOTIONS
from breaker.model.prior import Prior
from breaker.model.sensor import Sensor
from breaker.records.curves import Grid, read_curves
from breaker.records.operations import Operation
from studies.faults.files import TEXT
from studies.faults.records import PHYSICAL
from studies.layouts import LAYOUTS

OUTCOMES = ("rejected", "right", "masked", "flagged", "silent", "exception")
"""Possible outcomes for a damaged file."""
KINDS = [*PHYSICAL, *TEXT]
"""Names of all kinds of damage."""
SECONDS = 2.0
"""Longest time to read a file, s."""

_TRAVEL = 0.3  # mm, largest error of a sample that counts as right
_FIRST_MOTION = 0.2  # ms, largest error of the first motion that counts as right
_STROKE = 0.015  # share by which the format lets the stroke be another
_LEAD, _SPREAD, _LENGTH = 10.0, 4.0, 76.0  # ms: first motion, its range, the record
_GOOD = 20  # good records of a motion in each layout
_PRIOR = Prior([2.0, 0.045, 0.040, 0.30, 0.12, 0.75, 10.0], [0.2, 0.15, 0.2, 0.2, 0.4, 0.1, 0.05])
_SENSOR = Sensor(-2.0, 58.0, 151, noise_sd=0.05, onset_sd=0.3, zero_sd=0.05)


@dataclass(frozen=True)
class Good:
    """Good record, and the reading of its file.

    Attributes:
        layout: Name of the layout of its file.
        motion: "closing" or "opening".
        time, travel: The entire record, ``(t,)``, ms and mm.
        truth: Travel without noise, ``(t,)``, mm.
        settings: The format, with known values of the drive.
        first: Time of the file that is 0 on the grid, ms.
        record: Reading on the grid, ``(g,)``, mm.
        files: Content of its files by name; the first one is read.
    """

    layout: str
    motion: str
    time: np.ndarray
    travel: np.ndarray
    truth: np.ndarray
    settings: dict
    first: float
    record: np.ndarray
    files: dict[str, bytes]

    def write(self, file: Path, time: np.ndarray, travel: np.ndarray) -> None:
        """Write a record, damaged or not, in the layout of the good record."""
        LAYOUTS[self.layout].write(file, time, travel, motion=self.motion, operation=1)

    def read(self, file: Path) -> xr.Dataset:
        """Read one file as the workflow does."""
        grid = Grid(_SENSOR.times, _SENSOR.noise_sd, _SENSOR.zero_sd, _SENSOR.onset_sd)
        return read_curves([Operation(1, file)], self.settings, grid, self.motion)


class Trial(NamedTuple):
    """Outcome for a damaged file.

    Attributes:
        kind, number: Kind of the damage, and number of the file of this kind.
        layout, motion: Layout and motion of the good file.
        outcome: One of ``OUTCOMES``.
        words: Reason, remarks or error.
        seconds: Time that the reader took.
    """

    kind: str
    number: int
    layout: str
    motion: str
    outcome: str
    words: str
    seconds: float


class _HangError(BaseException):
    """Error that is not an ``Exception``, so that no reader catches it."""


@cache
def good_file(layout: str, motion: str, number: int, seed: int) -> Good:
    """Return a good record, which the reader accepts without a remark.

    Raises:
        RuntimeError: If the reader accepts none of ten records.
    """
    form = LAYOUTS[layout]
    for attempt in range(10):
        rng = generator(seed, "good record", layout, motion, number, attempt)
        time = np.arange(0.0, _LENGTH, 1.0 / form.rate)
        moves = _LEAD + _SPREAD * (rng.random() - 0.5)
        curve = travel(_PRIOR.sample(1, rng), time, motion, onset=moves).travel
        truth = curve[0] + _SENSOR.zero_sd * rng.standard_normal()
        record = truth + _SENSOR.noise_sd * rng.standard_normal(time.size)
        stroke = abs(np.median(record[-20:]) - np.median(record[:20]))
        known = {"rate": form.rate, "stroke": [(1 + by) * stroke for by in (-_STROKE, _STROKE)]}
        settings = {**form.settings, **known}
        good = Good(layout, motion, time, record, truth, settings, 0.0, record, {})
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder, f"{motion}_00001{form.ending}")
            good.write(file, time, record)
            curves = good.read(file)
            others = sorted({path.name for path in Path(folder).iterdir()} - {file.name})
            files = {name: Path(folder, name).read_bytes() for name in (file.name, *others)}
        words = curves.reason.item() + curves.remarks.item()
        if not words and not curves.masked.item():
            first = float(curves.first_motion.item())
            return replace(good, first=first, record=curves.travel.values[0], files=files)
    raise RuntimeError(f"no good {motion} in the layout {layout} is read: {words}")


def is_right(good: Good, record: np.ndarray) -> bool:
    """Return whether a reading ``(g,)`` agrees with the good file, except for missing samples.

    The first motion is only known within a tolerance, so the reading is compared with the good
    record at all first motions within it. A sample may be close to the good record or to the true
    travel, since samples at rest are interchangeable.
    """
    kept, grid = np.isfinite(record), good.first + _SENSOR.times
    zero = np.median(good.record - np.interp(grid, good.time, good.travel))
    step = good.time[1] - good.time[0]
    near = int(_FIRST_MOTION / step + 1e-6)
    off = np.abs(record - good.record)
    for times in (grid + step * i for i in range(-near, near + 1)):
        both = [np.interp(times, good.time, curve) + zero for curve in (good.travel, good.truth)]
        off = np.vstack([off, np.abs(record - both).min(axis=0)])
    return bool((np.atleast_2d(off)[:, kept] <= _TRAVEL).all(axis=1).any())


def judge(file: Path, good: Good) -> tuple[str, str, float]:
    """Read a damaged file, and return one of ``OUTCOMES``, the words, and the seconds taken."""
    signal.signal(signal.SIGALRM, _hangs)
    signal.setitimer(signal.ITIMER_REAL, 5 * SECONDS)
    start = clock.perf_counter()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            curves = good.read(file)
        outcome = _outcome(curves, good)
        words = curves.reason.item() or curves.remarks.item()
    except (Exception, _HangError) as error:  # any error other than a rejection is a defect
        outcome, words = "exception", f"{type(error).__name__}: {error}"
    finally:
        seconds = clock.perf_counter() - start
        signal.setitimer(signal.ITIMER_REAL, 0.0)
    return outcome, words.replace(f"{file.parent}/", ""), seconds


def _hangs(*_: object) -> None:
    raise _HangError


def _outcome(curves: xr.Dataset, good: Good) -> str:
    if not curves.accepted.item():
        return "rejected" if curves.reason.item() else "exception"
    if is_right(good, curves.travel.values[0]):
        return "masked" if curves.masked.item() else "right"
    return "flagged" if curves.remarks.item() else "silent"


def try_kind(kind: str, number: int, seed: int) -> Trial:
    """Damage a good file and judge the reading.

    The layout and the motion are drawn, too; the arguments determine everything.
    """
    rng = generator(seed, "damage", kind, number)
    layout = list(LAYOUTS)[rng.integers(len(LAYOUTS))]
    motion = MOTIONS[rng.integers(len(MOTIONS))]
    good = good_file(layout, motion, int(rng.integers(_GOOD)), seed)
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, next(iter(good.files)))
        if kind in PHYSICAL:
            good.write(file, *PHYSICAL[kind](good.time, good.travel, rng))
        else:
            damaged = str(rng.choice(list(good.files)))
            for name, content in good.files.items():
                new = TEXT[kind](content, rng) if name == damaged else content
                Path(folder, name).write_bytes(new)
        judged = judge(file, good)
        if judged[-1] > SECONDS:  # repeated, since a busy machine may have delayed the reader
            judged = judge(file, good)
        return Trial(kind, number, layout, motion, *judged)
