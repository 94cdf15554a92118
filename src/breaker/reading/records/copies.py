"""Whether two records are one: the same samples, or an export of them with other decimals, another
zero, a part cut off, or every second sample.

Noise never repeats itself: two operations differ by the noise of both at least.
"""

import numpy as np

from breaker.reading.records.motion import LocatedMotion
from breaker.reading.records.motion_search import white_noise

_WHOLE = 0.05  # of a sample, by which the steps of two exports may differ
_LAGS = 3  # samples about the lag that first motions tell, that are tried
_COPIED = 0.4  # of the noise of both, up to which what two records differ by is none
_FEWEST = 100  # samples that both have


def is_copy(one: LocatedMotion, other: LocatedMotion) -> bool:
    """Say whether two records of a motion hold the same samples.

    Example:
        >>> import numpy as np
        >>> from types import SimpleNamespace
        >>> rng, time = np.random.default_rng(1), 0.1 * np.arange(600)
        >>> way = 14.0 * np.clip((time - 20.0) / 10.0, 0.0, 1.0)
        >>> first, again = (way + 0.05 * rng.standard_normal(600) for _ in range(2))
        >>> def record(samples, every=1):
        ...     return SimpleNamespace(
        ...         left=samples[::every], step=0.1 * every, moves=20.0, time=time[::every],
        ...         inside=slice(None)
        ...     )
        >>> [is_copy(record(first), record(each, 2)) for each in (0.5 + first.round(2), again)]
        [True, False]
    """
    fine, coarse = sorted((one, other), key=lambda each: each.step)
    every = coarse.step / fine.step
    if abs(every - round(every)) > _WHOLE:
        return False
    every = round(every)
    noise = np.hypot(*(white_noise(each.left) for each in (fine, coarse)))
    starts = [
        round((each.moves - float(each.time[each.inside][0])) / each.step)
        for each in (fine, coarse)
    ]
    near = starts[0] - every * starts[1]
    for lag in range(near - _LAGS * every, near + _LAGS * every + 1):
        first = max(0, -(lag // every))  # of the coarse one, that the fine one has
        count = min(coarse.left.size - first, -(-(fine.left.size - lag) // every) - first)
        if count < _FEWEST:
            continue
        part = fine.left[lag + every * first :: every][:count]
        off = part - coarse.left[first : first + count]
        off = off[~np.isnan(off)]
        if off.size >= _FEWEST and off.std() <= _COPIED * noise:
            return True
    return False
