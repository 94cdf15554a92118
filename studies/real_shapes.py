"""Whether a family of drives contains the shapes of real ones.

Compares curves of a family with bands of measured ones, which are published for high-voltage
breakers: a CSV file with the columns motion, time and q05, q25, q50, q75, q95, the share of the way
that is made at a time after 10 % of it, in units of the time from 10 to 90 %. Prints for each
motion at which share of the times the family's 99 % band contains the real band from 5 to 95 %,
and medians of three numbers that describe a shape, the real ones beside them; draws the bands and
twenty curves of the family:

    python -m studies.real_shapes BANDS.csv [OVERLAY.yaml [FIGURE.png [DRIVES]]]

A minute of one core for 3,000 drives.
"""

import os
import sys

os.environ.setdefault("OMP_NUM_THREADS", "1")

import matplotlib
import numpy as np
import pandas as pd

matplotlib.use("Agg")
import matplotlib.pyplot as plt

from breaker.common.randomness import generator
from breaker.configuration.loading import load
from breaker.drive.simulation.drive_family import Family
from breaker.drive.training.family_bank import shapes, simulate_family
from breaker.mechanism.prior import Prior
from breaker.shipped import DEFAULTS

NOISE = 0.003  # of a sample, share of the stroke: without any, all curves agree at 10 and at 90 %
ENDS = (0.005, 0.995)
DESCRIBED = ("lead from 3 to 10 %", "time 60-80 % over 20-40 %", "overshoot")


def main(bands: str, overlay: str = "", figure: str = "", drives: int = 3000) -> None:
    real = pd.read_csv(bands)
    config = load([DEFAULTS, overlay] if overlay else [DEFAULTS])
    family = Family(Prior.from_settings(config["prior"]), config["family"])
    rng = generator(1, "real shapes")
    bank = simulate_family(family, drives, rng)
    print(f"{config['family']['name']}: {drives} drives, {bank.drawn_again} drawn again")
    rows, axes = {}, plt.subplots(1, 2, figsize=(11, 4.5), layout="constrained")[1]
    for place, motion in zip(axes, ("closing", "opening"), strict=True):
        measured = real[real.motion == motion]
        curves = shapes(bank["shape"].sel(motion=motion).values).reshape(2 * drives, -1)
        made = scaled(curves, bank.u.values, measured.time.values)
        band = np.quantile(made + NOISE * rng.standard_normal(made.shape), ENDS, axis=0)
        below, above = band[0] > measured.q05.values, measured.q95.values > band[1]
        found = described(made, measured.time.values)
        median = described(measured.q50.values[None], measured.time.values)
        rows[motion] = {
            "times inside": f"{1.0 - (below | above).mean():.0%}",
            "real below": spans(measured.time.values[below]),
            "real above": spans(measured.time.values[above]),
            "slow": f"{1.0 - len(made) / len(curves):.1%}",
        } | {
            name: f"{np.nanmedian(a):.2f} (real {b[0]:.2f})"
            for name, a, b in zip(DESCRIBED, found, median, strict=True)
        }
        draw(place, measured, made, band)
        place.set_title(motion)
    print(pd.DataFrame(rows).to_string())
    touched(bank)
    if figure:
        plt.savefig(figure, dpi=120)


def spans(times: np.ndarray) -> str:
    """Times in words, neighbours as from-to."""
    runs = np.split(times, np.flatnonzero(np.diff(times) > 0.051) + 1)
    return ", ".join(f"{run[0]:.2f}..{run[-1]:.2f}" for run in runs if run.size)


def crossing(curves: np.ndarray, times: np.ndarray, level: float) -> np.ndarray:
    """Times at which curves ``(n, t)`` first pass a level, ``(n,)``."""
    after = (curves >= level).argmax(axis=1).clip(1)
    rows = np.arange(len(curves))
    low, high = curves[rows, after - 1], curves[rows, after]
    share = (level - low) / np.where(high > low, high - low, np.nan)
    return times[after - 1] + share * (times[after] - times[after - 1])


def scaled(curves: np.ndarray, times: np.ndarray, grid: np.ndarray) -> np.ndarray:
    """Curves ``(n, t)`` at times after 10 % of the way in units of those from 10 to 90 %.

    Those that take longer to 90 % than a bank keeps are left out.
    """
    curves = curves[curves.max(axis=1) > 0.9]
    unit = crossing(curves, times, 0.9) - crossing(curves, times, 0.1)
    fine = [np.interp(one * grid, times, curve) for one, curve in zip(unit, curves, strict=True)]
    return np.array(fine)


def described(curves: np.ndarray, times: np.ndarray) -> tuple[np.ndarray, ...]:
    """The three numbers of curves ``(n, t)``, each ``(n,)``."""
    at = {level: crossing(curves, times, level / 100.0) for level in (3, 10, 20, 40, 60, 80)}
    ratio = (at[80] - at[60]) / (at[40] - at[20])
    return at[10] - at[3], ratio, curves.max(axis=1) - 1.0


def touched(bank) -> None:
    """Print where in the stroke contacts touch and part."""
    for kind, name in enumerate(bank.contact.kinds):
        here = bank.isel(drive=(bank.contact == kind).values, condition=0)
        if not here.drive.size:
            continue
        curves, places = shapes(here["shape"].values), []
        for i in range(2):
            pairs = zip(here.switching.values[:, i], curves[:, i], strict=True)
            way = np.array([np.interp(u, bank.u, curve) for u, curve in pairs])
            places.append(np.quantile(way if i == 0 else 1.0 - way, (0.05, 0.5, 0.95)).round(2))
        print(f"{name}: {here.drive.size} drives touch at {places[0]}, part at {places[1]}")


def draw(place, measured: pd.DataFrame, made: np.ndarray, band: np.ndarray) -> None:
    time = measured.time
    place.fill_between(time, *band, color="0.9", label="family, 99 %")
    place.plot(time, made[:20].T, color="0.6", lw=0.5)
    place.fill_between(time, measured.q05, measured.q95, color="C0", alpha=0.5, label="real, 90 %")
    place.plot(time, measured.q50, color="C0", label="real, median")
    place.set(xlabel="time after 10 %, in times from 10 to 90 %", ylabel="share of the way")
    place.legend(loc="lower right")


if __name__ == "__main__":
    main(*sys.argv[1:4], *map(int, sys.argv[4:]))
