"""Draw the pictures of the pages, with those that ``tutorial/renew.py`` draws for the tutorial.

    python docs/pictures.py results    # take the data from the last run of the defaults, then draw
    python docs/pictures.py            # draw what was taken

The data are in ``pictures.json``: the end of the simulated endurance test, and a comparison of two
inspections of a simulated drive. ``pictures.sha256`` has a checksum of the data of each picture and
of the module that draws it. A test compares these checksums, so that no picture is out of date.
"""

import hashlib
import json
import re
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from pydantic import TypeAdapter

from breaker.common.randomness import generator
from breaker.common.zarr_store import open_store
from breaker.configuration.definitions import simulated_test
from breaker.configuration.loading import defaults
from breaker.diagnosis.inspection_change import InspectionChange
from breaker.family.curve_file import write_curve
from breaker.family.endurance import EnduranceTest
from breaker.figures.reports import visits
from breaker.figures.style import save
from breaker.figures.verdict import verdict
from breaker.model.parameters import MOTIONS, NAMES

DOCS = Path(__file__).resolve().parent
DATA = DOCS / "pictures.json"
CHECKSUMS = DOCS / "pictures.sha256"
TUTORIAL = DOCS / "tutorial"
MODULES = {
    "verdict.png": "verdict.py",
    "visits.png": "reports.py",
    "tutorial/record.png": "records.py",
    "tutorial/answer.png": "records.py",
    "tutorial/prior.png": "reports.py",
}
"""The module of ``breaker.figures`` that draws a picture."""

_LIFE = ["value", "new"]
_STANDING = ["state", "p_exceeded", "service_by", "recommended_since", "remaining", "certain"]
_STANDING += ["crossed", "drive_state"]
_TIMES, _RELEASE = 0.1 * np.arange(900), 15.0  # ms
_NOISE, _SCATTER = 0.01, 0.002  # mm; of parameters from one operation to the next
_CHANGES = {"f": 0.92, "gamma_a": 1.15}
_RECORDS = 3


def of_run(results: Path) -> dict:
    """Return the end of a life, as the figure of the verdict takes it."""
    life = open_store(results / "life.zarr").isel(asked=[-1], operation=[-1])
    standing = open_store(results / "standing.zarr").isel(operation=[-1])
    words = json.loads((results / "verdict.json").read_text(encoding="utf-8"))
    taken = {"life": _plain(life, _LIFE), "standing": _plain(standing, _STANDING)}
    return taken | {"sentences": words["sentences"]}


def _plain(data: xr.Dataset, names: list[str]) -> dict:
    """Variables of a dataset with all its coordinates, as JSON has them."""
    return data.drop_vars(set(data.data_vars) - {*names}).load().drop_attrs().to_dict()


def of_visits() -> dict:
    """Return what ``breaker compare`` finds of two visits to a drive whose truth is known."""
    settings = defaults()
    new = EnduranceTest.from_settings(simulated_test(settings), settings["seed"]).new
    worn = new.changed(**{name: new.value(name) * by for name, by in _CHANGES.items()})
    rng = generator(settings["seed"], "pictures", "visits")
    with TemporaryDirectory() as name:
        folder = Path(name)
        for visit, drive in (("before", new), ("today", worn)):
            for motion in MOTIONS:
                (folder / visit / motion).mkdir(parents=True)
                for operation in range(1, _RECORDS + 1):
                    factors = np.exp(_SCATTER * rng.standard_normal(len(NAMES)))
                    moved = drive.changed(**dict(zip(NAMES, drive.theta * factors, strict=True)))
                    travel = moved.travel(motion, _TIMES - _RELEASE)
                    travel = travel + _NOISE * rng.standard_normal(travel.shape)
                    file = folder / visit / motion / f"op_{operation}.csv"
                    write_curve(file, _TIMES, travel, motion=motion, operation=operation)
        command = [sys.executable, "-m", "breaker", "compare", "before", "--today", "today"]
        done = subprocess.run(
            [*command, "--json"], cwd=folder, check=True, stdout=subprocess.PIPE, text=True
        )
    return json.loads(done.stdout)


def drawn(data: dict) -> dict[str, Figure]:
    """Return the figures by name of their file."""
    life, standing = (xr.Dataset.from_dict(data["verdict"][name]) for name in ("life", "standing"))
    return {
        "verdict.png": verdict(life, standing, data["verdict"]["sentences"]),
        "visits.png": visits(TypeAdapter(InspectionChange).validate_python(data["visits"])),
    }


def checksums() -> str:
    """Return a line for each picture: the checksum of its data and its module, and its name.

    For a picture of the tutorial, the command that draws it stands for its data.
    """
    page = (TUTORIAL / "README.md").read_text(encoding="utf-8")
    lines = []
    for name, module in MODULES.items():
        data = DATA.read_bytes()
        if "/" in name:
            (command,) = re.findall(rf"^breaker .* --plot {Path(name).name}$", page, re.M)
            data = command.encode()
        code = (DOCS.parent / "src" / "breaker" / "figures" / module).read_bytes()
        lines.append(f"{hashlib.sha256(data + code).hexdigest()}  {name}\n")
    return "".join(lines)


def main() -> int:
    """Take the data, if a run is named, and draw."""
    if sys.argv[1:]:
        data = {"verdict": of_run(Path(sys.argv[1])), "visits": of_visits()}
        DATA.write_text(json.dumps(data, indent=1) + "\n", encoding="utf-8")
    for name, figure in drawn(json.loads(DATA.read_text(encoding="utf-8"))).items():
        save(figure, DOCS / name)
        print(f"{name}: {(DOCS / name).stat().st_size / 1000:.0f} kB")
    subprocess.run([sys.executable, TUTORIAL / "renew.py"], check=True)
    CHECKSUMS.write_text(checksums(), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
