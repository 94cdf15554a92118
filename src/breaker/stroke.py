"""The main motion of a stroke, and its end.

What the model claims to describe is the main motion (paper, Sec. 7): the rest of the stroke, where
stops and dampers act, is beyond it.
"""

import numpy as np

__all__ = ["main_motion"]

_SHARE = {"closing": 0.75, "opening": 0.85}  # of the way between the rest positions


def main_motion(travel: np.ndarray, times: np.ndarray, motion: str) -> np.ndarray:
    """Say which samples of a curve belong to the main motion, ``(t,)`` of bool.

    From time 0 to where the drive has done its share of the way between its rest positions: about
    up to the touch when closing, up to the stop when opening.

    Args:
        travel: A curve with little noise, ``(t,)``, mm.
        times: Times, ``(t,)``, ms, 0 at the first motion.
        motion: "closing" or "opening".
    """
    before = travel[times < 0]
    start = float(before.mean()) if before.size else float(travel[0])
    end = float(travel[-max(1, len(travel) // 12) :].mean())
    done = (travel - start) / (end - start) >= _SHARE[motion]
    last = int(done.argmax()) if done.any() else len(travel)
    return (times >= 0) & (np.arange(len(travel)) < last)
