"""Fit the sensitivities of families that ship: ``python -m`` and the name of this module.

Curves of drives of the family without noise, with each parameter changed a little up and down. A
minute and a half for each family on one core.
"""

import sys
from collections.abc import Sequence

import numpy as np

from breaker.common.randomness import generator
from breaker.common.tensor_file import settings_of
from breaker.configuration.definitions import family_of
from breaker.family.drive_family import Family
from breaker.family.rich_drive import Drive
from breaker.family.sensitivities import SETS, Sensitivities, write_sensitivities
from breaker.family.shape import SHAPE_TIMES, shape_of
from breaker.model.parameters import MOTIONS, NAMES
from breaker.model.prior import Prior
from breaker.shipped import FAMILIES, model_file

DRIVES = 3000
_BY = 0.03  # of a logarithm: changes that matter are this large, and a bounce has no slope
_TIMES = np.arange(-12.0, 110.0, 0.05)  # ms, of a drive of size 1


def curves_of(drive: Drive) -> tuple[np.ndarray, np.ndarray, np.ndarray] | None:
    """Return shapes ``(m, g)``, durations ``(m,)`` and derivatives ``(p, m, g + 1)`` of a drive;
    None where a change leaves it without a closed position or a contact that touches.
    """
    steps = [(name, by) for name in NAMES for by in (_BY, -_BY)]
    drives = [drive, *(drive.changed(**{n: drive.value(n) * np.exp(by)}) for n, by in steps)]
    if not all(each.holds for each in drives):
        return None
    shapes, durations, changes = [], [], []
    for motion in MOTIONS:
        sign, like, rows = (1.0 if motion == "closing" else -1.0), None, []
        for each in drives:
            travel, switching = each.operate(motion, _TIMES)
            if not np.isfinite(switching):
                return None
            shape = shape_of(sign * travel, _TIMES[1] - _TIMES[0], like)
            like = like or shape
            at = (switching - _TIMES[0] - shape.origin) / like.duration
            rows.append(np.append(shape.way, np.interp(at, SHAPE_TIMES, shape.way)))
        shapes.append(rows[0][:-1])
        durations.append(like.duration)
        changes.append((np.array(rows[1::2]) - np.array(rows[2::2])) / (2.0 * _BY))
    return np.array(shapes), np.array(durations), np.array(changes).swapaxes(0, 1)


def fitted(family: Family, count: int, rng: np.random.Generator) -> dict[tuple, Sensitivities]:
    """Fit regressions to so many drives of a family."""
    found = []
    while len(found) < count:
        try:
            if (curves := curves_of(family.new(rng))) is not None:
                found.append(curves)
        except (ValueError, FloatingPointError):  # no motion
            continue
    shapes, durations, changes = (np.array(each) for each in zip(*found, strict=True))
    regressions = {}
    for motions in SETS:
        some = [MOTIONS.index(motion) for motion in motions]
        paces = np.log(durations[:, some[-1]] / durations[:, some[0]])
        chosen = changes[:, :, some].reshape(count, len(NAMES), -1)
        regressions[motions] = Sensitivities.fitted(
            shapes[:, some].reshape(count, -1), paces, chosen
        )
    return regressions


def main(names: Sequence[str]) -> None:
    """Fit the families of these names, or all that ship."""
    for name in names or FAMILIES:
        prior = settings_of(model_file(name, "levels"))["prior"]  # as of its networks
        family = Family(Prior.from_settings(prior), family_of(name))
        found = fitted(family, DRIVES, generator(1, "sensitivities", name))
        write_sensitivities(
            name, {"kind": "sensitivities", "family": name, "drives": DRIVES}, found
        )


if __name__ == "__main__":
    main(sys.argv[1:])
