"""Measured curves: each record from its file to the model's grid, or a reason why not.

A file holds one operation of one motion, or a table says which part of it does. Explicit settings
describe it; nothing is guessed, and nothing repaired. The steps, each in a module of its own:

1. ``sources``: the columns of the file, numbers in its own units.
2. ``clock``: even times, ms; missing samples are NaN.
3. ``scale``: travel, mm towards closed.
4. ``doubtful``: samples that no sensor of this stroke can give become NaN.
5. ``segments``: the part of the record that is the motion; ``stroke``: whether it is a breaker's.
6. ``landmarks``: the first motion. ``noise``: that of the rest before it.
   ``leaps``, ``consistency``: what only a whole record shows.
7. ``grid``: the model's times, around the first motion.

A record that a step cannot use is rejected with its file's name, the line where there is one, and
the reason. It remains in the result as a missing curve, and the other files are read.

Whole samples are kept where the rates allow: averaging would change their noise. What is left of
the first motion's time after rounding to a sample is part of the onset, which is inferred.

Example:
    >>> import tempfile
    >>> from breaker.records.export import write_curve
    >>> time = 0.1 * np.arange(800)
    >>> travel = 16 / (1 + np.exp(22 - time))
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = f"{folder}/operation_7.csv"
    ...     write_curve(file, time, travel, motion="closing", operation=7)
    ...     curves = read_curves([Operation(7, file)], {}, np.arange(-2.0, 30.0), "closing")
    >>> curves.accepted.values, curves.missing.values, curves.travel.shape
    (array([ True]), array([0]), (1, 32))
"""

import logging
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import xarray as xr
from tqdm import tqdm

from breaker.files import ABOUT, Operation, RejectedCurveError, complete, printable, read_columns
from breaker.records.clock import count_remark, even_times
from breaker.records.consistency import inconsistencies
from breaker.records.doubtful import doubtful_samples, told
from breaker.records.errors import UnusableError
from breaker.records.grid import (
    Gridded,
    check_missing,
    grid_remarks,
    on_grid,
)
from breaker.records.landmarks import NoMotionError, first_motion
from breaker.records.leaps import leap_remark
from breaker.records.noise import Noise, noise_at_rest, noise_remarks
from breaker.records.scale import Scale, seen_quantum
from breaker.records.segments import Segment, SegmentError, find_segment
from breaker.records.stroke import check_stroke, rest_of_open
from breaker.stores import open_store

__all__ = ["Record", "open_curves", "read_curves", "read_record", "require_any"]

_MANY = 100  # files, from which the progress is shown
# Of a record that is rejected.
_NUMBERS = {"first_motion": np.nan, "masked": 0, "noise": np.nan, "colour": np.nan, "rate": np.nan}
# Rest that tells the noise, ms before the first motion: its start may be gradual, and far before it
# an earlier motion may still ring.
_REST = (50.0, 1.0)


@dataclass(frozen=True)
class Record:
    """A record, and what was found on the way to the grid.

    Attributes:
        time: Times of the whole record, ``(n,)``, ms.
        whole: Its travel, ``(n,)``, mm towards closed, doubtful samples among them.
        doubts: Kind of each doubtful sample, ``(n,)`` of text; "" where nothing is doubtful.
        segment: The part that is the motion.
        moves: Time of the first motion, ms.
        quantum: Step of the reading, mm; 0 where it is fine.
        noise: Noise at rest.
        gridded: The record on the model's grid.
        remarks: What is doubtful, in words.
    """

    time: np.ndarray
    whole: np.ndarray
    doubts: np.ndarray
    segment: Segment
    moves: float
    quantum: float
    noise: Noise
    gridded: Gridded
    remarks: tuple[str, ...]

    @property
    def numbers(self) -> dict[str, float]:
        """What the dataset of ``read_curves`` has of it, beside the travel."""
        return {
            "first_motion": self.gridded.start,
            "masked": int((self.doubts[self.segment.begin : self.segment.end] != "").sum()),
            "noise": self.noise.sd,
            "colour": self.noise.colour,
            "rate": (len(self.time) - 1) / float(self.time[-1] - self.time[0]),
        }


