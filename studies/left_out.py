"""What becomes of the intervals when a drive has a mechanism that the family has not.

Trains a small network on the family without one mechanism, for each in turn, and asks it for drives
of strength 1 that all have this mechanism; beside it a network of the same size on the whole family
(`nothing`), asked for the same drives: what it costs not to know the mechanism. A last one is
trained on `plain` drives, of strength 1 with elastic contacts and without random forces, and asked
for these: how sharp a narrower family would be.

    python -m studies.left_out levels levels.csv     # two hours of a core; goes on where it ended
    python -m studies.left_out changes changes.csv

The sensor is that of the defaults: noise 0.7 % of the stroke, of means 0.15 %; the size is known.
"""

import sys
from pathlib import Path

import numpy as np
import pandas as pd

from breaker.common.randomness import generator
from breaker.configuration.loading import load, merge
from breaker.drive.family.network_files import open_network, write_network
from breaker.drive.simulation.drive_family import Family
from breaker.drive.training.family_bank import simulate_family
from breaker.drive.training.network_training import train_network
from breaker.drive.training.training_rows import rows_of, sample_rows
from breaker.mechanism.prior import Prior
from breaker.paper.validation.quality_tables import family_quality
from breaker.shipped import DEFAULTS
from studies.shared import append

DRIVES, ASIDE, PROBES, DRAWS = 30_000, 1000, 3000, 300
SHORT = {"steps": 3000, "validation_curves": ASIDE, "device": "cpu"}
NONE = [0.0, 0.0]
WAVES = dict.fromkeys(("way_force", "time_force", "speed_force"), NONE)
STOPPED = {"damping": NONE, "stiffness": NONE}
STRONG = {"strength": 1.0}  # all mechanisms, each at its own
LEFT_OUT = {
    "nothing": {},
    "drag": {"more": {"drag": NONE}},
    "falling force": {"more": {"force_fall": NONE}},
    "linkage": {"more": {"linkage": NONE}},
    "held contacts": {"contacts": {"elastic": 1.0, "held": 0.0}},
    "random forces": {"more": WAVES},
    "lever": {"elements": {"lever_turn": NONE, "lever_lean": NONE}},
    "dry friction": {"elements": {"dry_friction": NONE}},
    "preloads": {"elements": {"opening_preload": NONE, "contact_preload": NONE}},
    "build-up": {"more": {"build_up": NONE}},
    "closing train": {"elements": {"train_mass": NONE, "train_friction": NONE}},
    "bounce": {"elements": {"restitution": NONE}},
    "dampers": {"elements": {"closing_stop": STOPPED, "opening_stop": STOPPED}},
    "plain": {**STRONG, "contacts": {"elastic": 1.0, "held": 0.0}, "more": WAVES},
}
PRESENT = {
    "held contacts": {"contacts": {"elastic": 0.0, "held": 1.0}},
    "plain": LEFT_OUT["plain"],
}
SENSOR = {"levels": {"noise": (0.0074, 0.0075)}, "changes": {"noise": (0.0015, 0.00151)}}


def main(kind: str, output: str) -> None:
    config = load([DEFAULTS])
    prior, seed = Prior.from_settings(config["prior"]), config["seed"]
    settings = merge(config["family_networks"], {"training": SHORT})
    done = set(pd.read_csv(output).left_out) if Path(output).exists() else set()
    whole = None
    for name, without in LEFT_OUT.items():
        saved = Path(output).with_suffix(f".{name.replace(' ', '_')}.safetensors")
        if name not in done:
            family = Family(prior, merge(config["family"], without))
            bank = simulate_family(family, DRIVES, generator(seed, "left out", kind))
            last = bank.isel(drive=slice(DRIVES - ASIDE, None))
            _, weights, frozen = train_network(rows_of(kind, bank), last, settings, seed)
            about = {"kind": kind, "family": "left out", "networks": settings}
            write_network(saved, about, weights, frozen)
        network = open_network(saved)
        whole = whole or network
        if name in done:
            continue
        probe = Family(prior, merge(merge(config["family"], STRONG), PRESENT.get(name, {})))
        bank = simulate_family(probe, PROBES, generator(seed, "left out, probe", kind))
        tables = [
            asked(kind, each, bank, seed).assign(left_out=name, network=called)
            for called, each in (("without", network), ("whole", whole))
        ]
        append(pd.concat(tables), output, float_format="%.4g")


def asked(kind, network, bank, seed) -> pd.DataFrame:
    """Quality of a network on the drives of a bank, by source."""
    sensor, tables = dict(SENSOR[kind]), []
    if kind == "levels":
        sensor["told"] = np.ones(bank.sizes["drive"], dtype=bool)
    for source in ("closing", "opening", "both"):
        rng = generator(seed, "left out, records", source)
        data = sample_rows(network, rows_of(kind, bank, network), source, DRAWS, rng, **sensor)
        tables.append(family_quality(data, log=kind == "levels").assign(motions=source))
    return pd.concat(tables)


if __name__ == "__main__":
    main(*sys.argv[1:])
