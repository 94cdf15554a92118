"""Exports of a simulated breaker, for a first look: two visits, twelve years apart, and a file that
says hardly anything of itself.
"""

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from breaker.common.randomness import generator
from breaker.configuration.definitions import simulated_test
from breaker.family.endurance_rig import Rig
from breaker.family.rich_drive import Drive
from breaker.model.parameters import GAP, NAMES

_RATE, _LENGTH = 20.0, 220.0  # kHz, ms
_TRIPS, _DELAY = {"closing": 10.0, "opening": 120.0}, 14.0  # ms
_NOISE, _SCATTER = 0.01, 0.004  # mm; of parameters from pole to pole
_VISITS = {"2014-05-12": 0.0, "2026-03-02": 1.0}  # shares of the life
_STATED = "Station: Example\nSerial No: EX-0001\nType: 12 kV\nTest Date: {date}\nOperation: C-O"
_COIL = 3.0, 6.0, 45.0  # A, ms until most of it flows, ms for which it flows


def write_visits(settings: Mapping, folder: Path) -> int:
    """Write the exports of the rig of a configuration into a folder, and return how many they are.

    Example:
        >>> from breaker.configuration.loading import defaults
        >>> import tempfile
        >>> with tempfile.TemporaryDirectory() as name:
        ...     write_visits(defaults(), Path(name))
        3
    """
    rig = Rig.from_settings(simulated_test(settings), settings["seed"])
    for date, share in _VISITS.items():
        rng = generator(settings["seed"], "example", date)
        drive = rig.worn(round(share * settings["simulated_test"]["operations"]), scatter=False)
        columns = _record(drive, rng)
        rows = [";".join(row) for row in zip(*columns.values(), strict=True)]
        lines = [_STATED.format(date=date), "", ";".join(columns), *rows, ""]
        (folder / f"visit_{date}.csv").write_text("\n".join(lines), encoding="utf-8")
    bare = [";".join(row[1:4]) for row in zip(*columns.values(), strict=True)]
    (folder / "unknown.txt").write_text("\n".join(["s1;s2;s3", *bare, ""]), encoding="utf-8")
    return len(_VISITS) + 1


def _record(drive: Drive, rng: np.random.Generator) -> dict[str, list[str]]:
    """Columns of an export of a close and an open of three poles, as texts."""
    time = np.arange(round(_LENGTH * _RATE)) / _RATE
    poles, contacts = {}, {}
    for pole in "RST":
        factors = np.exp(_SCATTER * rng.standard_normal(len(NAMES)))
        own = drive.changed(**dict(zip(NAMES, drive.theta * factors, strict=True)))
        close, open_ = (own.travel(m, time - trip - _DELAY) for m, trip in _TRIPS.items())
        way = np.where(time < _TRIPS["opening"], close, open_)
        poles[f"Travel {pole} (mm)"] = way + _NOISE * rng.standard_normal(time.size)
        contacts[f"Contact {pole}"] = way > own.value(GAP.name)
    high, rise, lasts = _COIL
    coils = {
        f"Coil {motion} (A)": high
        * -np.expm1(-np.maximum(time - trip, 0.0) / rise)
        * ((time > trip) & (time < trip + lasts))
        for motion, trip in _TRIPS.items()
    }
    form = {"Time (ms)": "{:.2f}"} | dict.fromkeys(contacts, "{:d}")
    columns = {"Time (ms)": time, **poles, **contacts, **coils}
    return {
        name: [form.get(name, "{:.3f}").format(each) for each in values.tolist()]
        for name, values in columns.items()
    }
