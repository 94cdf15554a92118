"""Measured curves: each record from its file to the model's grid, or a reason why not.

A file holds one operation of one motion, or a table says which part of it does. Explicit settings
describe it; nothing is guessed, and nothing repaired. The steps, each in a module of its own:

1. ``formats``: the columns of the file, numbers in its own units.
2. ``record_axes``: even times, ms, and travel, mm towards closed; missing samples are NaN.
3. ``faulty_samples``: samples that no sensor of this stroke can give become NaN.
4. ``motion``: the part of the record that is the motion; ``record_doubts``: whether it is a
   breaker's, and what only a whole record shows.
5. ``landmarks``: the first motion. ``raw_record`` has all up to here. ``noise``: that of the rest
   before.
6. ``model_grid``: the model's times, around the first motion.

A record that a step cannot use is rejected with its file's name, the line where there is one, and
the reason. It remains in the result as a missing curve, and the other files are read.

Whole samples are kept where the rates allow: averaging would change their noise. What is left of
the first motion's time after rounding to a sample is part of the onset, which is inferred.

Example:
    >>> import tempfile
    >>> time = 0.1 * np.arange(800)
    >>> travel = 16 / (1 + np.exp(22 - time))
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = f"{folder}/operation_7.csv"
    ...     rows = np.column_stack([1e-3 * time, travel])
    ...     np.savetxt(file, rows, delimiter=",", header="time,travel", comments="")
    ...     curves = read_curves([Operation(7, file)], {}, Grid(np.arange(-2.0, 30.0)), "closing")
    >>> curves.accepted.values, curves.missing.values, curves.travel.shape
    (array([ True]), array([0]), (1, 32))
"""

import logging
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from breaker.model.quantities import ABOUT, SPEEDS, Speed, quantities_of
from breaker.records.axes import Scale
from breaker.records.files import Files, RejectedCurveError, printable
from breaker.records.grid import (
    Grid,
    Gridded,
    check_missing,
    grid_remarks,
    onset_remark,
)
from breaker.records.measurements import Measured
from breaker.records.noise import Noise, noise_remarks
from breaker.records.operations import Operation
from breaker.records.record import Preparation, Raw, read_raw, read_raws
from breaker.records.rejections import UnusableError

if TYPE_CHECKING:  # what reads single records does without
    import xarray as xr

_UNITS = {
    **dict.fromkeys(("first_motion", "contact_time", "contact_sd", "latch_time"), "ms"),
    **{"masked": "1", "noise": "mm", "colour": "1", "rate": "kHz"},
    **{"record_noise": "mm", "record_colour": "1"},
}
_MEASURED = {"measured": float, "measured_sd": float, "measured_reason": str}
_NUMBERS = dict.fromkeys(_UNITS, np.nan) | {"masked": 0}  # of a record that is rejected


@dataclass(frozen=True, kw_only=True)
class ReadRecord(Raw):
    """A record on the model's grid.

    Attributes:
        noise: Noise at rest.
        gridded: The record on the grid.
        remarks: What is doubtful, in words.
    """

    noise: Noise
    gridded: Gridded
    remarks: tuple[str, ...]

    @property
    def numbers(self) -> dict[str, float]:
        """What the dataset of ``read_curves`` has of it, beside the travel."""
        return {
            "first_motion": self.gridded.start,
            "contact_time": self.contact.time - self.gridded.start,
            "contact_sd": self.contact.sd,
            "latch_time": self.moves - self.contact.trigger,
            "masked": int((self.doubts[self.inside] != "").sum()),
            "noise": self.noise.sd,
            "colour": self.noise.colour,
            "rate": (len(self.time) - 1) / float(self.time[-1] - self.time[0]),
            **dict(zip(("record_noise", "record_colour"), self.process, strict=True)),
        }