def read_curves(
    operations: Sequence[Operation],
    settings: Mapping,
    times: np.ndarray,
    motion: str,
    *,
    noise_sd: float | None = None,
    zero_sd: float | None = None,
) -> xr.Dataset:
    """Read the records of several operations.

    Args:
        operations: The operations, and where their records are.
        settings: The section ``endurance.format`` of the configuration; what it lacks has its
            default.
        times: The model's grid, ``(t,)``, ms around the first motion.
        motion: "closing" or "opening".
        noise_sd: Standard deviation of the noise that the model takes for granted, mm; a record
            whose own is another has a remark. None compares nothing.
        zero_sd: The same of its zero, mm.

    Returns:
        Dataset over ``operation``, ``time``: ``travel`` (mm; NaN where a sample is missing, or
        all are, where the file was rejected), ``missing``: the number of these samples,
        ``accepted``, ``reason``, ``file``, ``first_motion``: the file's time that is 0 on the
        grid, ms; ``remarks``: what is doubtful about an accepted record, in words, empty if
        nothing is; ``masked``: doubtful samples left out; ``noise`` (mm) and ``colour``: standard
        deviation and correlation from one sample to the next at rest; ``rate``: samples of the
        file in a ms, kHz; and what is known of each operation, ``ABOUT``.

    Raises:
        ValueError: If the settings lack something, or name an unknown unit or encoding.

    """
    settings = complete(settings)
    scale, errors = Scale.from_settings(settings), {"noise_sd": noise_sd, "zero_sd": zero_sd}
    records: list[Record | RejectedCurveError] = []
    bar = {"mininterval": 5, "unit": "file", "disable": len(operations) < _MANY}
    for operation in tqdm(operations, desc=f"read {motion}", **bar):
        try:
            records.append(read_record(operation, settings, scale, times, motion, **errors))
        except RejectedCurveError as error:
            records.append(error)
            logging.getLogger("breaker").warning("rejected: %s", error)
    return _dataset(operations, records, times, motion)


def _dataset(
    operations: Sequence[Operation],
    records: Sequence[Record | RejectedCurveError],
    times: np.ndarray,
    motion: str,
) -> xr.Dataset:
    """Records, or why there is none, as the dataset of ``read_curves``."""
    accepted = [isinstance(record, Record) for record in records]
    found = [record.numbers if isinstance(record, Record) else _NUMBERS for record in records]
    rows = [record.gridded.travel for record in records if isinstance(record, Record)]
    travel = np.full((len(records), len(times)), np.nan)
    travel[accepted] = np.reshape(rows, (-1, len(times)))
    texts = {
        "reason": ["" if isinstance(record, Record) else str(record) for record in records],
        "remarks": ["; ".join(getattr(record, "remarks", ())) for record in records],
        "file": [printable(each.file) for each in operations],
    }
    units = {"first_motion": "ms", "noise": "mm", "rate": "kHz"}
    numbers = {name: np.array([each[name] for each in found]) for name in _NUMBERS}
    about = {name: [getattr(each, name) for each in operations] for name in ABOUT}
    return xr.Dataset(
        {
            "travel": (("operation", "time"), travel, {"unit": "mm"}),
            "missing": ("operation", np.isnan(travel).sum(axis=1)),
            "accepted": ("operation", np.array(accepted, dtype=bool)),
            **{name: ("operation", np.array(values, dtype=str)) for name, values in texts.items()},
            **{
                name: ("operation", values, {"unit": units[name]} if name in units else {})
                for name, values in numbers.items()
            },
            **{name: ("operation", np.array(values)) for name, values in about.items()},
        },
        coords={
            "operation": ("operation", [each.number for each in operations]),
            "time": ("time", times, {"unit": "ms"}),
        },
        attrs={"motion": motion},
    )


def open_curves(stores: Sequence[str | Path]) -> xr.Dataset:
    """Read stores of consecutive operations as one dataset over ``operation``.

    Raises:
        RejectedCurveError: If not one operation was accepted.
    """
    parts = [open_store(store) for store in stores]
    curves = xr.concat(parts, dim="operation", join="exact", combine_attrs="override").load()
    require_any(curves)
    return curves


