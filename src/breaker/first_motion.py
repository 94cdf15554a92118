"""When does the drive start to move?

From rest, under a constant force and friction, travel begins as ``A tau^2 (1 - kappa tau)``,
``tau`` the time since the first motion and ``kappa`` about a third of the friction. Fitting that
to the rest and the first rise, rather than waiting for a threshold, makes the time nearly free of
bias and of the force: a threshold alone is late by milliseconds, and later for a weak drive.
"""

import numpy as np

__all__ = ["NoMotionError", "first_motion"]

_RISE = 1.5  # mm, rise up to which the start is fitted
_EARLIEST = 5.0  # ms, longest time that the rise may take
_STEP = 0.01  # ms, of the times tried
_KAPPA = 0.12  # 1/ms, the median over the default prior: right to 0.01 ms on average there
_TOGETHER = 5  # samples whose mean has to rise, so that noise does not


class NoMotionError(ValueError):
    """A record in which nothing moves."""


def first_motion(time: np.ndarray, travel: np.ndarray, direction: float) -> float:
    """Return the time of the first motion, ms.

    Args:
        time: Times of a record, ``(t,)``, ms, evenly spaced.
        travel: Travel, ``(t,)``, mm.
        direction: 1 if the travel grows, -1 if it falls.

    Raises:
        NoMotionError: If the travel does not leave its rest position by 1.5 mm, or has left it
            when the record begins.
    """
    risen = direction * (travel - np.median(travel[:_TOGETHER]))
    mean = np.convolve(risen, np.full(_TOGETHER, 1 / _TOGETHER), mode="valid")
    above = np.flatnonzero(mean >= _RISE)
    if above.size == 0:
        raise NoMotionError(f"no motion: the travel rises by no more than {mean.max():.2f} mm")
    last = above[0] + _TOGETHER // 2
    step = (time[-1] - time[0]) / (time.size - 1)
    first = max(0, last - round(2 * _EARLIEST / step))
    # At least one sample moves after each of them; of none, the misfit would be 0 / 0.
    candidates = np.arange(max(time[first], time[last] - _EARLIEST), time[last] - 1.5 * step, _STEP)
    best = candidates[_misfit(time[first:last], risen[first:last], candidates).argmin()]
    if best <= time[0]:
        raise NoMotionError("no rest before the motion: the record begins too late")
    return float(best)


def _misfit(time: np.ndarray, risen: np.ndarray, starts: np.ndarray) -> np.ndarray:
    """Sum of squares that the best rise from each start leaves, the rest position fitted along."""
    tau = np.maximum(time - starts[:, None], 0.0)
    shape = tau**2 * (1.0 - _KAPPA * tau)
    shape -= shape.mean(axis=1, keepdims=True)
    risen = risen - risen.mean()
    return risen @ risen - (shape @ risen) ** 2 / np.einsum("st,st->s", shape, shape)
