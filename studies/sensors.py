"""Sensors of simulated drives, and the records of a life that they read.

Some sensors round, and some have noise of a colour. A record begins 8 ms before the motion.
"""

from collections.abc import Callable, Iterable
from contextlib import suppress
from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter

from breaker.family.inputs import network_record
from breaker.family.shape import shape_of
from breaker.model.sensor import Sensor
from breaker.prognosis.series import MotionRecords
from breaker.records.measurements import Measured, measure_curve

ONSET, STEP = 0.3, 0.2  # ms: sd of the first motion, and time from sample to sample
TIMES = np.arange(-8.0, 64.0, STEP)
MEASURED = {"closing": ["stroke", "travel_time"], "opening": ["stroke", "travel_time"]}
_REST = 35  # samples before the motion
_ROUNDED = 0.5  # share of the sensors that round their readings,
_QUANTUM = (0.05, 0.3)  # mm, to a multiple of this, log-uniform
_COLOURED = 0.25  # share of those whose noise is correlated from sample to sample
_COLOUR = (0.3, 0.8)  # correlation of neighbouring samples, uniform


@dataclass(frozen=True)
class Reading:
    """How a drive's sensor departs from the model's.

    Attributes:
        quantum: Step to which readings are rounded, mm; 0 where they are not.
        colour: Correlation of the noise of neighbouring samples; 0 where it is white.
    """

    quantum: float
    colour: float

    @classmethod
    def draw(cls, rng: np.random.Generator) -> "Reading":
        """Draw the sensor of a drive."""
        rounds, coloured = rng.random(2) < (_ROUNDED, _COLOURED)
        quantum = np.exp(rng.uniform(*np.log(_QUANTUM)))
        colour = rng.uniform(*_COLOUR)
        return cls(float(rounds * quantum), float(coloured * colour))

    def corrupt(self, curve: np.ndarray, sensor: Sensor, rng: np.random.Generator) -> np.ndarray:
        """Add noise and zero of the model's sizes to a curve ``(t,)``, mm, and round."""
        innovations = rng.standard_normal(curve.shape)
        innovations[1:] *= np.sqrt(1.0 - self.colour**2)
        noise = lfilter([1.0], [1.0, -self.colour], innovations)
        read = curve + sensor.noise_sd * noise + sensor.zero_sd * rng.standard_normal()
        return self.quantum * np.round(read / self.quantum) if self.quantum else read


def recorded(
    travels: Iterable[Callable[[np.ndarray], np.ndarray]],
    motion: str,
    sensor: Sensor,
    reading: Reading,
    rng: np.random.Generator,
) -> MotionRecords:
    """Record travels, mm, functions of the time after the start of motion, ms."""
    sign = 1.0 if motion == "closing" else -1.0
    shapes, noises, rows, units = [], [], [], None
    for travel in travels:
        late = ONSET * rng.standard_normal()
        record = reading.corrupt(travel(TIMES - late), sensor, rng)
        units = units or shape_of(sign * record, STEP)
        shapes.append(shape_of(sign * record, STEP, units))
        sd = max(float(record[:_REST].std()), reading.quantum / np.sqrt(12.0))
        noises.append(network_record(shapes[-1], sd, reading.colour, STEP, units).noise[0])
        rows.append(measured(record, motion))
    none = Measured(np.nan, np.nan, "")
    read = {q: np.array([row.get(q, none)[:2] for row in rows]).T for q in MEASURED[motion]}
    return MotionRecords(
        way=np.array([shape.way for shape in shapes]),
        present=np.array([shape.present for shape in shapes]),
        noise=np.array(noises),
        stroke=units.stroke,
        duration=units.duration,
        measured={name: values for name, (values, _) in read.items()},
        stated={name: sds for name, (_, sds) in read.items()},
    )


def measured(curve: np.ndarray, motion: str) -> dict[str, Measured]:
    """Measure a curve at ``TIMES``; a curve without a motion has no quantities."""
    with suppress(ValueError, FloatingPointError):
        return measure_curve(TIMES, curve, motion, speeds=())
    return {}
