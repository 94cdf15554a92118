"""How well drives of any size are inferred from their files, without a training.

Drives of the family of ``rigs`` (the model's own error and all), scaled to a stroke and a speed,
are written as files of both motions, read by ``read_drive`` and inferred exactly from the mode of
their posteriors. Counted are records that are read and resolved, and how often the central 90 %
interval contains each true parameter of the drive.

    python benchmarks/sizes.py [--drives 300] [--size-drives 20] [--output docs/sizes.csv]
"""

import argparse
import os
import tempfile
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("NUMBA_NUM_THREADS", "1")

import numpy as np
import pandas as pd

from breaker.files import Operation
from breaker.mechanism import MOTIONS, NAMES, Size
from breaker.model import Prior, generator, reference_model
from breaker.posterior import infer_exactly, read_drive
from breaker.records import write_curve
from breaker.shipped import DEFAULTS
from breaker.synthetic import Family
from breaker.workflow import load

STROKE, SPEED = 14.5, 1.5  # mm and mm/ms, of the default drive
SHARES = (2e-4, 3e-3, 2e-2)  # noise, of the stroke
CORNERS = [(stroke, speed) for stroke in (6, 40, 150, 200) for speed in (0.5, 2, 6)]
STEP, SLOWEST = 0.08, 1.0  # ms between samples, of a drive of the default speed, and at most
REST, LENGTH = 20.0, 90.0  # ms before the motion, and of a record, of a drive of the default speed


def size_of(stroke: float, speed: float) -> Size:
    """The size of drives of a stroke, mm, and a greatest speed, mm/ms."""
    lengths = stroke / STROKE
    return Size(lengths, lengths * SPEED / speed)


def write(drive, size: Size, noise_sd: float, folder: Path, rng) -> dict[str, list[Operation]]:
    """Write a record of each motion of a drive, noise in mm."""
    step = min(STEP * size.times, SLOWEST)
    time = np.arange(0.0, LENGTH * size.times, step)
    found = {}
    for motion in MOTIONS:
        moves = size.times * (REST + 0.3 * rng.standard_normal())
        curve = drive.travel(motion, time - moves)
        curve = curve + noise_sd * rng.standard_normal(time.size)
        curve += 0.1 * size.lengths * rng.standard_normal()
        file = folder / f"{motion}.csv"
        # In units of a thousandth of the lengths, as files have three digits.
        write_curve(file, time, curve / size.lengths, motion=motion, operation=1)
        found[motion] = [Operation(1, file)]
    return found


def infer_drive(config: dict, corner: tuple[float, float, float], scale: float, number: int):
    """Rows of one drive: a row a motion, with whether it was read, resolved, and inside."""
    stroke, speed, share = corner
    size = size_of(stroke, speed)
    rng = generator(41, "sizes", number)
    rigs = {**config["rigs"], "strength": config["rigs"]["strength"] * (scale > 0)}
    family = Family(Prior.from_settings(config["prior"]), rigs)
    drive = family.new(rng).scaled(size)
    models = {motion: reference_model(motion, scale) for motion in MOTIONS}
    with tempfile.TemporaryDirectory() as folder:
        operations = write(drive, size, share * stroke, Path(folder), rng)
        read = read_drive(operations, {"ratio": size.lengths}, models)
    for motion in MOTIONS:
        row = {"stroke": stroke, "speed": speed, "noise": share, "scale": scale, "motion": motion}
        row |= {"number": number, "read": bool(read.curves[motion].accepted[0])}
        row |= {"reason": str(read.curves[motion].reason.values[0])}
        row |= {"lengths": read.size.lengths / size.lengths, "times": read.size.times / size.times}
        if row["read"]:
            found = infer_exactly(
                *(read.models[motion], read.curves[motion], config["correction"]),
                draws=500,
                seed=number,
                misfit_p_value=config["endurance"]["misfit_p_value"],
            ).isel(operation=0)
            low, high = np.nanquantile(found.draws.sel(output=list(NAMES)), [0.05, 0.95], axis=0)
            inside = (low <= drive.theta) & (drive.theta <= high)
            row |= {"resolved": bool(found.resolved), "misfit": bool(found.misfit)}
            row |= dict(zip(NAMES, inside, strict=True))
        yield row


def table(rows: pd.DataFrame) -> pd.DataFrame:
    """Shares of each corner, %."""
    rows = rows.assign(resolved=rows.resolved.where(rows.read, False).astype(float))
    keys = ["stroke", "speed", "noise", "scale", "motion"]
    groups = rows.groupby(keys, sort=False)
    shares = groups[["read", "resolved", *NAMES]].agg(lambda one: 100 * one.astype(float).mean())
    return shares.assign(curves=groups.size()).reset_index()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--drives", type=int, default=300, help="drives of each noise")
    parser.add_argument("--size-drives", type=int, default=20, help="drives of each size")
    parser.add_argument("--right-drives", type=int, default=100, help="where the model is right")
    parser.add_argument("--output", default="docs/sizes.csv")
    options = parser.parse_args()
    config = load([DEFAULTS])
    wanted = [
        *(((40, 2, share), 1.0, options.drives) for share in SHARES),
        *(((40, 2, share), 0.0, options.right_drives) for share in SHARES),
        *(((*corner, SHARES[1]), 1.0, options.size_drives) for corner in CORNERS),
    ]
    rows = []
    for number in range(max(count for *_, count in wanted)):
        for corner, scale, count in wanted:
            rows += infer_drive(config, corner, scale, number) if number < count else []
        shares = table(pd.DataFrame(rows))  # written as it grows
        shares.to_csv(options.output, index=False, float_format="%.3g")
    print(shares.to_string(index=False))


if __name__ == "__main__":
    main()
