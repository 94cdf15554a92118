"""Fit the sensitivities of shipped families, after each change of a family.

Run `python envs/sensitivities.py`, with names of families or for all. It simulates curves without
noise, with each parameter slightly increased and decreased, in 1.5 minutes a family on one core.
"""

import sys
from collections.abc import Mapping, Sequence

import numpy as np

from breaker.common.randomness import generator
from breaker.common.tensor_file import settings_of, write_model
from breaker.configuration.data_files import family_of
from breaker.family.drive_family import Family
from breaker.family.inputs import Basis
from breaker.family.rich_drive import Drive
from breaker.family.sensitivities import SETS, Sensitivities, features
from breaker.family.shape import SHAPE_TIMES, shape_of
from breaker.model.parameters import MOTIONS, NAMES
from breaker.model.prior import Prior
from breaker.shipped import FAMILIES, model_file

DRIVES = 3000
SHAPES, CHANGES = 20, 40  # components of shapes and of changes
RIDGE = 3.0  # weight of the prior of a coefficient, in drives
USUAL = 0.98  # share of drives whose errors count; omits drives with one bounce more or less
BY = 0.03  # step of a logarithm: as large as relevant changes, as bounces have no derivative
TIMES = np.arange(-12.0, 110.0, 0.05)  # ms, for a drive of size 1


def curves_of(drive: Drive) -> tuple[np.ndarray, np.ndarray, np.ndarray] | None:
    """Return shapes ``(m, g)``, durations ``(m,)`` and derivatives ``(p, m, g + 1)`` of a drive;
    None if a changed drive has no closed position or its contact does not touch.
    """
    steps = [(name, by) for name in NAMES for by in (BY, -BY)]
    drives = [drive, *(drive.changed(**{n: drive.value(n) * np.exp(by)}) for n, by in steps)]
    if not all(item.holds for item in drives):
        return None
    shapes, durations, changes = [], [], []
    for motion in MOTIONS:
        sign, like, rows = (1.0 if motion == "closing" else -1.0), None, []
        for item in drives:
            travel, switching = item.operate(motion, TIMES)
            if not np.isfinite(switching):
                return None
            shape = shape_of(sign * travel, TIMES[1] - TIMES[0], like)
            like = like or shape
            at = (switching - TIMES[0] - shape.origin) / like.duration
            rows.append(np.append(shape.way, np.interp(at, SHAPE_TIMES, shape.way)))
        shapes.append(rows[0][:-1])
        durations.append(like.duration)
        changes.append((np.array(rows[1::2]) - np.array(rows[2::2])) / (2.0 * BY))
    return np.array(shapes), np.array(durations), np.array(changes).swapaxes(0, 1)


def regression(shapes: np.ndarray, paces: np.ndarray, changes: np.ndarray) -> Sensitivities:
    """Fit the regression of one set of motions to drives.

    Args:
        shapes: Curves over their strokes, ``(n, m * g)``.
        paces: Logarithm of the duration of the last motion over the first, ``(n,)``.
        changes: Derivatives by the logarithm of each parameter, ``(n, p, m * (g + 1))``.
    """
    n, p, _ = changes.shape
    basis = Basis.of(shapes, SHAPES)
    curves = np.linalg.svd(changes.reshape(n * p, -1), full_matrices=False)[2][:CHANGES]
    x, y = features(basis, shapes, paces), (changes @ curves.T).reshape(n, -1)

    def solved(rows: np.ndarray) -> np.ndarray:
        square = x[rows].T @ x[rows] + RIDGE * np.eye(x.shape[1])
        return np.linalg.solve(square, x[rows].T @ y[rows])

    even = np.arange(n) % 2 == 0  # each half is predicted from the other half
    left = np.where(even[:, None], y - x @ solved(~even), y - x @ solved(even))
    errors = []
    for one in left.reshape(n, p, -1).swapaxes(0, 1):
        size = np.square(one).sum(axis=1)
        usual = one[size <= np.quantile(size, USUAL)]
        errors.append(usual.T @ usual / len(usual))
    return Sensitivities(basis, solved(even | ~even), curves, np.array(errors))


def fitted(family: Family, count: int, rng: np.random.Generator) -> dict[tuple, Sensitivities]:
    """Fit regressions to ``count`` drives of a family."""
    result = []
    while len(result) < count:
        try:
            if (curves := curves_of(family.new(rng))) is not None:
                result.append(curves)
        except (ValueError, FloatingPointError):  # no motion
            continue
    shapes, durations, changes = (np.array(item) for item in zip(*result, strict=True))
    regressions = {}
    for motions in SETS:
        columns = [MOTIONS.index(motion) for motion in motions]
        paces = np.log(durations[:, columns[-1]] / durations[:, columns[0]])
        chosen = changes[:, :, columns].reshape(count, len(NAMES), -1)
        regressions[motions] = regression(shapes[:, columns].reshape(count, -1), paces, chosen)
    return regressions


def write(family: str, fits: Mapping[tuple, Sensitivities]) -> None:
    """Write the regressions of a family to the shipped file."""
    arrays = {}
    for motions, fit in fits.items():
        for name, part in (fit.shapes._asdict() | fit._asdict()).items():
            if name != "shapes":
                arrays[f"{' '.join(motions)}.{name}"] = np.float32(part)
    settings = {"kind": "sensitivities", "family": family, "drives": DRIVES}
    write_model(model_file(family, "sensitivities"), settings, arrays)


def main(names: Sequence[str]) -> None:
    """Fit the named families, or all shipped ones."""
    for name in names or FAMILIES:
        prior = settings_of(model_file(name, "levels"))["prior"]  # as in its networks
        family = Family(Prior.from_settings(prior), family_of(name))
        write(name, fitted(family, DRIVES, generator(1, "sensitivities", name)))


if __name__ == "__main__":
    main(sys.argv[1:])
