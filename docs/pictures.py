"""Draw the pictures of the pages.

    python docs/pictures.py results    # take the data from the last run of the defaults, then draw
    python docs/pictures.py            # draw the data in pictures.json

The data are in ``pictures.json``: the simulated endurance test, a comparison of two inspections,
and a record of each motion. ``pictures.sha256`` has a checksum per picture, of the data and of the
module that draws it. A test compares these checksums, so that no picture is out of date.
``docs/page.py`` takes the pictures of the page and of a report in a browser.
"""

import hashlib
import json
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
from breaker.configuration.data_files import simulated_test
from breaker.configuration.loading import defaults
from breaker.diagnosis.inspection_change import InspectionChange
from breaker.family.endurance import EnduranceTest, write_curve
from breaker.figures.life import changes
from breaker.figures.reports import comparison
from breaker.figures.style import save
from breaker.figures.verdict import verdict
from breaker.model.parameters import MOTIONS, NAMES

DOCS = Path(__file__).resolve().parent
sys.path.insert(0, str(DOCS))
from motion_marks import marked_motions, of_drive  # noqa: E402

DATA = DOCS / "pictures.json"
CHECKSUMS = DOCS / "pictures.sha256"
FIGURES = "src/breaker/figures"
MODULES = {
    "verdict.png": f"{FIGURES}/verdict.py",
    "pictures/motions.png": "docs/motion_marks.py",
    "pictures/comparison.png": f"{FIGURES}/reports.py",
    "pictures/evolution.png": f"{FIGURES}/life.py",
}
"""Module that draws a picture, by the picture's file."""

_LIFE = ["value", "new"]
_STANDING = ["state", "p_exceeded", "service_by", "recommended_since", "remaining", "certain"]
_STANDING += ["crossed", "drive_state"]
_CHANGE_POINTS = ["start", "earliest", "latest", "kind", "noticed", "certainty"]
_TIMES, _RELEASE = 0.1 * np.arange(900), 15.0  # ms
_NOISE, _SCATTER = 0.01, 0.002  # mm; of parameters from one operation to the next
_CHANGES = {"f": 0.92, "gamma_a": 1.15}
_RECORDS = 3
_SHOWN = 60  # operations of a life in the picture of its evolution


def of_run(results: Path) -> dict:
    """Return the end of a life, for the figure of the verdict, and its evolution."""
    life = open_store(results / "life.zarr")
    standing = open_store(results / "standing.zarr").isel(operation=[-1])
    words = json.loads((results / "verdict.json").read_text(encoding="utf-8"))
    end = life.isel(asked=[-1], operation=[-1])
    taken = {"life": _plain(end, _LIFE), "standing": _plain(standing, _STANDING)}
    taken |= {"sentences": words["sentences"]}
    return {"verdict": taken, "evolution": _evolution(life, results)}


def _evolution(life: xr.Dataset, results: Path) -> dict:
    """Return changes since new at some operations, with the true ones."""
    some = np.unique(np.linspace(0, life.sizes["asked"] - 1, _SHOWN).round().astype(int))
    shown = life.isel(asked=some, operation=[0, -1])[["changed", "unchanged", *_CHANGE_POINTS]]
    shown = shown.drop_vars(set(shown.coords) - {"asked", "parameter", "quantile"}).load()
    truth = open_store(results / "rig" / "truth.zarr")
    new = truth.value.sel(operation=slice(None, life.asked.values[0])).mean("operation")
    true = (100.0 * (truth.value / new - 1.0)).sel(operation=shown.asked.values).drop_attrs()
    shown["changed"], shown["unchanged"] = shown.changed.round(3), shown.unchanged.round(4)
    shown.attrs = {name: life.attrs[name] for name in ("agreement", "family")}
    return {"life": shown.to_dict(), "truth": true.round(3).load().to_dict()}


def _plain(data: xr.Dataset, names: list[str]) -> dict:
    """Return variables of a dataset with all its coordinates, as values for JSON."""
    return data.drop_vars(set(data.data_vars) - {*names}).load().drop_attrs().to_dict()


def of_inspections() -> dict:
    """Return the JSON of ``breaker compare`` for two inspections of a simulated drive."""
    settings = defaults()
    new = EnduranceTest.from_settings(simulated_test(settings), settings["seed"]).new
    worn = new.changed(**{name: new.value(name) * by for name, by in _CHANGES.items()})
    rng = generator(settings["seed"], "pictures", "visits")
    with TemporaryDirectory() as name:
        folder = Path(name)
        for inspection, drive in (("before", new), ("today", worn)):
            for motion in MOTIONS:
                (folder / inspection / motion).mkdir(parents=True)
                for operation in range(1, _RECORDS + 1):
                    factors = np.exp(_SCATTER * rng.standard_normal(len(NAMES)))
                    moved = drive.changed(**dict(zip(NAMES, drive.theta * factors, strict=True)))
                    travel = moved.travel(motion, _TIMES - _RELEASE)
                    travel = travel + _NOISE * rng.standard_normal(travel.shape)
                    file = folder / inspection / motion / f"op_{operation}.csv"
                    write_curve(file, _TIMES, travel, motion=motion, operation=operation)
                    table = folder / inspection / "operations.csv"
                    if not table.exists():
                        table.write_text("file,operation,motion,phase\n", encoding="utf-8")
                    with table.open("a", encoding="utf-8") as rows:
                        rows.write(f"{motion}/{file.name},{operation},{motion},L1\n")
        command = [sys.executable, "-m", "breaker", "compare", "before", "--today", "today"]
        done = subprocess.run(
            [*command, "--json"], cwd=folder, check=True, stdout=subprocess.PIPE, text=True
        )
    return json.loads(done.stdout)


def drawn(data: dict) -> dict[str, Figure]:
    """Return the figures by name of their file."""
    life, standing = (xr.Dataset.from_dict(data["verdict"][name]) for name in ("life", "standing"))
    evolution = data["evolution"]
    truth = xr.DataArray.from_dict(evolution["truth"])
    return {
        "verdict.png": verdict(life, standing, data["verdict"]["sentences"]),
        "pictures/motions.png": marked_motions(data["motions"]),
        "pictures/comparison.png": comparison(
            TypeAdapter(InspectionChange).validate_python(data["comparison"])
        ),
        "pictures/evolution.png": changes(xr.Dataset.from_dict(evolution["life"]), truth),
    }


def checksums() -> str:
    """Return a line for each picture: the checksum of the data and of its module, and its name."""
    data, lines = DATA.read_bytes(), []
    for name, module in MODULES.items():
        code = (DOCS.parent / module).read_bytes()
        lines.append(f"{hashlib.sha256(data + code).hexdigest()}  {name}\n")
    return "".join(lines)


def main() -> int:
    """Take the data, if a run is named, and draw."""
    if sys.argv[1:]:
        data = of_run(Path(sys.argv[1])) | {"comparison": of_inspections(), "motions": of_drive()}
        DATA.write_text(json.dumps(data) + "\n", encoding="utf-8")
    for name, figure in drawn(json.loads(DATA.read_text(encoding="utf-8"))).items():
        save(figure, DOCS / name)
        print(f"{name}: {(DOCS / name).stat().st_size / 1000:.0f} kB")
    CHECKSUMS.write_text(checksums(), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