def read_curves(
    operations: Sequence[Operation],
    settings: Mapping,
    grid: Grid,
    motion: str,
    *,
    speeds: Sequence[Speed] = SPEEDS,
    preparation: Preparation | None = None,
) -> "xr.Dataset":
    """Read the records of several operations.

    Args:
        operations: The operations, and where their records are.
        settings: The section ``endurance.format`` of the configuration; what it lacks has its
            default.
        grid: The model's.
        motion: "closing" or "opening".
        preparation: Of the records, ``inspection.preparation.Prepared``; none as they are.

    Returns:
        Dataset over ``operation``, ``time``: ``travel`` (mm; NaN where a sample is missing, or
        all are, where the file was rejected), ``missing``: the number of these samples,
        ``record`` (mm), the motion as it is in the file, over ``sample``, with ``record_noise``
        (mm) and ``record_colour`` of a sample;
        ``accepted``, ``reason``, ``file``, ``first_motion``: the file's time that is 0 on the
        grid, ms; ``contact_time``: when the main contact touched or parted, ms on the grid, and
        ``contact_sd``, its error's; ``latch_time``: from the trigger to the first motion, ms, NaN
        where not known; ``remarks``: what is doubtful about an accepted record, in words, empty if
        nothing is; ``masked``: doubtful samples left out; ``noise`` (mm) and ``colour``: standard
        deviation and correlation from one sample to the next at rest; ``rate``: samples of the
        file in a ms, kHz; what is known of each operation, ``ABOUT``; and over ``operation`` and
        ``quantity`` what is read from the record itself: ``measured``, ``measured_sd`` and
        ``measured_reason``, why there is none.

    Raises:
        ValueError: If the settings lack something, or name an unknown unit or encoding.
    """
    records = read_records(operations, settings, grid, motion, preparation=preparation)
    return _dataset(operations, records, grid.times, motion, speeds)


def read_records(
    operations: Sequence[Operation],
    settings: Mapping,
    grid: Grid,
    motion: str,
    *,
    preparation: Preparation | None = None,
) -> list[ReadRecord | RejectedCurveError]:
    """Read the records of several operations: each of them, or why it cannot be used.

    Args:
        operations, settings, grid, motion, preparation: As of ``read_curves``; it raises as that.
    """
    records: list[ReadRecord | RejectedCurveError] = []
    first: dict[bytes, Operation] = {}
    for raw in read_raws(operations, settings, motion, preparation=preparation)[0]:
        try:
            if isinstance(raw, RejectedCurveError):
                raise raw
            of = first.setdefault(raw.left.tobytes(), raw.operation)
            if of is not raw.operation:
                copied = f"holds the same samples as {printable(of.file)}: they count once"
                raise RejectedCurveError(raw.operation.file, copied)
            records.append(_to_grid(raw, grid))
        except RejectedCurveError as error:
            records.append(error)
            logging.getLogger("breaker").warning("rejected: %s", error)
    return records


def _dataset(
    operations: Sequence[Operation],
    records: Sequence[ReadRecord | RejectedCurveError],
    times: np.ndarray,
    motion: str,
    speeds: Sequence[Speed],
) -> "xr.Dataset":
    """Records, or why there is none, as the dataset of ``read_curves``."""
    import xarray as xr

    read = [record if isinstance(record, ReadRecord) else None for record in records]
    known = [one.operation if one else row for one, row in zip(read, operations, strict=True)]
    travel, whole = _samples(read, len(times))
    texts = {
        "reason": ["" if isinstance(record, ReadRecord) else str(record) for record in records],
        "remarks": ["; ".join(each.remarks) if each else "" for each in read],
        "file": [printable(each.file) for each in operations],
    }
    of_each = {
        "missing": np.isnan(travel).sum(axis=1),
        "accepted": np.array([each is not None for each in read], dtype=bool),
        **{name: np.array(values, dtype=str) for name, values in texts.items()},
        **{name: np.array([getattr(each, name) for each in known]) for name in ABOUT},
    }
    numbers = [each.numbers if each else _NUMBERS for each in read]
    names = quantities_of(motion, speeds, ("record",))
    rejected = dict.fromkeys(names, Measured(np.nan, np.nan, "the record was rejected"))
    rows = [each.measured(speeds) if each else rejected for each in read]
    shape = len(rows), len(names)
    measured = {
        name: np.array([[row[each][i] for each in names] for row in rows], kind).reshape(shape)
        for i, (name, kind) in enumerate(_MEASURED.items())
    }
    return xr.Dataset(
        {
            "travel": (("operation", "time"), travel, {"unit": "mm"}),
            "record": (("operation", "sample"), whole, {"unit": "mm"}),
            **{name: ("operation", values) for name, values in of_each.items()},
            **{
                name: ("operation", np.array([each[name] for each in numbers]), {"unit": unit})
                for name, unit in _UNITS.items()
            },
            **{name: (("operation", "quantity"), values) for name, values in measured.items()},
        },
        coords={
            "operation": ("operation", [each.number for each in operations]),
            "time": ("time", times, {"unit": "ms"}),
            "sample": np.arange(whole.shape[1]),
            "quantity": list(names),
            "quantity_unit": ("quantity", [each.unit for each in names.values()]),
        },
        attrs={"motion": motion},
    )