def require_any(curves: xr.Dataset) -> None:
    """Raise an error if no curve can be used, since then the settings are wrong.

    Raises:
        RejectedCurveError: If not one operation was accepted; the first reasons are listed.
    """
    if not curves.accepted.any():
        raise RejectedCurveError(
            Path(str(curves.file.values[0])).parent,
            f"none of {curves.sizes['operation']} {curves.attrs['motion']} files can be used; "
            "check endurance.format and the folder. The first reasons: "
            + " | ".join(curves.reason.values[:3].tolist()),
        )


def read_record(
    operation: Operation,
    settings: Mapping,
    scale: Scale,
    times: np.ndarray,
    motion: str,
    *,
    noise_sd: float | None = None,
    zero_sd: float | None = None,
) -> Record:
    """Read the record of one operation.

    Args:
        operation: Where it is.
        settings: The section ``endurance.format``, complete.
        scale: Of these settings.
        times, motion, noise_sd, zero_sd: As for ``read_curves``.

    Raises:
        RejectedCurveError: If the record cannot be used.
    """
    columns = read_columns(operation.file, settings, operation.channel)
    try:
        time, place, uneven = even_times(columns.time, columns.lines, settings)
        whole, lines = np.full(time.size, np.nan), np.zeros(time.size, dtype=int)
        whole[place], lines[place] = scale.travel(columns.travel), columns.lines
        doubts, quantum = _doubts(time, whole, lines, settings)
        left = np.where(doubts == "", whole, np.nan)
        part = {"begin": operation.begin, "end": operation.end}
        segment = find_segment(time, left, motion, **part)
        check_stroke(segment.stroke, settings)
        rest, off = rest_of_open(segment, settings, motion, zero_sd)
        inside = slice(segment.begin, segment.end)
        moves = first_motion(time[inside], left[inside], 1.0 if motion == "closing" else -1.0)
        gridded = on_grid(time[inside], left[inside] - rest, times, moves)
        check_missing(gridded, settings["missing"])
    except (UnusableError, SegmentError, NoMotionError) as error:
        line = getattr(error, "line", None)
        raise RejectedCurveError(operation.file, str(error), line=line) from error
    step, grid_step = (float(each[1] - each[0]) for each in (time, times))
    before = (time[inside] >= moves - _REST[0]) & (time[inside] <= moves - _REST[1])
    noise = noise_at_rest(left[inside][before], step, grid_step, quantum)
    remarks = [
        *(*columns.remarks, uneven, count_remark(time.size, settings), off),
        told(time, doubts),
        *grid_remarks(gridded, time[inside], times, back=not np.isnan(segment.back)),
        leap_remark(time[inside], left[inside], noise.sd, quantum, segment.stroke),
        *inconsistencies(time[inside], left[inside], moves, noise_sd or 0.0),
        *([] if noise_sd is None else noise_remarks(noise, noise_sd, step, times)),
    ]
    said = tuple(remark for remark in remarks if remark)
    return Record(time, whole, doubts, segment, moves, quantum, noise, gridded, said)


def _doubts(
    time: np.ndarray, whole: np.ndarray, lines: np.ndarray, settings: Mapping
) -> tuple[np.ndarray, float]:
    """Kinds of doubtful samples, ``(n,)``, and the quantum, mm.

    Raises:
        UnusableError: If there is hardly a sample, or a doubtful one where these are refused.
    """
    if (count := int((~np.isnan(whole)).sum())) < 2:
        raise UnusableError(f"has {count} samples")
    given = settings["quantum"]
    quantum = seen_quantum(whole) if given is None else given
    doubts = doubtful_samples(whole, float(time[-1] - time[0]) / (time.size - 1), quantum)
    found = np.flatnonzero(doubts)
    if found.size and settings["doubtful"] == "reject":
        raise UnusableError(told(time, doubts), line=int(lines[found[0]]))
    return doubts, quantum
