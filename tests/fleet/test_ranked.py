"""Types in the table of a fleet."""

import numpy as np
import xarray as xr

from breaker.common.plain_values import to_json
from breaker.drive.fleet import ranking as ranked
from breaker.drive.fleet.drive_document import DriveDocument, FleetRow
from breaker.drive.fleet.ranking import _show, learn_types
from breaker.mechanism.prior import Prior
from breaker.quantities.parameters import NAMES


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


def test_what_is_usual_of_a_type_is_found_once_for_all_of_its_drives(monkeypatch):
    """Planted fault: medians of all drives for each of them, which takes minutes for 10,000."""
    measured = [
        [["stroke", "closing", 100.0 + i], ["travel_time", "closing", 9.0]] for i in range(9)
    ]
    about = {name: each for name, each in drive_of("").plain().items() if name != "measured"}
    rows = [FleetRow(DriveDocument(**about, measured=each)) for each in measured]
    taken = []
    median = np.median

    def counting(values):
        taken.append(len(values))
        return median(values)

    monkeypatch.setattr(ranked.np, "median", counting)
    _show(rows)
    assert len(taken) == 4
    assert rows[0].shown == ("stroke", "closing", 100.0, 104.0)
    assert rows[8].columns()["off_type"] == 100.0 * (108.0 / 104.0 - 1.0)
    assert {each.columns()["off_type_of"] for each in rows} >= {"stroke closing"}
