"""Put measured records on the grid of a model: one dataset for all operations of a motion.

Where the record's step divides the grid's, the grid takes samples unchanged. At any other rate, a
time of the grid takes the nearest sample, moved to that time by the cubic through four samples,
which never increases white noise. No sample serves two times of the grid. High rates are not
averaged, since this would change the noise unnoticed. The error of rounding the first motion to a
sample is part of the inferred onset.
"""

import logging
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from breaker.model.quantities import ABOUT, SPEEDS, Speed, quantities_of
from breaker.records.files import RejectedCurveError, printable
from breaker.records.measurements import Measured
from breaker.records.operations import Operation
from breaker.records.reader import Reader
from breaker.records.record import Record

if TYPE_CHECKING:  # single records are read without xarray
    import xarray as xr

_UNITS = {
    **dict.fromkeys(("first_motion", "contact_time", "contact_sd", "reaction_time"), "ms"),
    **{"rate": "kHz", "record_noise": "mm", "record_colour": "1", "travel": "mm", "record": "mm"},
}
_MEASURED = "measured", "measured_sd", "measured_reason"
_OVER = {"travel": ("time",), "record": ("sample",), **dict.fromkeys(_MEASURED, ("quantity",))}
_MISSING = {"mode": "constant", "constant_values": np.nan}
_REJECTED = Measured(np.nan, np.nan, "the record was rejected")


_ON = 1e-3  # samples, tolerance by which a place, or a step of the grid, counts as an integer


class Grid(NamedTuple):
    """The model's grid, and the errors that the model assumes on it; a record with other errors
    has a remark, and None compares nothing.
    """

    times: np.ndarray  # times, (t,), ms around the first motion
    noise_sd: float | None = None  # standard deviation of the noise, mm
    zero_sd: float | None = None  # standard deviation of the zero, mm
    onset_sd: float | None = None  # standard deviation of the first motion, ms


class Gridded(NamedTuple):
    """A record on the grid."""

    travel: np.ndarray  # travel, (t,), mm, NaN where a sample is missing
    start: float  # time of the record that is 0 on the grid, ms
    sampled: np.ndarray  # times of the grid for which the rate gives a sample, (t,) of bool


def on_grid(time: np.ndarray, travel: np.ndarray, times: np.ndarray, moves: float) -> Gridded:
    """Put a record on the grid; samples before it begins and after it ends are missing.

    Args:
        time, travel: Times, ms, evenly spaced, and travel, mm, NaN where missing, ``(n,)``.
        times: The model's grid, ``(t,)``, ms around the first motion.
        moves: Time of the first motion, ms.
    """
    step = float(time[-1] - time[0]) / (len(time) - 1)
    every = float(times[1] - times[0]) / step
    first = round((moves + times[0] - time[0]) / step)
    start = float(time[first] if 0 <= first < len(time) else time[0] + first * step)
    start -= float(times[0])
    if every > 0.5 and abs(every - round(every)) <= _ON:
        every = round(every)
    place = first + every * np.arange(len(times))
    nearest = np.rint(place)
    place = np.where(np.abs(place - nearest) < _ON, nearest, place)
    # If several times have the same nearest sample, the nearest of them takes it.
    sampled = np.abs(place - nearest) <= 0.5 * min(every, 1.0) + _ON
    sampled[1:] &= ~(sampled[:-1] & (nearest[1:] == nearest[:-1]))
    record = np.full(len(times), np.nan)
    record[sampled] = _cubic(travel, place[sampled])
    return Gridded(record, start, sampled)


def _cubic(travel: np.ndarray, place: np.ndarray) -> np.ndarray:
    """Interpolate at each place by the cubic through four samples; NaN if one is missing."""
    before = np.floor(place).astype(int)
    x = (place - before)[:, None]
    nodes = np.arange(-1, 3)
    others = np.array([nodes[nodes != node] for node in nodes])  # (4, 3)
    weights = np.prod((x[:, :, None] - others) / (nodes[:, None] - others), axis=2)
    indices = before[:, None] + nodes
    there = (indices >= 0) & (indices < len(travel))
    samples = np.where(there, travel[np.where(there, indices, 0)], np.nan)
    # Samples with weight 0 may be missing; other missing samples give NaN.
    return np.where(weights == 0.0, 0.0, weights * samples).sum(axis=1)


