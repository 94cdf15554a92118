r"""The size of a drive, read from its records: an answer for any drive without a training.

The reference drive's prior, sensor and learned error hold for a drive of another size once they
are scaled (``breaker.mechanism.Size``). A size that is only read from records is not known exactly,
so its factors count as shared by all parameters, with a wide prior of their own
(``Prior.sized(size, unknown)``): the posterior hardly depends on the place about which that prior
stands. The learned error moves with the size that a draw makes likely, to first order
(``Discrepancy.of_unknown_size``). So the size at which grid and errors stand has to be near:

1. Of some sizes about the stroke and the travel time over those of the reference drive, that of the
   highest evidence (by Laplace's method) is the first. A damper may make a motion long: from the
   landmarks alone, one record in forty would lead to a size that is a third too large.
2. At the posterior modes of some records, the size's factors are expected to be others,
   ``E[u | z]``, given the reference drive's spread of each parameter. The size moves there.
3. The records are put on the grid of that size, and so on, until the size stays.

All records of a call are of one drive, both motions together. Works without torch.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
import xarray as xr

from breaker.files import Operation
from breaker.mechanism import NAMES, UNIT, Size, Speed, speeds_of
from breaker.model import Model, Sensor
from breaker.posterior.laplace import mode
from breaker.records import Raw, curves_of, read_raws

__all__ = ["DriveRecords", "network_remarks", "read_drive"]

_UNKNOWN = 0.3  # sd of the logarithms of a size that is read from records: next to nothing known
_RECORDS = 3  # of each motion, from which the size is read
_ROUNDS = 12
# Logarithms of the sizes that are tried first, beside that of the landmarks: a damper that acts on
# most of the way makes the motion long.
_STARTS = ((0.0, 0.0), (0.0, -0.2), (0.0, -0.4), (0.0, 0.2))
_REACHED = 0.02  # change of the logarithm of the size, far below its uncertainty
_FARTHEST = 0.5  # of a round
_SHARES = (0.1, 0.5)  # of the way, between which the travel time is read: before dampers act
# mm, sd of what the components of the learned error leave out of the reference drive: 0.002 mm over
# the whole record, but up to 0.05 mm where contacts touch and dampers act. With 0.002 mm, 90 %
# intervals of records without noise cover 63 to 90 %; with 0.02 mm 82 to 97 %.
_LEFT_OUT = 0.02
_NOISE = 1.5  # factor on the noise that a network was trained with, beyond which its answer is off
_MISSING = 0.02  # share of missing samples from which they matter to a network
_WHOLE = 10  # samples of a record in a step of the grid, from which it takes whole ones


@dataclass(frozen=True)
class DriveRecords:
    """The records of one drive, and the models that they are to be inferred with.

    Attributes:
        size: Size of the drive beside that of the models given.
        noise_sd: Standard deviation of the noise of a sample that the models take, mm.
        models: Joint model of each motion.
        curves: Records of each motion on its model's grid: see ``records.read_curves``.
        speeds: How speeds are defined.
        said: What was chosen and from what, in words.
    """

    size: Size
    noise_sd: float
    models: Mapping[str, Model]
    curves: Mapping[str, xr.Dataset]
    speeds: tuple[Speed, ...]
    said: tuple[str, ...]


def read_drive(
    operations: Mapping[str, Sequence[Operation]],
    format_settings: Mapping,
    models: Mapping[str, Model],
    *,
    size: Size | None = None,
    noise_sd: float | None = None,
    speeds: Mapping[str, Sequence[str] | None] | None = None,
) -> DriveRecords:
    """Read records of one drive, of any size.

    Args:
        operations: Operations of each motion, and where their records are.
        format_settings: The section ``endurance.format`` of the configuration; what it lacks has
            its default.
        models: Joint model of each motion, of the size 1: those of the reference drive
            (``reference_model``), or of a prior and sensor of one's own.
        size: Size of the drive beside the models', where it is known. None reads it from the
            records, and the posterior then allows for its being uncertain.
        noise_sd: Standard deviation of the noise, mm, where it is known. None reads it from the
            records.
        speeds: The section ``speeds`` of the configuration.
    """
    raws = {m: read_raws(each, format_settings, m) for m, each in operations.items()}
    usable = {m: [raw for raw in each if isinstance(raw, Raw)] for m, each in raws.items()}
    usable = {m: each for m, each in usable.items() if each}
    said, unknown, read_noise = [], 0.0, noise_sd is None
    if read_noise:
        noise_sd = seen_noise(usable)
    if size is None and usable:
        size, unknown = read_size(usable, models, noise_sd), _UNKNOWN
        said.append(_size_in_words(size, usable))
    size = size or UNIT
    defined = speeds_of(speeds, size)
    sized = {m: at_size(models[m], size, unknown, noise_sd) for m in operations}
    if read_noise and usable:
        sized = {m: _with_left_out(each, size) for m, each in sized.items()}
        said.append(_noise_in_words(noise_sd, max(each.sensor.noise_sd for each in sized.values())))
    curves = {
        m: curves_of(
            *(each, raws[m], sized[m].sensor.times, m),
            noise_sd=noise_sd or sized[m].sensor.noise_sd,
            zero_sd=sized[m].sensor.zero_sd,
            speeds=defined,
            chosen=unknown > 0.0,
        )
        for m, each in operations.items()
    }
    noise_sd = max(each.sensor.noise_sd for each in sized.values())
    return DriveRecords(size, noise_sd, sized, curves, defined, tuple(said))


def at_size(model: Model, size: Size, unknown: float, noise_sd: float | None) -> Model:
    """Return the model at a size, with the noise of records.

    Args:
        model: Joint model of the size 1.
        size, unknown: As for ``Model.sized``.
        noise_sd: Of the records, mm; None leaves that of the sensor, scaled.
    """
    sized = model.sized(size, unknown)
    if noise_sd is None:
        return sized
    return replace(sized, sensor=replace(sized.sensor, noise_sd=noise_sd))


def _with_left_out(model: Model, size: Size) -> Model:
    """A model whose noise includes what the components of the learned error leave out."""
    if model.sensor.discrepancy is None:
        return model
    noise_sd = float(np.hypot(model.sensor.noise_sd, _LEFT_OUT * size.lengths))
    return replace(model, sensor=replace(model.sensor, noise_sd=noise_sd))


def network_remarks(sensor: Sensor, noise_sd: float, curves: xr.Dataset) -> list[str]:
    """Say where records are not of the kind that a network was trained for at their size.

    Args:
        sensor: That of the network, at the size: ``Posterior.sized(size).sensor``.
        noise_sd: Noise of the records, mm.
        curves: The records on its grid: see ``records.read_curves``.
    """
    remedy = "start from the mode instead of the network, which is exact for any record, or train"
    remarks = []
    ratio = noise_sd / sensor.noise_sd
    if not 1 / _NOISE < ratio < _NOISE:
        remarks.append(
            f"the noise is {noise_sd:.2g} mm, and the network knows {sensor.noise_sd:.2g} mm at "
            f"this size; {remedy} one with sensor.noise_sd {ratio:.2g} times as large"
        )
    slow = curves.accepted & (curves.missing > _MISSING * curves.sizes["time"])
    if slow.any():
        share = float(curves.missing.where(slow).max()) / curves.sizes["time"]
        remarks.append(
            f"{int(slow.sum())} of {slow.size} records have no sample for up to {share:.0%} of the "
            f"network's times, which are {sensor.step:.2g} ms apart at this size; {remedy} one "
            "whose summary is a deep_set, which takes missing samples; or record longer, or faster"
        )
    return remarks


def seen_noise(raws: Mapping[str, Sequence[Raw]]) -> float | None:
    """Return the median noise of records at rest, mm, rounding included; None if none is seen."""
    seen = [
        max(noise, raw.quantum / np.sqrt(12.0))
        for each in raws.values()
        for raw in each
        if np.isfinite(noise := raw.noise_at(raw.step).sd)
    ]
    return float(np.median(seen)) if seen and np.median(seen) > 0.0 else None


def read_size(
    raws: Mapping[str, Sequence[Raw]], models: Mapping[str, Model], noise_sd: float | None
) -> Size:
    """Return the size with which the posterior modes of records agree.

    Args:
        raws: Records of each motion.
        models: Joint model of each motion, of the size 1.
        noise_sd: Noise of the records, mm; None takes that of the models, scaled.
    """
    some = [(m, each[i]) for m, each in raws.items() for i in _spread(len(each))]
    logs = np.median([_landmarks(raw) for _, raw in some], axis=0)
    logs -= np.mean([_reference(models[m]) for m in raws], axis=0)
    first = [(m, each[0]) for m, each in raws.items()]
    starts = [logs + start for start in _STARTS]
    # At no less noise than that of the models: that takes fewer steps, and tells sizes apart.
    noisy = [max(noise_sd or 0.0, models[m].sensor.noise_sd * np.exp(logs[0])) for m, _ in first]
    evidence = [
        sum(
            _mode(models[m], raw, at, sd).evidence
            for (m, raw), sd in zip(first, noisy, strict=True)
        )
        for at in starts
    ]
    logs, found = starts[int(np.argmax(evidence))], [None] * len(some)
    for _ in range(_ROUNDS):
        found = [
            _mode(models[m], raw, logs, noise_sd, last)
            for (m, raw), last in zip(some, found, strict=True)
        ]
        move = np.mean([each.move for each in found], axis=0)
        logs = logs + np.clip(move, -_FARTHEST, _FARTHEST)
        if np.abs(move).max() < _REACHED:
            break
    steps = np.median([raw.step for _, raw in some]), np.mean([models[m].sensor.step for m in raws])
    return _whole_samples(Size(*np.exp(logs).tolist()), *map(float, steps))


class _Mode(NamedTuple):
    """Posterior mode of a record at a size.

    Attributes:
        values: Outputs there, ``(q,)``, physical units.
        move: By how much the logarithms of the size are expected to be others, ``(2,)``.
        evidence: Log evidence by Laplace's method, over that of noise alone.
    """

    values: np.ndarray
    move: np.ndarray
    evidence: float


def _mode(
    model: Model, raw: Raw, logs: np.ndarray, noise_sd: float | None, near: _Mode | None = None
) -> _Mode:
    """Climb to the posterior mode of a record at a size, from one nearby if there is one."""
    size = Size(*np.exp(logs).tolist())
    model = _with_left_out(at_size(model, size, _UNKNOWN, noise_sd), size)
    record = raw.on_grid(model.sensor.times).travel
    z, precision = mode(model, record, None if near is None else model.standardise(near.values))
    noise = np.log(model.sensor.noise_sd) + 0.5 * np.log(2 * np.pi * np.e)
    over_noise = float(model.log_joint(z[None], record)[0]) + noise * np.isfinite(record).sum()
    evidence = over_noise - 0.5 * float(np.linalg.slogdet(precision)[1])
    move = _UNKNOWN * (model.prior.expects @ z[: len(NAMES)])
    return _Mode(model.destandardise(z), move, evidence)


def _spread(count: int) -> np.ndarray:
    """Numbers of some records, spread over all."""
    return np.unique(np.linspace(0, count - 1, min(count, _RECORDS)).round().astype(int))


def _landmarks(raw: Raw) -> np.ndarray:
    """Logarithms of stroke and travel time of a record."""
    return np.log([raw.segment.stroke, raw.duration(*_SHARES)])


def _reference(model: Model) -> np.ndarray:
    """The same of the curve at the prior's medians."""
    medians = np.zeros((1, len(model.outputs)))
    curve, times = model.curves(model.destandardise(medians))[0], model.sensor.times
    way = np.maximum.accumulate((curve - curve[0]) / (curve[-1] - curve[0]))
    begins, ends = np.interp(_SHARES, way, times)
    return np.log([abs(curve[-1] - curve[0]), ends - begins])


def _whole_samples(size: Size, step: float, grid_step: float) -> Size:
    """The size next to one at which steps of the grid are whole samples, where these are short."""
    every = size.times * grid_step / step
    return replace(size, times=round(every) * step / grid_step) if every >= _WHOLE else size


def _size_in_words(size: Size, raws: Mapping[str, Sequence[Raw]]) -> str:
    """What was read, in words."""
    strokes = [raw.segment.stroke for each in raws.values() for raw in each]
    count = "1 record" if len(strokes) == 1 else f"{len(strokes)} records"
    return (
        f"size read from {count}: lengths {size.lengths:.3g} and times {size.times:.3g} times "
        f"those of the reference drive (stroke {np.median(strokes):.4g} mm)"
    )


def _noise_in_words(seen: float | None, taken: float) -> str:
    """What was read of the noise, in words."""
    if seen is None:
        return (
            f"the noise is not seen at rest; taken as {taken:.2g} mm, that of the reference drive "
            "at this size: give sensor.noise_sd, or record more rest before the motion"
        )
    more = ", what the learned error leaves out included" if taken > 1.1 * seen else ""
    return f"noise read at rest: {taken:.2g} mm{more}"
