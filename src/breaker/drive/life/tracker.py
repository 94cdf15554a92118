r"""Lines of a life: where any number of coordinates are, whither they go, and where that changed.

A drive that wears moves along a path. Of each coordinate it is ``a + b u + c u^2``, and from each
change on ``d (u - u0)`` more, where wear changed its rate, or ``d``, where the drive itself did.
The records scatter around it, heavily: each counts by Student's t about what the records before it
lead to expect. Coordinates are in units of the scatter and independent (``coordinates``), so all is
linear and Gaussian, coordinate by coordinate, and what a change would explain has a closed form:
the Schur complement of its column.

Even wear that is straight in the drive's parameters bends the path a little. So the curvature has a
prior: a share of the change so far, along it, and a smaller share aside. Without it, false changes
are found; with a free one, true ones are not.

A change is looked for at every operation: one that made the wear faster or slower along its own
direction, one that gave it a new direction, and a step. What each explains is weighed over all
times at which it may have begun; the prior of its size is what drives of the family do. From the
threshold on it is noticed, becomes part of the path, and is placed anew until enough records have
followed it. Scale-free: neither the length of a life nor the distance of records is a setting.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Self

import numpy as np

from breaker.drive.life.life import Life
from breaker.drive.life.path import Block, Path
from breaker.drive.life.path_fit import PathFit


@dataclass(frozen=True)
class Tracker:
    """How lives are followed.

    Attributes:
        reference: Records that are "new".
        settle: Records after these, and after a change, in which none is noticed.
        threshold: Evidence from which a change is noticed, nats.
        bend: Prior sd of the curvature over the life so far: along the change, share of it,
        aside: and across it.
        faster: Prior sd of the change of a rate, in rates.
        size: Prior sd of another change, in changes of the family.
        tails: Degrees of freedom of the scatter.
        warmth, voltage: Prior sds of the effect of 10 K, and of 10 % of the control voltage, in
            changes of the family.

    Example:
        >>> rng, over = np.random.default_rng(1), np.arange(400) > 300
        >>> values = rng.standard_normal((400, 3)) + np.outer(over, [4.0, 0.0, 0.0])
        >>> path = Tracker().follow(np.arange(400), [Block(values, np.full(3, 1e4))])
        >>> path.changes[0].kind, path.changes[0].start, path.changes[0].noticed
        ('step', 301, 303)
    """

    reference: int = 50
    settle: int = 50
    threshold: float = 10.0
    bend: float = 0.2
    aside: float = 0.2
    faster: float = 3.0
    size: float = 0.03
    tails: float = 100.0
    warmth: float = 0.1
    voltage: float = 0.1

    @classmethod
    def from_settings(cls, settings: Mapping) -> Self:
        """Build from the section ``wear_model`` of the configuration."""
        return cls(**{each.name: settings[each.name] for each in fields(cls)})

    def follow(
        self,
        operations: np.ndarray,
        blocks: Sequence[Block],
        *,
        new: np.ndarray | None = None,
        events: Mapping[int, bool] | None = None,
        conditions: Mapping[str, np.ndarray] | None = None,
    ) -> Path:
        """Go through a life.

        Args:
            operations: Their numbers, rising, ``(o,)``.
            blocks: Coordinates.
            new: Indices of the operations that are new; the first that have a record if None.
            events: Indices of operations before which work was done, and whether on the transducer
                alone.
            conditions: "temperature" and "voltage" beside those of the reference, in 10 K and in
                10 % of the voltage, ``(o,)``, as far as they are known.
        """
        found = [
            (values, {"temperature": self.warmth, "voltage": self.voltage}[name])
            for name, values in (conditions or {}).items()
        ]
        return Life(self, operations, PathFit(blocks), new, found).followed(events or {})
