"""Numbers that act as far as another one does: the law of a force, as far as there is that force.

What a drive is told by its numbers is hard to learn where some say nothing until others are there.
So an emulator sees them as they act: off their middle, times how far their size is there.
"""

from dataclasses import dataclass

import numpy as np

from breaker.drive.simulation.rich_drive import ELEMENTS, STOPS, WAVES
from breaker.quantities.parameters import NAMES

_HALF = 0.2  # sd of a size, at which its laws act half
_LINEAR = 1e3  # as many: a force is its share times its coefficients

_OF_STOPS = ("reach", "power", "depth", "profile")
_LAWS = {
    **{f"{stop}.{law}": f"{stop}.damping" for stop in STOPS for law in _OF_STOPS},
    **dict.fromkeys(("stick", "slip", "load"), "dry_friction"),
    **{"growth": "build_up", "drag_power": "drag"},
}
_COEFFICIENTS = {f"{wave}.harmonics.{k}": f"{wave}.share" for wave in WAVES for k in range(6)}


@dataclass(frozen=True, eq=False)
class Gates:
    """What emulators see of numbers ``(n, q)``.

    Attributes:
        own, size: Which numbers act with which, ``(g,)``.
        middle: Of each of the first.
        half: Of each of the second, at which it acts half.

    Example:
        >>> gates = Gates(np.array([0]), np.array([1]), np.array([2.0]), np.array([0.5]))
        >>> gates.seen(np.array([[3.0, 0.0], [3.0, 0.5]])).tolist()
        [[0.0, 0.0], [0.5, 0.5]]
    """

    own: np.ndarray
    size: np.ndarray
    middle: np.ndarray
    half: np.ndarray

    @classmethod
    def of(cls, drives: np.ndarray) -> "Gates":
        """Those of drives of a family ``(n, p + e)``."""
        names, pairs = (*NAMES, *ELEMENTS), _LAWS | _COEFFICIENTS
        own, size = ([names.index(name) for name in some] for some in (pairs, pairs.values()))
        halves = np.repeat([_HALF, _LINEAR], [len(_LAWS), len(_COEFFICIENTS)])
        sds = drives.std(axis=0)[size]
        half = np.where(sds > 0.0, halves * sds, 1.0)
        return cls(np.array(own), np.array(size), drives.mean(axis=0)[own], half)

    def seen(self, numbers: np.ndarray) -> np.ndarray:
        """What is seen of numbers ``(n, q)``, alike."""
        sizes, found = numbers[:, self.size], numbers.copy()
        there = sizes / (np.abs(sizes) + self.half)
        found[:, self.own] = (numbers[:, self.own] - self.middle) * there
        return found

    def back(self, numbers: np.ndarray, slopes: np.ndarray) -> np.ndarray:
        """Slopes by numbers, of slopes by what is seen of them, ``(n, q)`` each."""
        sizes, by, found = numbers[:, self.size], slopes[:, self.own], slopes.copy()
        whole = np.abs(sizes) + self.half
        found[:, self.own] = by * sizes / whole
        by = by * (numbers[:, self.own] - self.middle) * self.half / np.square(whole)
        onto, to = np.unique(self.size, return_inverse=True)
        found[:, onto] += by @ np.eye(onto.size)[to]
        return found
