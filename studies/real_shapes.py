"""Whether a family of drives contains the shapes of real ones.

    python -m studies.real_shapes BANDS.csv     # makes docs/real_shapes.csv

BANDS.csv has bands of measured curves, such as those that are published for high-voltage breakers:
columns motion, time, q05 and q95. The last two are the share of the way that is made at a time
after 10 % of the way, in units of the time from 10 to 90 %. The table has the share of times at
which the family's 99 % band contains the measured band, for each family, motion and noise.
"""

import argparse
from pathlib import Path

import numpy as np
import pandas as pd

from breaker.common.randomness import generator
from breaker.configuration.data_files import family_of
from breaker.configuration.loading import load
from breaker.family.bank import shapes, simulate_family
from breaker.family.drive_family import Family
from breaker.model.parameters import MOTIONS
from breaker.model.prior import Prior

FAMILIES = ([], ["config/any.yaml"])  # files of settings
NOISES = (0.003, 0.01)  # of a sample, share of the stroke: without any, curves agree at 10 and 90 %
ENDS = (0.005, 0.995)


def rows_of(real: pd.DataFrame, config: dict, drives: int) -> pd.DataFrame:
    """Return a row for each motion and noise."""
    family = Family(Prior.from_settings(config["prior"]), family_of(config["family"]["name"]))
    rng = generator(1, "real shapes")
    bank = simulate_family(family, drives, rng)
    rows = []
    for motion in MOTIONS:
        measured = real[real.motion == motion]
        times = measured.time.values
        curves = shapes(bank["shape"].sel(motion=motion).values).reshape(2 * drives, -1)
        made = scaled(curves, bank.u.values, times)
        for noise in NOISES:
            low, high = np.quantile(made + noise * rng.standard_normal(made.shape), ENDS, axis=0)
            inside = (low <= measured.q05.values) & (measured.q95.values <= high)
            about = [config["family"]["name"], drives, motion, noise]
            rows.append([*about, times.size, inside.mean()])
    return pd.DataFrame(rows, columns=["family", "drives", "motion", "noise", "times", "inside"])


def crossing(curves: np.ndarray, times: np.ndarray, level: float) -> np.ndarray:
    """Return times at which curves ``(n, t)`` first pass a level, ``(n,)``."""
    after = (curves >= level).argmax(axis=1).clip(1)
    rows = np.arange(len(curves))
    low, high = curves[rows, after - 1], curves[rows, after]
    share = (level - low) / np.where(high > low, high - low, np.nan)
    return times[after - 1] + share * (times[after] - times[after - 1])


def scaled(curves: np.ndarray, times: np.ndarray, grid: np.ndarray) -> np.ndarray:
    """Return curves ``(n, t)`` at times after 10 % of the way, in units of those from 10 to 90 %.

    Those that take longer to 90 % than a bank keeps are left out.
    """
    curves = curves[curves.max(axis=1) > 0.9]
    unit = crossing(curves, times, 0.9) - crossing(curves, times, 0.1)
    fine = [np.interp(one * grid, times, curve) for one, curve in zip(unit, curves, strict=True)]
    return np.array(fine)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("bands", type=Path)
    parser.add_argument("--drives", type=int, default=1500)
    given = parser.parse_args()
    real, configs = pd.read_csv(given.bands), [load(files) for files in FAMILIES]
    rows = pd.concat([rows_of(real, config, given.drives) for config in configs])
    print(rows.to_string(index=False))
    rows.to_csv("docs/real_shapes.csv", index=False, float_format="%.3g")


if __name__ == "__main__":
    main()
