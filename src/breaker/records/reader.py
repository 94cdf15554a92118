"""Measured curves from CSV files: checked, and put on the model's grid.

A file holds one operation of one motion. Explicit settings describe it (columns, units, delimiter,
the reading of the open breaker at rest); nothing is guessed. A file that cannot be used is rejected
with its name, the line where there is one, and the reason. It remains in the result as a missing
curve, and the other files are read.

Whole samples are kept: averaging or interpolating would change their noise. What is left of the
first motion's time after rounding to a sample is part of the onset, which is inferred. A sample is
missing, NaN, where its cell is empty or NaN, or its line is: where time makes a gap of whole steps.

Example:
    >>> import tempfile
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
from pathlib import Path

import numpy as np
import xarray as xr

from breaker.records.files import RejectedCurveError, printable
from breaker.records.landmarks import NoMotionError, first_motion
from breaker.records.manifest import ABOUT, Operation
from breaker.records.settings import TO_MM, TO_MS, complete
from breaker.records.sources import read_columns
from breaker.stores import open_store

__all__ = [
    "RejectedCurveError",
    "open_curves",
    "read_curve",
    "read_curves",
    "require_any",
    "write_curve",
]

_STROKES = (4.0, 60.0)  # mm, between the rest positions of any medium-voltage breaker
_REST = 2.0  # mm, farthest that the open breaker may rest from zero
_PREAMBLE = ("travel record", "motion: {motion}", "operation: {operation}", "zero: open position")


def read_curves(
    operations: Sequence[Operation],
    settings: Mapping,
    times: np.ndarray,
    motion: str,
    *,
    noise_sd: float | None = None,
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

    Returns:
        Dataset over ``operation``, ``time``: ``travel`` (mm; NaN where a sample is missing, or
        all are, where the file was rejected), ``missing``: the number of these samples,
        ``accepted``, ``reason``, ``file``, ``first_motion``: the file's time that is 0 on the
        grid, ms; ``remarks``: what is doubtful about an accepted record, in words, empty if
        nothing is; ``masked``: doubtful samples left out; ``noise`` (mm) and ``colour``: standard
        deviation and correlation from one sample to the next at rest; and what is known of each
        operation, ``ABOUT``.

    Raises:
        ValueError: If the settings lack something, or name an unknown unit or encoding.

    """
    settings = complete(settings)
    travel = np.full((len(operations), len(times)), np.nan)
    start, reasons = np.full(len(operations), np.nan), [""] * len(operations)
    for i, operation in enumerate(operations):
        try:
            travel[i], start[i] = read_curve(operation.file, settings, times, motion)
        except RejectedCurveError as error:
            reasons[i] = str(error)
            logging.getLogger("breaker").warning("rejected: %s", error)
    accepted = np.array([not reason for reason in reasons], dtype=bool)
    about = {name: [getattr(each, name) for each in operations] for name in ABOUT}
    number = np.zeros(len(operations))
    return xr.Dataset(
        {
            "travel": (("operation", "time"), travel, {"unit": "mm"}),
            "missing": ("operation", np.isnan(travel).sum(axis=1)),
            "accepted": ("operation", accepted),
            "reason": ("operation", np.array(reasons, dtype=str)),
            "file": ("operation", np.array([printable(o.file) for o in operations], dtype=str)),
            "first_motion": ("operation", start, {"unit": "ms"}),
            "remarks": ("operation", np.array([""] * len(operations), dtype=str)),
            "masked": ("operation", number.astype(int)),
            "noise": ("operation", number + np.nan, {"unit": "mm"}),
            "colour": ("operation", number + np.nan),
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


def read_curve(
    file: str | Path, settings: Mapping, times: np.ndarray, motion: str
) -> tuple[np.ndarray, float]:
    """Read one file.

    Returns:
        Travel on the grid, ``(t,)``, mm, NaN where a sample is missing, and the file's time that
        is 0 on the grid, ms.

    Raises:
        RejectedCurveError: If the file cannot be used.
    """
    time, travel, step = _samples(file, settings)
    _check_travel(file, travel[~np.isnan(travel)], settings, motion)
    every = (times[1] - times[0]) / step
    if every < 0.999 or abs(every - round(every)) > 1e-3:
        raise RejectedCurveError(
            file,
            f"one sample every {step:.4g} ms does not fit the model's {times[1] - times[0]:.4g} ms "
            "a whole number of times; export at another rate, or change sensor.samples",
        )
    try:
        moves = first_motion(time, travel, 1.0 if motion == "closing" else -1.0)
    except NoMotionError as error:
        raise RejectedCurveError(file, str(error)) from error
    first = round((moves + times[0] - time[0]) / step)
    last = first + round(every) * (len(times) - 1)
    if first < 0 or last >= len(time):
        short, side = (-first, "before") if first < 0 else (last - len(time) + 1, "after")
        raise RejectedCurveError(
            file,
            f"too short: {short * step:.1f} ms are missing {side} the motion, which starts at "
            f"{moves:.2f} ms; record longer, or change sensor.start or sensor.stop",
        )
    record = travel[first : last + 1 : round(every)]
    missing = np.isnan(record).sum()
    if missing > settings["missing"] * len(times):
        raise RejectedCurveError(
            file,
            f"{missing} of the {len(times)} samples of the model's grid are missing, more than the "
            f"share of {settings['missing']:g} that endurance.format.missing allows",
        )
    return record, float(time[first] - times[0])


def write_curve(
    file: str | Path, time: np.ndarray, travel: np.ndarray, *, motion: str, operation: int
) -> None:
    """Write a record as the stand-in's instrument does: preamble, names, units, rows.

    Args:
        file: Where to write.
        time: Times, ``(t,)``, ms; written in s.
        travel: Travel, ``(t,)``, mm, zero at the open position.
        motion: Motion named in the preamble.
        operation: Operation named in the preamble.
    """
    preamble = [line.format(motion=motion, operation=operation) for line in _PREAMBLE]
    rows = [f"{t:.7f},{x:.3f}" for t, x in zip((time / 1e3).tolist(), travel.tolist(), strict=True)]
    Path(file).write_text(
        "\n".join([*preamble, "time,travel", "s,mm", *rows, ""]), encoding="utf-8"
    )


def _samples(file: str | Path, settings: Mapping) -> tuple[np.ndarray, np.ndarray, float]:
    """Time in ms, travel in mm towards closed, NaN where missing, and the time of a step, ms."""
    columns = read_columns(file, settings)
    travel, lines = columns.travel, columns.lines
    if columns.time is None:
        time = np.arange(travel.size) / settings["rate"]
    else:
        time = columns.time * TO_MS[settings["time_unit"]]
    travel = settings["sign"] * TO_MM[settings["travel_unit"]] * (travel - settings["zero"])
    if (count := np.isfinite(travel).sum()) < 2:
        raise RejectedCurveError(file, f"has {count} samples")
    place = np.append(0, np.cumsum(_whole_steps(file, time, lines)))
    _check_duration(file, time[-1] - time[0], settings)
    total = int(place[-1]) + 1
    if total > 2 * count:
        raise RejectedCurveError(file, f"{total - count} of {total} samples are missing")
    step = (time[-1] - time[0]) / (total - 1)
    if total > time.size:
        even, some = time[0] + step * np.arange(total), np.full(total, np.nan)
        even[place], some[place] = time, travel
        time, travel = even, some
    return time, travel, step


def _whole_steps(file: str | Path, time: np.ndarray, lines: np.ndarray) -> np.ndarray:
    """Steps from each sample to the next, ``(t - 1,)``; rejects times that are not on a grid."""
    steps = np.diff(time)
    if (back := np.flatnonzero(steps <= 0)).size:
        raise RejectedCurveError(file, "the time does not increase", line=int(lines[back[0] + 1]))
    # A tenth of a step is allowed to times that were printed with few digits.
    single = np.abs(steps - np.median(steps)) <= 0.1 * np.median(steps)
    step = steps[single].mean() if single.any() else np.median(steps)
    whole = np.maximum(np.rint(steps / step), 1)
    if (odd := np.flatnonzero(~single & (np.abs(steps - whole * step) > 0.1 * step))).size:
        reason = "the time steps are uneven before this line"
        raise RejectedCurveError(file, reason, line=int(lines[odd[0] + 1]))
    return whole.astype(int)


def _check_duration(file: str | Path, duration: float, settings: Mapping) -> None:
    """Reject a duration, ms, that another unit of time would make likely."""
    for unit, factor in TO_MS.items():
        likely = duration / TO_MS[settings["time_unit"]] * factor
        if not 10.0 <= duration <= 1e4 and 10.0 <= likely <= 1e4:
            raise RejectedCurveError(
                file,
                f"lasts {duration:.4g} ms; is endurance.format.time_unit {unit!r} rather than "
                f"{settings['time_unit']!r}?",
            )


def _check_travel(file: str | Path, travel: np.ndarray, settings: Mapping, motion: str) -> None:
    """Reject a stroke of wrong magnitude or direction, and a wrong zero; all samples are there."""
    edge = max(1, min(20, travel.size // 20))
    begins, ends = float(np.median(travel[:edge])), float(np.median(travel[-edge:]))
    stroke = abs(ends - begins)
    if not _STROKES[0] <= stroke <= _STROKES[1]:
        here = stroke / TO_MM[settings["travel_unit"]]
        likely = [u for u, mm in TO_MM.items() if _STROKES[0] <= here * mm <= _STROKES[1]]
        still = "did the breaker not move, or " if stroke < _STROKES[0] else ""
        hint = f"; {still}is endurance.format.travel_unit {likely[0]!r}?" if likely else ""
        raise RejectedCurveError(
            file,
            f"the stroke is {stroke:.4g} mm, not between {_STROKES[0]:g} and {_STROKES[1]:g} mm"
            + hint,
        )
    if (ends > begins) != (motion == "closing"):
        raise RejectedCurveError(
            file,
            f"the travel goes from {begins:.1f} to {ends:.1f} mm, which is no {motion}; is it in "
            "the wrong folder, or endurance.format.sign wrong?",
        )
    open_rest = begins if motion == "closing" else ends
    if abs(open_rest) > _REST:
        raise RejectedCurveError(
            file,
            f"the open breaker rests at {open_rest:.2f} mm, not near 0; set endurance.format.zero "
            "to its reading, or record the whole motion",
        )
