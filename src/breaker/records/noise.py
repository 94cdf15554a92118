"""Noise of a record, seen where nothing moves: its size, and its colour at the model's step.

The likelihood takes noise of ``noise_sd`` that is independent from sample to sample. A record in
which there is more, or in which neighbouring samples of the grid err alike, knows less about the
drive than is inferred from it.
"""

from typing import NamedTuple

import numpy as np
from scipy.special import chdtri

__all__ = ["Noise", "noise_at_rest", "noise_remark"]

_FEWEST = 10  # samples at rest, for an estimate
_FALSE = 4e-4  # probability of each remark on white noise of the right size
_NORMAL = 3.35  # sd that normal noise exceeds with that probability
_MORE = 1.15  # factor on noise_sd from which more noise matters
_ALIKE = 0.2  # correlation from which it matters
_SMALL = 0.5  # of noise_sd, below which the colour does not matter


class Noise(NamedTuple):
    """Noise of a record.

    Attributes:
        sd: Standard deviation of a sample, mm; nan if there is too little rest.
        colour: Correlation of samples that are a step of the model's grid apart; nan if unknown.
        size: Number of independent samples with as much information on ``sd``.
    """

    sd: float
    colour: float
    size: float


def noise_at_rest(rest: np.ndarray, every: int, quantum: float) -> Noise:
    """Estimate the noise of a record.

    Args:
        rest: Travel before the motion, ``(r,)``, mm; NaN where a sample is missing.
        every: Samples for a step of the model's grid, at least 1.
        quantum: Step to which readings are rounded, mm; its error, ``quantum / sqrt(12)``, is
            there also where rest is too steady to show it.

    Example:
        >>> rest = 0.1 * np.random.default_rng(1).standard_normal(400)
        >>> [round(each, 2) for each in noise_at_rest(rest, 4, 0.0)[:2]]
        [0.09, 0.05]
    """
    there = ~np.isnan(rest)
    if there.sum() < max(_FEWEST, every + 2):
        return Noise(np.nan, np.nan, 0.0)
    sd, rounding = float(np.nanstd(rest, ddof=1)), quantum / np.sqrt(12.0)
    if sd <= rounding:
        return Noise(float(rounding), np.nan, float(there.sum()))
    centred = np.where(there, rest - np.nanmean(rest), 0.0)

    def alike(lag: int) -> float:
        pairs = (there[lag:] & there[:-lag]).sum()
        variance = (centred @ centred) / there.sum()
        return float(centred[lag:] @ centred[:-lag] / max(pairs, 1) / variance)

    # Of a first-order process; less information where neighbouring samples of the file are alike.
    square = min(alike(1), 0.99) ** 2
    size = there.sum() * (1.0 - square) / (1.0 + square)
    return Noise(sd, alike(every), float(size))


def noise_remark(noise: Noise, noise_sd: float) -> str:
    """Say where a record's noise is not what the model takes for granted, "" where it may be.

    A remark on white noise of the right size has a probability below 1e-3.

    Args:
        noise: Of the record.
        noise_sd: The model's, mm.

    Example:
        >>> noise_remark(Noise(0.21, 0.0, 80.0), 0.1)[:58]
        'the noise at rest is 0.21 mm, more than sensor.noise_sd, 0'
        >>> noise_remark(Noise(0.11, 0.0, 80.0), 0.1)
        ''
    """
    if np.isnan(noise.sd):
        return "too little rest before the motion to see the noise"
    free = max(noise.size - 1.0, 1.0)
    factor = max(_MORE, float(np.sqrt(chdtri(free, _FALSE) / free)))
    if noise.sd > factor * noise_sd:
        return (
            f"the noise at rest is {noise.sd:.2g} mm, more than sensor.noise_sd, {noise_sd:g} mm; "
            "raise it, or the parameters are less certain than inferred"
        )
    clear = max(_ALIKE, _NORMAL / np.sqrt(max(noise.size, 1.0)))
    if noise.colour > clear and noise.sd > _SMALL * noise_sd:
        white = noise.sd * np.sqrt((1.0 + noise.colour) / (1.0 - min(noise.colour, 0.99)))
        return (
            f"the noise is correlated from sample to sample of the grid, {noise.colour:.2f}; it "
            f"informs as little as independent noise of {white:.2g} mm would: see sensor.noise_sd"
        )
    return ""