@dataclass(frozen=True)
class GriddedRecord:
    """A record as in its file and on the grid of a model, and remarks."""

    record: Record
    gridded: Gridded
    remarks: tuple[str, ...]


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
        operations, motion: The operations with the places of their records; "closing" or "opening".
        settings: The section ``endurance.format``; missing keys have their default.
        grid, speeds: Grid of the model; definitions of the speeds.

    Returns:
        Dataset over ``operation``: ``ABOUT`` of the operations, ``accepted``, ``reason``, ``file``,
        ``remarks``, the number of ``missing`` samples of ``travel`` (mm, over ``time``) and of
        ``masked`` ones of ``record`` (mm, over ``sample``: the motion as in its file),
        ``record_noise`` and ``record_colour``: sd and correlation of the noise, ``rate``, kHz,
        ``first_motion``: time in the file that is 0 on the grid, ms, ``contact_time`` on the grid,
        ``reaction_time`` from the trigger; and ``measured`` with sd and reason over ``quantity``.

    Raises:
        ValueError: If a setting is unknown or wrong by itself.
    """
    import xarray as xr

    records = read_records(operations, settings, grid, motion)
    quantities = quantities_of(motion, speeds, ("record",))
    shape = grid.times.shape
    pairs = zip(operations, records, strict=True)
    rows = [_row(*pair, shape, quantities, speeds) for pair in pairs]
    longest = max(row["record"].size for row in rows)
    for row in rows:
        row["record"] = np.pad(row["record"], (0, longest - row["record"].size), **_MISSING)
    variables = {}
    for name in rows[0]:
        values = np.array([row[name] for row in rows])
        unit = {"unit": _UNITS[name]} if name in _UNITS else {}
        variables[name] = ("operation", *_OVER.get(name, ())), values, unit
    coordinates = {
        "operation": [operation.number for operation in operations],
        "time": ("time", grid.times, {"unit": "ms"}),
        "sample": np.arange(longest),
        "quantity": list(quantities),
        "quantity_unit": ("quantity", [quantity.unit for quantity in quantities.values()]),
    }
    return xr.Dataset(variables, coordinates, {"motion": motion})


def read_records(
    operations: Sequence[Operation], settings: Mapping, grid: Grid, motion: str
) -> list[GriddedRecord | RejectedCurveError]:
    """Return a record on the grid for each operation, or the error with which it is rejected.

    A record with the same samples as an earlier record is rejected as its copy.
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
    time = record.time[record.inside]
    gridded = on_grid(time, record.left - record.rest, grid.times, record.moves)
    gaps, allowed = np.isnan(gridded.travel[gridded.sampled]), record.settings["missing"]
    if gaps.sum() > allowed * gaps.size:
        raise RejectedCurveError(
            record.operation.file,
            f"{gaps.sum()} of the {gaps.size} samples of the model's grid are missing, more than "
            f"the share of {allowed:g} that endurance.format.missing allows",
        )
    remarks = tuple(filter(None, (record.warning, *record.remarks_on(grid))))
    return GriddedRecord(record, gridded, remarks)


def _row(
    operation: Operation,
    result: GriddedRecord | RejectedCurveError,
    shape: tuple[int],
    quantities: Collection[str],
    speeds: Sequence[Speed],
) -> dict:
    """Return the values of a record by variable of the dataset, on a grid of a shape."""
    accepted = isinstance(result, GriddedRecord)
    row = {"accepted": accepted, "file": printable(operation.file)}
    row |= {"reason": "" if accepted else str(result), "remarks": "", "masked": 0}
    row |= dict.fromkeys(_UNITS, np.nan) | {"travel": np.full(shape, np.nan)}
    row |= {"record": np.full(1, np.nan, np.float32), "missing": shape[0]}
    measured = dict.fromkeys(quantities, _REJECTED)
    if accepted:
        record, start = result.record, result.gridded.start
        operation, contact, travel = record.operation, record.contact, result.gridded.travel
        row |= {"remarks": "; ".join(result.remarks), "masked": record.masked}
        row |= {"first_motion": start, "reaction_time": record.moves - contact.trigger}
        row |= {"contact_time": contact.time - start, "contact_sd": contact.sd}
        row |= {"rate": 1.0 / record.step, "travel": travel}
        row |= {"record": record.left.astype(np.float32), "missing": np.isnan(travel).sum()}
        row["record_noise"], row["record_colour"] = record.process
        measured = record.measured(speeds)
    for place, name in enumerate(_MEASURED):
        row[name] = [measured[quantity][place] for quantity in quantities]
    return row | {name: getattr(operation, name) for name in ABOUT}


def open_curves(stores: Sequence[str | Path], *, without: Collection[str] = ()) -> "xr.Dataset":
    """Read stores of results of ``read_curves`` of one motion as one dataset, without some
    variables.

    Raises:
        RejectedCurveError: If every operation was rejected; the first reasons are listed.
    """
    import xarray as xr

    from breaker.common.zarr_store import open_store

    parts = [open_store(store).drop_vars(without, errors="ignore") for store in stores]
    curves = xr.concat(parts, dim="operation", join="outer", combine_attrs="override").load()
    if not curves.accepted.any():
        count, first = curves.sizes["operation"], " | ".join(curves.reason.values[:3].tolist())
        reason = f"none of {count} {curves.attrs['motion']} files can be used; check "
        reason += f"endurance.format and the folder. The first reasons: {first}"
        raise RejectedCurveError(Path(curves.file.values[0]).parent, reason)
    return curves
