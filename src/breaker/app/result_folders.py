"""Where a run of the workflow has left a life or a fleet."""

from pathlib import Path
from typing import NamedTuple

LIFE = ("verdict.json", "limits.csv", "changes.csv", "life.zarr", "standing.zarr")
"""What a life is shown from, in a folder of results."""

FLEET = ("fleet.csv", "fleet/types.csv")
"""What a fleet is shown from."""


class RunResults(NamedTuple):
    """Folders of results.

    Attributes:
        life, fleet: Where those of a life, and of a fleet, are; None where there are none.
        alone: Whether the folder that was named is one of results.
    """

    life: Path | None
    fleet: Path | None
    alone: bool


def results_in(named: str | Path) -> RunResults:
    """Return the results in a folder, or in its folder ``results``."""
    places = [Path(named), Path(named, "results")]

    def first(file: str) -> Path | None:
        return next((each for each in places if (each / file).is_file()), None)

    found = first(LIFE[0]), first(FLEET[0])
    return RunResults(*found, places[0] in found)