def _samples(read: Sequence[ReadRecord | None], count: int) -> tuple[np.ndarray, np.ndarray]:
    """Records on the grid ``(o, t)``, and as they are in the file ``(o, s)``; NaN where none is."""
    longest = max((each.left.size for each in read if each), default=1)
    travel = np.full((len(read), count), np.nan)
    whole = np.full((len(read), longest), np.nan, np.float32)
    for i, each in enumerate(read):
        if each:
            travel[i], whole[i, : each.left.size] = each.gridded.travel, each.left
    return travel, whole


def read_record(
    operation: Operation,
    settings: Mapping,
    scale: Scale,
    grid: Grid,
    motion: str,
    files: Files | None = None,
) -> ReadRecord:
    """Read the record of one operation.

    Args:
        settings: The section ``endurance.format``, complete.
        grid, motion: As for ``read_curves``.
        files: In which the file is opened.

    Raises:
        RejectedCurveError: If the record cannot be used.
    """
    return _to_grid(read_raw(operation, settings, scale, motion, files), grid)


def _to_grid(raw: Raw, grid: Grid) -> ReadRecord:
    """Put a record on the grid."""
    times, noise_sd, zero_sd, onset_sd = grid
    gridded = raw.on_grid(times)
    step, grid_step = (float(each[1] - each[0]) for each in (raw.time, times))
    noise = raw.noise_at(grid_step)
    back = not np.isnan(raw.segment.back)
    try:
        check_missing(gridded, raw.settings["missing"])
        remarks = [
            raw.warning,
            *raw.remarks_on(noise_sd, zero_sd),
            onset_remark(raw.first_motion_sd, onset_sd),
            *grid_remarks(gridded, raw.time[raw.inside], times, back=back),
            *([] if noise_sd is None else noise_remarks(noise, noise_sd, step, times)),
        ]
    except UnusableError as error:
        raise RejectedCurveError(raw.operation.file, str(error)) from error
    said = tuple(remark for remark in remarks if remark)
    of_file = {each.name: getattr(raw, each.name) for each in fields(raw)}
    record = ReadRecord(**of_file, noise=noise, gridded=gridded, remarks=said)
    vars(record).update(vars(raw) | vars(record))  # what was computed of these fields, too
    return record


def open_curves(stores: Sequence[str | Path], *, without: Collection[str] = ()) -> "xr.Dataset":
    """Read stores of what ``read_curves`` returned as one dataset over ``operation``.

    Args:
        without: Variables that are not read, as far as there are such.

    Raises:
        RejectedCurveError: If not one operation was accepted, since then the settings are wrong;
            the first reasons are listed.
    """
    import xarray as xr

    from breaker.common.zarr_store import open_store

    parts = [open_store(store).drop_vars(without, errors="ignore") for store in stores]
    curves = xr.concat(parts, dim="operation", join="outer", combine_attrs="override").load()
    if not curves.accepted.any():
        raise RejectedCurveError(
            Path(str(curves.file.values[0])).parent,
            f"none of {curves.sizes['operation']} {curves.attrs['motion']} files can be used; "
            "check endurance.format and the folder. The first reasons: "
            + " | ".join(curves.reason.values[:3].tolist()),
        )
    return curves
