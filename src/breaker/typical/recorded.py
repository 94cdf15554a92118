"""Records of the breakers of a type, from folders: which of them count, and which do not."""

import os
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from breaker.files import MANIFEST, Operation, list_operations, printable, read_manifest
from breaker.model import reference_model
from breaker.posterior import DriveRecords, read_drive

__all__ = ["Recorded", "read_breakers"]

_MOST = 20  # records of a breaker and a motion: more of them say no more of what breakers share


@dataclass(frozen=True, eq=False)
class Recorded:
    """Records of the breakers of a type.

    Attributes:
        drive: All records on the grid of the type's size, the models of it, and the noise.
        labels: Breaker of each record, by motion.
        left_out: Records that were not read since there are enough, by breaker and motion.
        scale: Scale of what the model leaves out.
    """

    drive: DriveRecords
    labels: Mapping[str, np.ndarray]
    left_out: Mapping[tuple[str, str], int]
    scale: float

    @property
    def records(self) -> dict[str, dict[str, np.ndarray]]:
        """Accepted records ``(n, t)``, mm, by breaker and motion; breakers without any are not."""
        found: dict[str, dict[str, np.ndarray]] = defaultdict(dict)
        for motion, labels in self.labels.items():
            curves = self.drive.curves[motion]
            travel, accepted = curves.travel.values.astype(np.float64), curves.accepted.values
            for name in dict.fromkeys(labels[accepted].tolist()):
                found[name][motion] = travel[accepted & (labels == name)]
        return dict(found)

    @property
    def rejected(self) -> list[str]:
        """Why records were rejected, one text for each."""
        return [
            str(reason)
            for curves in self.drive.curves.values()
            for reason in curves.reason.values[~curves.accepted.values]
        ]


def read_breakers(
    folders: Sequence[str | Path], motions: Sequence[str], endurance: Mapping
) -> Recorded:
    """Read some records of the breakers in folders, at the size that they show.

    A breaker is one of the column ``breaker`` of a folder's table, or else a folder; its phases
    count as records of it.

    Args:
        folders: Each as ``endurance.curves``: with a table, or with a folder for each motion.
        motions: Which to look for; one that no folder has is left out.
        endurance: The section of the configuration: ``format``, and ``discrepancy``, the scale of
            what the model leaves out. All breakers of a table count, whichever is chosen there.

    Raises:
        ValueError: If a table is wrong, or no record can be used. The message says what to do.
        FileNotFoundError: If no folder has an operation of any motion.
    """
    operations, labels, left_out = defaultdict(list), defaultdict(list), {}
    troubles = []
    for motion in motions:
        for name, found in _listed(folders, motion, troubles).items():
            some = [found[i] for i in _spread(len(found))]
            operations[motion] += some
            labels[motion] += [name] * len(some)
            if len(found) > len(some):
                left_out[name, motion] = len(found) - len(some)
    if not operations:
        raise FileNotFoundError(_none(folders, troubles))
    scale = endurance["discrepancy"]
    models = {motion: reference_model(motion, scale) for motion in operations}
    drive = read_drive(operations, endurance["format"], models)
    by_motion = {motion: np.array(each) for motion, each in labels.items()}
    recorded = Recorded(drive, by_motion, left_out, scale)
    if not recorded.records:
        raise ValueError(
            f"none of {len(recorded.rejected)} records can be used; check endurance.format and the "
            "folder. The first reasons: " + " | ".join(recorded.rejected[:3])
        )
    return recorded


def _none(folders: Sequence[str | Path], troubles: Sequence[str]) -> str:
    """Why no folder has a record, and what to do."""
    absent = [printable(each) for each in folders if not os.path.isdir(each)]
    if absent:
        return f"there is no folder {', '.join(absent)}"
    return (
        f"{troubles[0]}. `breaker manifest {printable(folders[0])}` proposes a table of the "
        "operations, breakers and phases in a folder"
    )


def _listed(
    folders: Sequence[str | Path], motion: str, troubles: list[str]
) -> dict[str, list[Operation]]:
    """Operations of a motion by breaker; why a folder has none goes to the troubles."""
    found: dict[str, list[Operation]] = defaultdict(list)
    for folder in folders:
        for breaker, phase in _groups(folder):
            try:
                listed = list_operations(folder, motion, breaker=breaker, phase=phase)
            except FileNotFoundError as error:  # a breaker may have one motion alone
                troubles.append(str(error))
                continue
            found[breaker or printable(os.path.normpath(folder))] += listed
    return found


def _groups(folder: str | Path) -> list[tuple[str | None, str | None]]:
    """Breakers and phases in the table of a folder; of one without a table, that of no name."""
    if not os.path.lexists(Path(folder, MANIFEST)):
        return [(None, None)]
    rows = read_manifest(Path(folder, MANIFEST))
    return sorted({(each.breaker, each.phase) for _, each in rows})


def _spread(count: int) -> np.ndarray:
    """Numbers of the records that count, spread over all."""
    return np.unique(np.linspace(0, count - 1, min(count, _MOST)).round().astype(int))
