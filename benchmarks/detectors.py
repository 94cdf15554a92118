"""A detector of a library, on the simulated lives, beside those of the package.

River's Page-Hinkley test watches what is best for it: the means of the posteriors of single
records, less their own line, each parameter of a motion given all other outputs (`directed`), and
the mean of both motions; an alarm of any is one. `delta` is what did best on lives of seed 21,
where ADWIN of the same library found fewer changes at every level.

Reads what `snakemake lives` leaves; prints a table and writes it, together with that of the
package's own detectors, and the figure of all: `python benchmarks/detectors.py [SEED [FOLDER]]`, a
minute of one core. River is not needed elsewhere, so it is none of the package's dependencies.
"""

import sys
from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr
import yaml
from river.drift import PageHinkley

from breaker.figures.detectors import detectors
from breaker.stores import open_store
from breaker.synthetic import Watch, compare_detectors, directed, of_records, score_alarms

DELTA = 1.0
THRESHOLDS = (4.0, 4.5, 5.0, 5.5, 6.0, 6.5, 7.0)
NAME = "Page-Hinkley (river)"


def page_hinkley(
    position: np.ndarray, values: np.ndarray, *, wearing: np.ndarray, threshold: float, warm_up: int
) -> np.ndarray:
    """Return 1 where the test first reports a drift in any stream, else 0; NaN in the warm-up.

    Args:
        wearing: Numbers of the series that wear, ``(motion, p)``.
    """
    own = directed(position, values, warm_up=warm_up)[:, wearing]  # (n, motion, p)
    mean = own.sum(axis=1, keepdims=True) / np.sqrt(len(wearing))
    streams = np.concatenate([own, mean], axis=1).reshape(len(own), -1)
    known = np.flatnonzero(np.isfinite(streams).all(axis=1))
    statistic = np.full(len(own), np.nan)
    statistic[known] = 0.0
    for stream in streams[known].T.tolist():
        test = PageHinkley(min_instances=1, delta=DELTA, threshold=threshold)
        for i, value in zip(known, stream, strict=True):
            test.update(value)
            if test.drift_detected:
                statistic[i] = 1.0
                break
    return statistic


def rows(lives: xr.Dataset, settle: int) -> pd.DataFrame:
    """Score the test at its thresholds."""
    outputs = np.arange(lives.sizes["motion"] * lives.sizes["parameter"])
    wearing = outputs.reshape(lives.sizes["motion"], -1)[:, lives.parameter.values != "onset"]
    series = [each.reshape(len(each), -1) for each in of_records(lives, "output")]
    records, found = of_records(lives, "operation"), []
    for threshold in THRESHOLDS:
        test = partial(page_hinkley, wearing=wearing, threshold=threshold, warm_up=settle)
        watches = zip(records, series, strict=True)
        alarms = [x[Watch(each, test).at(0.5).alarm] for x, each in watches]
        found.append({"detector": NAME, "level": threshold} | score_alarms(lives, alarms, settle))
    return pd.DataFrame(found)


def main(seed: str = "22", folder: str = "benchmarks") -> None:
    """Write the table and the figure."""
    settings = yaml.safe_load(Path("config/config.yaml").read_text())["wear_model"]
    files = sorted(Path(f"results/lives/seed{seed}").glob("lives_*.zarr"))
    lives = xr.concat([open_store(file).load() for file in files], "life")
    settle, level = settings["settle"], settings["alarm_level"]
    library = rows(lives, settle)
    print(library.round(2).to_string(index=False))
    table = pd.concat([compare_detectors(lives, settle=settle), library])
    table.to_csv(Path(folder) / f"detectors_seed{seed}.csv", index=False, float_format="%.6g")
    figure = detectors(table, lives=lives.sizes["life"], alarm_level=level)
    figure.savefig(Path(folder) / "detectors.png")


if __name__ == "__main__":
    main(*sys.argv[1:])
