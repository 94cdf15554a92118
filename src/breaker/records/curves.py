"""Put measured records on the grid of a model: one dataset for all operations of a motion.

A rejected record remains in the result as a missing curve with its reason. Whole samples are kept
where the rates allow, since averaging would change the noise. Rounding the first motion to a sample
leaves a rest, which is part of the inferred onset.

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
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from breaker.common.numerals import in_digits
from breaker.model.quantities import ABOUT, SPEEDS, Speed, quantities_of
from breaker.records.files import RejectedCurveError, printable
from breaker.records.grid import Grid, Gridded, check_missing, grid_remarks
from breaker.records.measurements import Measured
from breaker.records.noise import Noise, noise_remarks
from breaker.records.operations import Operation
from breaker.records.reader import Reader
from breaker.records.record import Record
from breaker.records.rejections import Remark, UnusableError

if TYPE_CHECKING:  # single records are read without xarray
    import xarray as xr

_UNITS = {
    **dict.fromkeys(("first_motion", "contact_time", "contact_sd", "latch_time"), "ms"),
    **{"masked": "1", "noise": "mm", "colour": "1", "rate": "kHz"},
    **{"record_noise": "mm", "record_colour": "1"},
}
_MEASURED = {"measured": float, "measured_sd": float, "measured_reason": str}
_REJECTED = dict.fromkeys(_UNITS, np.nan) | {"masked": 0}


@dataclass(frozen=True)
class GriddedRecord:
    """A record on the grid of a model.

    Attributes:
        record: The record as in its file.
        gridded: Its travel on the grid.
        noise: Noise at rest.
        remarks: Remarks on the record and on how it fits the grid.
    """

    record: Record
    gridded: Gridded
    noise: Noise
    remarks: tuple[str, ...]

    @property
    def numbers(self) -> dict[str, float]:
        """Numbers of the record in the dataset of ``read_curves``, by name."""
        record, start = self.record, self.gridded.start
        return {
            "first_motion": start,
            "contact_time": record.contact.time - start,
            "contact_sd": record.contact.sd,
            "latch_time": record.moves - record.contact.trigger,
            "masked": record.masked,
            "noise": self.noise.sd,
            "colour": self.noise.colour,
            "rate": 1.0 / record.step,
            **dict(zip(("record_noise", "record_colour"), record.process, strict=True)),
        }


def read_curves(
    operations: Sequence[Operation],
    settings: Mapping,
    grid: Grid,
    motion: str,
    *,
    speeds: Sequence[Speed] = SPEEDS,
) -> "xr.Dataset":
    """Read the records of several operations.

    Args:
        operations: The operations, and where their records are.
        settings: The section ``endurance.format`` of the configuration; missing keys have their
            default.
        grid: Grid of the model.
        motion: "closing" or "opening".
        speeds: Definitions of the speeds.

    Returns:
        Dataset over ``operation``, ``time``: ``travel`` (mm; NaN where a sample is missing, and in
        all of a rejected record), ``missing``: number of these samples; ``record`` (mm), the motion
        as in its file, over ``sample``, with ``record_noise`` (mm) and ``record_colour`` of a
        sample; ``accepted``, ``reason``, ``file``; ``first_motion``: time in the file that is 0 on
        the grid, ms; ``contact_time`` on the grid, ms, and ``contact_sd``; ``latch_time``: from
        trigger to first motion, ms, NaN if unknown; ``remarks``; ``masked``: number of doubtful
        samples left out; ``noise`` (mm) and ``colour``: standard deviation at rest, and correlation
        from one sample to the next; ``rate``, kHz; columns ``ABOUT`` of the operations; and over
        ``operation`` and ``quantity``: ``measured``, ``measured_sd`` and ``measured_reason``.

    Raises:
        ValueError: If a setting is unknown or wrong by itself.
    """
    records = read_records(operations, settings, grid, motion)
    return _dataset(operations, records, grid.times, motion, speeds)


def read_records(
    operations: Sequence[Operation], settings: Mapping, grid: Grid, motion: str
) -> list[GriddedRecord | RejectedCurveError]:
    """Read the records of several operations: each a record on the grid, or why it is rejected.

    A record with the same samples as an earlier one is rejected as its copy. Arguments and errors
    are those of ``read_curves``.
    """
    results: list[GriddedRecord | RejectedCurveError] = []
    first: dict[bytes, Operation] = {}
    for record in Reader(settings).read_all(operations, motion)[0]:
        try:
            if isinstance(record, RejectedCurveError):
                raise record
            original = first.setdefault(record.left.tobytes(), record.operation)
            if original is not record.operation:
                reason = f"has the same samples as {printable(original.file)}: a copy counts once"
                raise RejectedCurveError(record.operation.file, reason)
            results.append(put_on_grid(record, grid))
        except RejectedCurveError as error:
            results.append(error)
            logging.getLogger("breaker").warning("rejected: %s", error)
    return results


def put_on_grid(record: Record, grid: Grid) -> GriddedRecord:
    """Put a record on the grid of a model.

    Raises:
        RejectedCurveError: If too many samples of the grid are missing.
    """
    gridded = record.on_grid(grid.times)
    noise = record.noise_at(float(grid.times[1] - grid.times[0]))
    try:
        check_missing(gridded, record.settings["missing"])
        remarks = [
            record.warning,
            *record.remarks_on(grid.zero_sd),
            _onset_remark(record.first_motion_sd, grid.onset_sd),
            *grid_remarks(gridded, record.time[record.inside], grid.times),
        ]
    except UnusableError as error:
        raise RejectedCurveError(record.operation.file, str(error)) from error
    if grid.noise_sd is not None:
        remarks += noise_remarks(noise, grid.noise_sd, record.step, grid.times)
    return GriddedRecord(record, gridded, noise, tuple(filter(None, remarks)))


def _onset_remark(sd: float, assumed: float | None) -> str:
    if not assumed or sd <= assumed:
        return ""
    return Remark("onset-vague", sd=in_digits(sd, 2), assumed=assumed)


def _dataset(
    operations: Sequence[Operation],
    results: Sequence[GriddedRecord | RejectedCurveError],
    times: np.ndarray,
    motion: str,
    speeds: Sequence[Speed],
) -> "xr.Dataset":
    """Return the dataset of ``read_curves``."""
    import xarray as xr

    accepted = [isinstance(result, GriddedRecord) for result in results]
    records = [result if ok else None for result, ok in zip(results, accepted, strict=True)]
    known = [
        one.record.operation if one else row for one, row in zip(records, operations, strict=True)
    ]
    longest = max((each.record.left.size for each in records if each), default=1)
    travel = np.full((len(records), len(times)), np.nan)
    samples = np.full((len(records), longest), np.nan, np.float32)
    for row, each in enumerate(records):
        if each:
            travel[row] = each.gridded.travel
            samples[row, : each.record.left.size] = each.record.left
    texts = {
        "reason": ["" if ok else str(result) for result, ok in zip(results, accepted, strict=True)],
        "remarks": ["; ".join(each.remarks) if each else "" for each in records],
        "file": [printable(operation.file) for operation in operations],
    }
    columns = {
        "missing": np.isnan(travel).sum(axis=1),
        "accepted": np.array(accepted, dtype=bool),
        **{name: np.array(values, dtype=str) for name, values in texts.items()},
        **{name: np.array([getattr(each, name) for each in known]) for name in ABOUT},
    }
    numbers = [each.numbers if each else _REJECTED for each in records]
    quantities, measured = _measured(records, motion, speeds)
    return xr.Dataset(
        {
            "travel": (("operation", "time"), travel, {"unit": "mm"}),
            "record": (("operation", "sample"), samples, {"unit": "mm"}),
            **{name: ("operation", values) for name, values in columns.items()},
            **{
                name: ("operation", np.array([each[name] for each in numbers]), {"unit": unit})
                for name, unit in _UNITS.items()
            },
            **{name: (("operation", "quantity"), values) for name, values in measured.items()},
        },
        coords={
            "operation": ("operation", [each.number for each in operations]),
            "time": ("time", times, {"unit": "ms"}),
            "sample": np.arange(longest),
            "quantity": list(quantities),
            "quantity_unit": ("quantity", [each.unit for each in quantities.values()]),
        },
        attrs={"motion": motion},
    )


def _measured(
    records: Sequence[GriddedRecord | None], motion: str, speeds: Sequence[Speed]
) -> tuple[Mapping, dict[str, np.ndarray]]:
    """Return the quantities that records show, and their values, sds and reasons, ``(o, q)``."""
    quantities = quantities_of(motion, speeds, ("record",))
    rejected = dict.fromkeys(quantities, Measured(np.nan, np.nan, "the record was rejected"))
    rows = [each.record.measured(speeds) if each else rejected for each in records]
    shape = len(rows), len(quantities)
    measured = {}
    for place, (name, kind) in enumerate(_MEASURED.items()):
        values = [row[quantity][place] for row in rows for quantity in quantities]
        measured[name] = np.array(values, kind).reshape(shape)
    return quantities, measured


def open_curves(stores: Sequence[str | Path], *, without: Collection[str] = ()) -> "xr.Dataset":
    """Read stores of what ``read_curves`` returned as one dataset over ``operation``.

    Args:
        stores: Stores of one motion.
        without: Variables that are not read.

    Raises:
        RejectedCurveError: If every operation was rejected; the first reasons are listed.
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
