"""Folders of results as runs of the workflow leave them, of lives and fleets that are made up."""

import json

import numpy as np
import pandas as pd
import xarray as xr

from breaker.common.zarr_store import describe, save
from breaker.configuration.loading import defaults
from breaker.drive.fleet.drive_document import FLEET
from breaker.drive.life.first_page import headline, limit_words, since_new, trust
from breaker.drive.life.life_tables import change_table, decide, limit_table, operation_metadata
from breaker.drive.life.limit_states import standing
from breaker.model.parameters import PARAMETERS
from breaker.reading.files.safe_text import save_frame


def write_life(folder, life):
    """Write what the workflow's rule `decide` does of a life, and the life."""
    number = life.operation.values
    count = number.size
    stands = standing(life, defaults()["planning"], np.full(count, np.nan))
    used = xr.Dataset({"accepted": ("operation", np.ones(count, bool))}, {"operation": number})
    known = operation_metadata({"closing": used}, number)
    decisions, limits = decide(life, stands, known), limit_table(life, stands)
    changes = change_table(life)
    folder.mkdir(parents=True, exist_ok=True)
    save(describe(life, "life"), folder / "life.zarr")
    save(describe(stands, "standing"), folder / "standing.zarr")
    for name, each in {"decisions": decisions, "limits": limits, "changes": changes}.items():
        save_frame(each, folder / f"{name}.csv", digits=6)
    said = [headline(decisions, limits), since_new(changes, life), trust(life)]
    words = {"sentences": said, "limits": limit_words(limits).to_dict("list")}
    (folder / "verdict.json").write_text(json.dumps(words), encoding="utf-8")


def write_fleet(folder, count, name="Bay {} <b>&"):
    """Write the tables of a fleet, of drives whose names try to be HTML and formulas."""
    states = ["now", "plan", "measured differently", "not judged", "healthy", "unknown"]
    rows = [
        dict.fromkeys(FLEET, "")
        | {"breaker": name.format(k), "phase": "=1+1", "type": "VD4", "last": "2026-03-01"}
        | {"state": states[min(6 * k // count, 5)], "odd": "gamma_a" * (k == 0)}
        | {"pole_spread": 0.5 + k if k % 2 else np.nan, "pole_spread_of": "closing_time"}
        | {"reason": f"stroke of closing is {100 + k} mm"}
        for k in range(count)
    ]
    types = pd.DataFrame(
        {"type": "VD4", "drives": count, "parameter": each.name, "unit": each.unit}
        | {"median": 1.0, "log_sd": 0.1, "spread": 0.05}
        for each in PARAMETERS
    )
    (folder / "fleet").mkdir(parents=True, exist_ok=True)
    save_frame(pd.DataFrame(rows), folder / "fleet.csv", digits=6)
    save_frame(types, folder / "fleet" / "types.csv", digits=6)
