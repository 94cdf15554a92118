"""How wide intervals of the remaining life must be, from lives whose truth is known.

The widths of predicted trends are multiplied by a factor, the *widening*. The larger it is, the
fewer of a life's predictions miss, and the least widening is taken whose misses, with one more life
that misses everything, are within what is allowed: conformal risk control (Angelopoulos et al.
2024, "Conformal risk control"), for a single prediction of each life split conformal prediction. It
holds for every number of lives and whatever is wrong with the model of wear, if only the life that
is predicted is exchangeable with those: drawn as they are.
"""

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

__all__ = ["MISSED", "WIDENINGS", "calibrate"]

MISSED = 0.1
"""Share of the predictions that a 90 % interval may miss."""

WIDENINGS = np.arange(20, 41) / 20.0
"""Widenings that are tried, from 1 to 2."""


def calibrate(
    covered: ArrayLike, widenings: ArrayLike = WIDENINGS, *, missed: float = MISSED
) -> tuple[pd.DataFrame, float]:
    """Return what each widening leaves outside, and the least one that is enough.

    The expected share of the predictions of another life that miss is at most ``missed``, over
    lives and over the draw of those that calibrate.

    Args:
        covered: Whether the interval of each prediction holds the truth, ``(life, prediction, w)``.
        widenings: Rising, ``(w,)``.
        missed: Share that may be missed.

    Returns:
        Table over widenings: ``covered``, share of all predictions, and ``missed_at_most``, the
        bound on the expected share that another life misses; and the widening, nan if none is
        enough.

    Example:
        >>> covered = np.ones((30, 2, 3), dtype=bool)
        >>> covered[:3, 0, :2] = False  # 3 of 60 miss below the third widening
        >>> table, enough = calibrate(covered, [1.0, 1.1, 1.2], missed=0.05)
        >>> table.missed_at_most.round(3).tolist(), enough
        ([0.081, 0.081, 0.032], 1.2)
    """
    covered = np.asarray(covered, dtype=bool)
    # An interval that a wider one no longer covers counts as a miss: the share falls, never rises.
    holds = np.minimum.accumulate(covered[..., ::-1], axis=-1)[..., ::-1]
    bound = (np.sum(1.0 - holds.mean(axis=1), axis=0) + 1.0) / (len(covered) + 1.0)
    columns = {"widening": np.asarray(widenings, float), "covered": covered.mean(axis=(0, 1))}
    table = pd.DataFrame(columns | {"missed_at_most": bound})
    enough = table.widening[bound <= missed]
    return table, float(enough.iloc[0]) if enough.size else np.nan
