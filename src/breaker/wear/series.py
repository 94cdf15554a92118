"""Records of operations, and the likelihood of each near the trend."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import xarray as xr

from breaker.mechanism import NAMES
from breaker.model import Model, climb
from breaker.wear.events import Event
from breaker.wear.reference import Reference, onset_of

__all__ = ["Series", "likelihood", "series_of"]

_ROOM = 0.02  # share of a parameter by which an operation may differ from the prediction
_ALIKE = 5.0  # K, within which operations are compared without regard to their temperature
_MOVES = 2  # Gauss-Newton steps to where an operation's likelihood is taken


@dataclass(frozen=True)
class Series:
    """Records of some operations, in one or both motions.

    Attributes:
        operations: Their numbers, rising, ``(o,)``.
        records: Records of each motion, ``(o, t)``, mm; nan where a sample is missing, or where
            there is no record that can be used.
        outputs: Means of each motion's own posteriors, standardised, ``(o, q)``, from which modes
            are searched; nan where there is none.
        events: What was done before operations, by their number; None if nothing was.
        temperature: °C, ``(o,)``, nan where it is not known; None if none is.
    """

    operations: np.ndarray
    records: Mapping[str, np.ndarray]
    outputs: Mapping[str, np.ndarray]
    events: Mapping[int, Event] | None = None
    temperature: np.ndarray | None = None

    def event(self, i: int) -> Event:
        """What was done before operation ``i`` of the series; ``Event("")`` if nothing was."""
        return (self.events or {}).get(int(self.operations[i]), Event(""))

    def temperature_of(self, i: int) -> float:
        """Temperature of operation ``i`` of the series, °C, nan if not known."""
        return np.nan if self.temperature is None else float(self.temperature[i])

    def alike(self, places: np.ndarray) -> np.ndarray:
        """Return the most of given places ``(n,)`` with no event between, and about as warm.

        Where any has a temperature, these are within 5 K of their median.
        """
        if self.events and places.size:
            renewed = [self.event(i).renews for i in range(int(places[-1]) + 1)]
            spells = np.cumsum(renewed)[places]
            places = places[spells == np.bincount(spells).argmax()]
        if self.temperature is not None and np.isfinite(self.temperature[places]).any():
            known = self.temperature[places]
            median = np.nanquantile(known, 0.5, method="lower")  # one of them
            places = places[np.abs(known - median) <= _ALIKE]
        return places

    def usable(self, motion: str) -> np.ndarray:
        """Say which operations have a record and a posterior of a motion, ``(o,)``."""
        return np.isfinite(self.records[motion]).any(1) & np.isfinite(self.outputs[motion]).all(1)


def series_of(
    models: Mapping[str, Model],
    data: Mapping[str, xr.Dataset],
    usable: Mapping[str, np.ndarray],
    events: Mapping[int, Event] | None = None,
    temperatures: Mapping[int, float] | None = None,
) -> Series:
    """Return the series of measured operations.

    Args:
        data: What ``decisions.align`` returns of each motion, for the same operations.
        usable: Which of them have a posterior, ``(o,)``.
        events: What was done before operations, by their number.
    """
    records, outputs = {}, {}
    for motion, model in models.items():
        there = usable[motion]
        records[motion] = np.where(there[:, None], data[motion].travel.values, np.nan)
        outputs[motion] = np.full((len(there), len(model.names)), np.nan)
        draws = data[motion].draws.values[there].astype(np.float64)
        outputs[motion][there] = model.standardise(draws).mean(axis=1)
    operations = next(iter(data.values())).operation.values
    known = [(temperatures or {}).get(int(operation), np.nan) for operation in operations]
    return Series(operations, records, outputs, events, np.array(known) if temperatures else None)


def likelihood(
    models: Mapping[str, Model],
    series: Series,
    i: int,
    reference: Reference | None,
    predicted: tuple[np.ndarray, np.ndarray] | None,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the Gaussian likelihood of an operation's records; zeros without a record.

    It is taken at the mode of the likelihood times the prediction of the trend, which is widened
    for scatter and for a change not noticed yet. So that place follows the records in the
    directions that they determine, and stays at the trend in all others.

    Args:
        models: Joint model of each motion that has a usable record.
        i: Which operation of them.
        reference: Where the trend started; None before there is one.
        predicted: Predicted mean ``(p,)`` and covariance ``(p, p)`` of the standardised
            parameters; None in the first operations.

    Returns:
        Information ``(p, p)`` and slope ``(p,)`` of the log likelihood, and the standardised
        parameters where they are taken, ``(p,)``.
    """
    p, one = len(NAMES), slice(i, i + 1)
    nothing = np.zeros((p, p)), np.zeros(p), np.zeros(p)
    if not models or reference is None:
        return nothing
    records = {motion: series.records[motion][one] for motion in models}
    outputs = {motion: series.outputs[motion][one] for motion in models}
    room = np.diag(np.square(_ROOM / next(iter(models.values())).prior.log_sds))
    mean, spread = (reference.centre, np.zeros((p, p))) if predicted is None else predicted
    onsets = {motion: onset_of(each) for motion, each in outputs.items()}
    expected = mean, np.linalg.inv(spread + room)
    centre, matrix, slope = climb(
        models, records, mean[None], onsets, *expected, moves=_MOVES, later_steps=1
    )
    return matrix[0], slope[0], centre[0]
