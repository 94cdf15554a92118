"""Types in the table of a fleet."""

import numpy as np
import xarray as xr

from breaker.common.plain_values import to_json
from breaker.model.parameters import NAMES
from breaker.model.prior import Prior
from breaker.prognosis.drive_document import DriveDocument
from breaker.prognosis.ranking import learn_types


def drive_of(name):
    about = dict.fromkeys(("breaker", "phase", "first", "last", "family", "file"), "")
    about |= dict.fromkeys(("trust", "rejected", "measured", "spread"), ())
    numbers = {"records": 1, "visits": 1, "operation": 1, "p_value": None, "zones": {}}
    return DriveDocument(type=name, **about, **numbers)


def test_types_in_two_spellings_are_one():
    names = ["GL314", "GL 314", "GL314", "gl-314", "GL318"]
    p, rng = len(NAMES), np.random.default_rng(1)
    theta = np.exp(0.1 * rng.standard_normal((len(names), 50, p)))
    drives = xr.Dataset(
        {
            "document": ("drive", [to_json(drive_of(name)) for name in names]),
            "theta": (("drive", "draw", "parameter"), theta),
            "mean": (("drive", "parameter"), np.log(theta).mean(axis=1)),
            "squares": (("drive", "parameter", "other"), np.tile(0.5 * np.eye(p), (5, 1, 1))),
            "count": ("drive", np.full(len(names), 50.0)),
        }
    )
    found = learn_types(drives, Prior(np.ones(p), np.full(p, 0.3)))
    assert {name: where.tolist() for name, (where, _) in found.items()} == {
        "GL314": [0, 1, 2, 3],
        "GL318": [4],
    }
