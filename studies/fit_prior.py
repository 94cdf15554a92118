"""Priors fitted to some breakers of a type: are they right, and what do they bring?

    python -m studies.fit_prior --breakers 3 --types 10
    python -m studies.fit_prior --breakers 3 --types 10 --share 1.0
    python -m studies.fit_prior --breakers 3 --types 10 --alike

A type has medians around those of the default prior, and a share of its log-sds from breaker to
breaker; each breaker has what the model lacks on top, alike in all of a type or not. Every other
type is of 150 mm and 3.5 m/s. Three records per motion of some breakers are written to files, the
prior is fitted to them, and single records of further breakers are inferred: under it, and without
any prior of the type. Prints for each parameter the percentage that intervals of
90 % contain, and their width (of log-sds: that are not below the truth, and their size).
"""

import argparse
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np

from breaker.common.randomness import generator
from breaker.configuration.loading import load
from breaker.drive.answers.assessment import Assessment
from breaker.drive.answers.evidence import Given
from breaker.drive.answers.type_prior import fit_type, wear_allowance
from breaker.drive.answers.type_records import list_breakers, read_breakers
from breaker.drive.family.network_files import open_network
from breaker.drive.simulation.drive_family import Family
from breaker.drive.simulation.rich_drive import Drive
from breaker.mechanism.prior import Prior
from breaker.quantities.parameters import MOTIONS, NAMES
from breaker.quantities.size import Size
from breaker.reading.files.operations_table import Operation
from breaker.reading.instruments.export import write_curve
from breaker.shipped import DEFAULTS, model_file

SIZES = (Size(), Size(10.35, 4.46))
OFF = 0.7  # log-sds between types, of the default ones
RECORDS, FURTHER, NOISE = 3, 3, 0.1


def type_of(default: Prior, share: float, rng: np.random.Generator) -> Prior:
    """Draw a type whose contacts stay pressed."""
    while True:
        medians = default.destandardise(OFF * rng.standard_normal(len(NAMES)))
        drawn = Prior(medians, share * default.log_sds)
        if np.exp(drawn.log_support) > 0.95:
            return drawn


def drives_of(
    drawn: Prior, rigs: dict, count: int, alike: bool, rng: np.random.Generator
) -> list[Drive]:
    """Draw breakers of a type; alike, they have the elements of the first, where these hold."""
    drives = [Family(drawn, rigs).new(rng) for _ in range(count)]
    same = [replace(each, elements=drives[0].elements) for each in drives]
    return [s if alike and s.holds else d for s, d in zip(same, drives, strict=True)]


def write(folder: Path, drive: Drive, size: Size, rng: np.random.Generator) -> dict:
    """Write the records of a breaker; returns its operations by motion."""
    time, big = np.arange(0.0, 72.0 * size.times, 0.1 * size.times), drive.scaled(size)
    found = {}
    for motion in MOTIONS:
        (folder / motion).mkdir(parents=True, exist_ok=True)
        found[motion] = []
        for number in range(1, RECORDS + 1):
            curve = big.travel(motion, time - size.times * (10.0 + 0.3 * rng.standard_normal()))
            curve += NOISE * size.lengths * rng.standard_normal(time.size)
            file = folder / motion / f"operation_{number}.csv"
            write_curve(file, time, curve, motion=motion, operation=number)
            found[motion].append(Operation(number, file))
    return found


def one_type(number: int, options, config: dict, folder: Path, levels) -> list:
    """Fit a type, and infer further breakers; rows of what is judged."""
    breakers = options.breakers
    rng = generator(41, "benchmark of types", breakers, number)
    size, default = SIZES[number % 2], Prior.from_settings(config["prior"])
    drawn = type_of(default, options.share, rng)
    drives = drives_of(drawn, config["rigs"], breakers + FURTHER, options.alike, rng)
    files = [write(folder / f"Q{i}", drive, size, rng) for i, drive in enumerate(drives)]
    named = [folder / f"Q{i}" for i in range(breakers)]
    own, networks = config | {"seed": 1}, lambda: [levels]
    recorded = read_breakers(list_breakers(named, MOTIONS), Assessment(own, families=networks))
    fitted = fit_type(recorded, wear_allowance(config["rigs"]["wear"]["change"]))
    learned = fitted.learned
    off = np.log(drawn.medians * size.factors / learned.medians)
    sd = np.hypot(learned.known, learned.shared)
    rows = [("medians", np.abs(off) < 1.645 * sd, sd)]
    rows.append(("log-sds", fitted.prior.log_sds >= drawn.log_sds, fitted.prior.log_sds))
    for i in range(breakers, breakers + FURTHER):
        truth = np.log(np.array(drives[i].theta) * size.factors)
        for motion in MOTIONS:
            records = Assessment(own).read({motion: files[i][motion][:1]})
            for name, given in (("alone", Given()), ("fitted", Given(recorded.size, fitted.prior))):
                (found,) = Assessment(own, given=given, families=networks).infer(records)
                if found.draws is None:
                    continue
                low, high = np.quantile(np.log(found.draws.theta), [0.05, 0.95], axis=0)
                rows.append((f"{name}, {motion}", (low <= truth) & (truth <= high), high - low))
    return rows


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--breakers", type=int, default=3)
    parser.add_argument("--types", type=int, default=10)
    parser.add_argument("--share", type=float, default=0.5)
    parser.add_argument("--alike", action="store_true")
    options = parser.parse_args()
    config, rows = load([DEFAULTS]), []
    levels = open_network(model_file("medium_voltage", "levels"))
    for number in range(options.types):
        with tempfile.TemporaryDirectory() as folder:
            rows += one_type(number, options, config, Path(folder), levels)
    print(vars(options))
    print(f"{'':22s} n   all  " + "".join(f"{name:>10s}" for name in NAMES))
    for name in dict.fromkeys(row[0] for row in rows):
        held = 100.0 * np.array([row[1] for row in rows if row[0] == name])
        width = np.median([row[2] for row in rows if row[0] == name], axis=0)
        cells = zip(held.mean(axis=0), width, strict=True)
        shown = "".join(f"{each:4.0f} {wide:5.2f}" for each, wide in cells)
        print(f"{name:20s} {len(held):4d} {held.mean():5.1f}  {shown}", flush=True)


if __name__ == "__main__":
    main()
