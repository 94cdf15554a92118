"""Coverage on drives of a size that no network was trained on, from files to posteriors.

Sixty drives of the family of `rigs`, all that the model leaves out included, are made as large as a
breaker of 150 mm and 3.5 m/s and recorded as an analyser does: steps of 0.08 mm, noise of 0.05 mm,
no times, close and open in one record. Each is treated as a user does: settings proposed by
`breaker inspect` for its first file, size and noise read from its records, exact posteriors. Prints
how many 90 % intervals hold the drive's own values, and writes every interval to a CSV file:
`python benchmarks/other_drives.py [RIGS [OUTPUT.csv]]`, some two minutes of one core.
"""

import logging
import os
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("NUMBA_NUM_THREADS", "1")

import numpy as np
import pandas as pd
import yaml

from breaker.files import Operation
from breaker.inspection import inspect_file, overlay_of
from breaker.mechanism import NAMES, evaluate, speeds_of
from breaker.model import Prior, generator, reference_model
from breaker.posterior import infer_exactly, read_drive
from breaker.shipped import DEFAULTS
from breaker.synthetic import CHANNELS, HIGH_VOLTAGE, Family, write_exports
from breaker.workflow import load

SEED, LEVEL = 1, 0.90
APART = 800.0  # ms from closing to opening: some drives of the family creep to their rest
READ = {
    "closing": ["touch_time", "travel_time", "closing_speed"],
    "opening": ["part_time", "travel_time", "opening_speed"],
}


def main(rigs: int = 60, output: str = "") -> None:
    logging.getLogger("breaker").setLevel(logging.ERROR)
    config = load([DEFAULTS])
    family = Family(Prior.from_settings(config["prior"]), config["rigs"])
    rows = []
    for rig in range(1, rigs + 1):
        drive = family.new(generator(SEED, "other drives", rig))
        with TemporaryDirectory() as folder:
            write_exports(drive, rig, folder, 1, force_sd=0.0, apart=APART)
            rows += judged(rig, drive, Path(folder, "rack_0001.txt"), config)
    table = pd.DataFrame(rows)
    table["inside"] = (table.lower <= table.truth) & (table.truth <= table.upper)
    table["width"] = (table.upper - table.lower) / table.truth
    if output:
        table.to_csv(output, index=False, float_format="%.6g")
    groups = table.groupby(["motion", "quantity"], sort=False)
    found = groups.agg(inside=("inside", "mean"), width=("width", "median"))
    print((100.0 * found).round(0).astype(int).unstack("motion").to_string())
    print(f"resolved: {100.0 * table.resolved.mean():.0f} % of {2 * rigs} records")


def judged(rig: int, drive, file: Path, config: dict) -> list[dict]:
    """Intervals of a drive's records beside its own values, both motions."""
    proposed = yaml.safe_load(overlay_of(inspect_file(file, config["sensor"])))
    records = {motion: [Operation(1, file, channel=CHANNELS[0])] for motion in READ}
    models = {motion: reference_model(motion) for motion in READ}
    found = read_drive(records, proposed["endurance"]["format"], models)
    theta = np.array([drive.theta]) * HIGH_VOLTAGE.factors
    real = drive.scaled(HIGH_VOLTAGE)
    speeds, rows = speeds_of(config["speeds"], found.size), []
    for motion, names in READ.items():
        curves = found.curves[motion]
        common = {"draws": config["endurance"]["draws"], "misfit_p_value": 1e-3, "seed": SEED}
        answer = infer_exactly(found.models[motion], curves, config["correction"], **common)
        if not bool(answer.accepted[0]):
            print(f"rig {rig} {motion}: {answer.reason.values[0]}; {proposed}")
            continue
        draws = answer.draws.values[0, :, : len(NAMES)].astype(float)
        values = np.column_stack([draws, evaluate(names, draws, motion, speeds)])
        truth = np.append(theta[0], evaluate(names, theta, motion, speeds)[0])
        ends = np.nanquantile(values, [(1 - LEVEL) / 2, (1 + LEVEL) / 2], axis=0)
        rows += [
            {"rig": rig, "motion": motion, "quantity": name, "truth": true, "lower": low}
            | {"upper": high, "resolved": bool(answer.resolved[0]), "p": float(answer.p_value[0])}
            | {"lengths": found.size.lengths, "times": found.size.times, "noise": found.noise_sd}
            for name, true, low, high in zip([*NAMES, *names], truth, *ends, strict=True)
        ]
        # The rig's own contact switches at another time than that of the model at its values.
        switches = real.operate(motion, np.arange(0.0, 300.0, 0.1))[1]
        rows.append({**rows[-len(names)], "quantity": f"{names[0]} of the rig", "truth": switches})
    return rows


if __name__ == "__main__":
    main(*(kind(each) for kind, each in zip((int, str), sys.argv[1:], strict=False)))
