"""Whether a family of drives contains the shapes of real ones.

    python -m studies.real_shapes BANDS.csv [OVERLAY.yaml] --table docs/real_shapes.csv

BANDS.csv has bands of measured curves, such as those that are published for high-voltage breakers:
columns motion, time and q05, q25, q50, q75, q95. These are the share of the way that is made at a
time after 10 % of it, in units of the time from 10 to 90 %. For each motion and noise the study
prints the share of times at which the family's 99 % band contains the measured band from 5 to 95 %,
and medians of three numbers that describe a shape. Rows are added to the table. A minute of one
core for 3,000 drives.
"""

import argparse
from pathlib import Path

import numpy as np
import pandas as pd

from breaker.common.randomness import generator
from breaker.configuration.definitions import family_of
from breaker.configuration.loading import load
from breaker.family.bank import shapes, simulate_family
from breaker.family.drive_family import Family
from breaker.model.parameters import MOTIONS
from breaker.model.prior import Prior
from studies.shared import append

NOISES = (0.003, 0.01)  # of a sample, share of the stroke: without any, curves agree at 10 and 90 %
ENDS = (0.005, 0.995)
DESCRIBED = ("lead from 3 to 10 %", "time 60-80 % over 20-40 %", "overshoot")


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
            row = {"family": config["family"]["name"], "drives": drives, "motion": motion}
            row |= {"noise": noise, "times": times.size, "inside": inside.mean()}
            of_real = described(measured.q50.values[None], times)
            for name, ours, theirs in zip(DESCRIBED, described(made, times), of_real, strict=True):
                row |= {f"{name}, family": np.nanmedian(ours), f"{name}, measured": theirs[0]}
            rows.append(row)
    return pd.DataFrame(rows)


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


def described(curves: np.ndarray, times: np.ndarray) -> tuple[np.ndarray, ...]:
    """Return the three numbers of curves ``(n, t)``, each ``(n,)``."""
    at = {level: crossing(curves, times, level / 100.0) for level in (3, 10, 20, 40, 60, 80)}
    ratio = (at[80] - at[60]) / (at[40] - at[20])
    return at[10] - at[3], ratio, curves.max(axis=1) - 1.0


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("bands", type=Path)
    parser.add_argument("overlay", type=Path, nargs="?")
    parser.add_argument("--drives", type=int, default=1500)
    parser.add_argument("--table", type=Path, metavar="CSV")
    options = parser.parse_args()
    config = load([*filter(None, [options.overlay])])
    rows = rows_of(pd.read_csv(options.bands), config, options.drives)
    print(rows.to_string(index=False))
    if options.table:
        append(rows, options.table, float_format="%.3g")


if __name__ == "__main__":
    main()
