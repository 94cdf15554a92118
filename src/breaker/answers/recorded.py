"""Records of the breakers of a type, from folders: which of them count, and which do not."""

import os
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from breaker.family import Levels, NormalisedRecords, normalise_record
from breaker.files import MANIFEST, Operation, list_operations, printable, read_manifest
from breaker.mechanism import Size
from breaker.records import Raw, read_raws

__all__ = ["Recorded", "read_breakers"]

_MOST = 20  # records of a breaker and a motion: more of them say no more of what breakers share


@dataclass(frozen=True, eq=False)
class Recorded:
    """Records of the breakers of a type, as networks of a family see them.

    Attributes:
        levels: Network of the family.
        operations: By breaker, the records of each operation by motion; of usable ones.
        noise_sd: Median noise of a sample at rest, mm; nan if none is seen.
        rejected: Why records were rejected, one text for each.
        left_out: How many records were not read since there are enough.
    """

    levels: Levels
    operations: Mapping[str, Sequence[Mapping[str, NormalisedRecords]]]
    noise_sd: float
    rejected: Sequence[str]
    left_out: int

    @property
    def records(self) -> dict[str, dict[str, list[NormalisedRecords]]]:
        """Records by breaker and motion."""
        found: dict[str, dict[str, list[NormalisedRecords]]] = {}
        for name, operations in self.operations.items():
            for motion, seen in (pair for each in operations for pair in each.items()):
                found.setdefault(name, {}).setdefault(motion, []).append(seen)
        return found

    @property
    def motions(self) -> list[str]:
        """Motions that any breaker has."""
        return list(dict.fromkeys(motion for each in self.records.values() for motion in each))

    @property
    def size(self) -> Size:
        """Size of drives of the family with the stroke and the duration of these."""
        first = [next(iter(each.values())) for some in self.operations.values() for each in some]
        seen = np.median([(each.stroke[0], each.duration[0]) for each in first], axis=0)
        return Size(*(float(f"{each:.3g}") for each in seen / np.exp(self.levels.usual[:, 0])))


def read_breakers(
    folders: Sequence[str | Path], motions: Sequence[str], settings: Mapping, levels: Levels
) -> Recorded:
    """Read some records of the breakers in folders.

    A breaker is one of the column ``breaker`` of a folder's table, or else a folder; its phases
    count as records of it.

    Args:
        folders: Each as ``endurance.curves``: with a table, or with a folder for each motion.
        motions: Which to look for; one that no folder has is left out.
        settings: The section ``endurance.format`` of the configuration.
        levels: Network of the family of these drives.

    Raises:
        ValueError: If a table is wrong, or no record can be used. The message says what to do.
        FileNotFoundError: If no folder has an operation of any motion.
    """
    found: dict[str, dict[tuple, dict[str, NormalisedRecords]]] = defaultdict(
        lambda: defaultdict(dict)
    )
    noise, rejected, left_out = [], [], 0
    troubles: list[str] = []
    for motion in motions:
        for name, listed in _listed(folders, motion, troubles).items():
            some = [listed[i] for i in _spread(len(listed))]
            left_out += len(listed) - len(some)
            for each, raw in zip(some, read_raws(some, settings, motion), strict=True):
                if not isinstance(raw, Raw):
                    rejected.append(str(raw))
                    continue
                of = each.number, each.phase, os.path.dirname(each.file)
                found[name][of][motion] = normalise_record(raw)[1]
                noise.append(max(raw.noise_at(raw.step).sd, raw.quantum / np.sqrt(12.0)))
    if not found and not rejected:
        raise FileNotFoundError(_none(folders, troubles))
    if not found:
        raise ValueError(
            f"none of {len(rejected)} records can be used; check endurance.format and the "
            "folder. The first reasons: " + " | ".join(rejected[:3])
        )
    seen_noise = float(np.nanmedian(noise)) if np.isfinite(noise).any() else np.nan
    operations = {name: list(each.values()) for name, each in found.items()}
    return Recorded(levels, operations, seen_noise, rejected, left_out)


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
