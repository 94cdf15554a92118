"""Priors fitted to some breakers of a type: are they right, and what do they bring?

    python -m studies.fit_prior --breakers 5 --types 8
    python -m studies.fit_prior --breakers 5 --types 8 --other

A type has medians around those of the default prior, and a share of its log-sds from breaker to
breaker; its breakers have what the model lacks on top, alike. Every other type is of 150 mm and
3.5 m/s. Drives are of the rig's elements, or of other code (``studies.other_code``). Three records
per motion of some breakers are written to files, and the prior is fitted to them: without contacts,
and with contacts that are timed to 0.1 ms. Single operations of further breakers, without contacts,
are inferred without a prior of the type and under both. Prints by how many nats the logarithm of
the density of the truth is above that without a prior, draws taken for normal, what percentage
intervals of 90 % contain, and their width: of each parameter, and of the times of touch and parting
after 10 % of the way (ms at size 1). A type takes some 10 s.
"""

import argparse
import tempfile
from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from breaker.common.randomness import generator
from breaker.configuration.loading import load
from breaker.drive.answers.assessment import Assessment
from breaker.drive.answers.evidence import Given
from breaker.drive.answers.type_prior import fit_type
from breaker.drive.answers.type_records import list_breakers, read_breakers
from breaker.drive.simulation.drive_family import Family
from breaker.drive.simulation.rich_drive import Drive
from breaker.mechanism.prior import Prior
from breaker.quantities.parameters import MOTIONS, NAMES
from breaker.quantities.size import Size
from breaker.reading.files.operations_table import Operation
from breaker.reading.instruments.export import write_curve
from breaker.reading.records.contact_edges import Contact
from breaker.shipped import DEFAULTS
from studies.other_code import Other

SIZES = (Size(), Size(10.35, 4.46))
OFF = 0.7  # log-sds between types, of the default ones
RECORDS, FURTHER, NOISE, CONTACT = 3, 4, 0.1, 0.1  # the last two mm and ms, at size 1
OTHERWISE = 0.05  # scatter of what drives of other code have beside the parameters
TIMES = np.arange(0.0, 72.0, 0.1)  # ms
SHOWN = (*NAMES, "touch", "parting")


@dataclass(frozen=True, eq=False)
class Timed(Assessment):
    """An assessment of records whose contacts were timed.

    Attributes:
        contacts: When, by file, ms, and how well.
    """

    contacts: Mapping[Path, tuple[float, float]] = field(default_factory=dict)

    def read(self, operations, **more) -> list:
        """Read records, with their contacts."""
        found = []
        for each in super().read(operations, **more):
            if not each.reason and each.operation.file in self.contacts:
                contact = Contact(*self.contacts[each.operation.file])
                each = replace(each, raw=replace(each.raw, contact=contact))
            found.append(each)
        return found


def drives_of(default: Prior, options, rigs: Mapping, rng: np.random.Generator) -> list:
    """Draw breakers of a type whose contacts stay pressed."""
    while True:
        drawn = Prior(
            default.destandardise(OFF * rng.standard_normal(len(NAMES))),
            options.share * default.log_sds,
        )
        if np.exp(drawn.log_support) > 0.95:
            break
    count, found = options.breakers + FURTHER, []
    while len(found) < count:
        if options.other:
            each = Other.drawn(drawn, rng)
            first = found[0].more if found else each.more
            more = {n: v * np.exp(OTHERWISE * rng.standard_normal()) for n, v in first.items()}
            each = Other(each.theta, more)
            holds = each.excess(each.theta[NAMES.index("L")]) > 0.02
        else:
            each = Family(drawn, rigs).new(rng)
            each = replace(each, elements=found[0].elements if found else each.elements)
            holds = each.holds
        found += [each] if holds else []
    return found


def operate(drive, motion: str, times: np.ndarray) -> tuple[np.ndarray, float]:
    """Travel at times after the release, and the time of touch or parting."""
    return (drive.operate if isinstance(drive, Drive) else drive.travel)(motion, times)


def write(folder: Path, drive, size: Size, rng: np.random.Generator) -> tuple[dict, dict]:
    """Write the records of a breaker; returns its operations by motion, and times of contacts."""
    found: dict[str, list] = {motion: [] for motion in MOTIONS}
    contacts = {}
    for motion in MOTIONS:
        (folder / motion).mkdir(parents=True, exist_ok=True)
        for number in range(1, RECORDS + 1):
            late = 10.0 + 0.3 * rng.standard_normal()
            curve, switching = operate(drive, motion, TIMES - late)
            curve = size.lengths * (curve + NOISE * rng.standard_normal(TIMES.size))
            file = folder / motion / f"operation_{number}.csv"
            write_curve(file, size.times * TIMES, curve, motion=motion, operation=number)
            found[motion].append(Operation(number, file))
            contacts[file] = size.times * (late + switching)
    return found, contacts


def one_type(number: int, options, config: dict, folder: Path) -> list[tuple]:
    """Fit a type, and infer further breakers: rows of method, quantity, mean, sd, bounds, truth."""
    rng = generator(41, "benchmark of types", options.breakers, number)
    size = SIZES[number % 2]
    drives = drives_of(Prior.from_settings(config["prior"]), options, config["rigs"], rng)
    written = [write(folder / f"Q{i}", drive, size, rng) for i, drive in enumerate(drives)]
    sd = CONTACT * size.times
    every = {file: at for _, own in written for file, at in own.items()}
    timed = {file: (at + sd * rng.standard_normal(), sd) for file, at in every.items()}
    named = [folder / f"Q{i}" for i in range(options.breakers)]
    ways = {"alone": Given()}
    for name, contacts in (("type", {}), ("type with contacts", timed)):
        read = Timed(config, contacts=contacts)
        recorded = read_breakers(list_breakers(named, MOTIONS), read)
        fitted = fit_type(recorded, np.zeros(len(NAMES)))
        ways[name] = Given(recorded.size, fitted.prior, contact_lag=fitted.contact_lag)
    rows = []
    for i in range(options.breakers, len(drives)):
        operations, contacts = written[i]
        one = {motion: each[:1] for motion, each in operations.items()}
        theta = np.log(np.array(drives[i].theta) * size.factors)
        for name, given in ways.items():
            own = Assessment(config, given=given)
            for answer in own.infer(own.read(one)):
                if answer.draws is None:
                    continue
                record, motion = answer.record, answer.record.motion
                event = SHOWN[len(NAMES) + MOTIONS.index(motion)]
                at = contacts[record.operation.file] - record.tenth
                drawn = {event: (answer.draws.switching[motion] / size.times, at / size.times)}
                if motion == answer.motions[0]:
                    logs = np.log(answer.draws.theta).T
                    drawn |= dict(zip(NAMES, zip(logs, theta, strict=True), strict=True))
                for what, (draws, truth) in drawn.items():
                    ends = np.quantile(draws, [0.05, 0.95])
                    rows.append((number, i, name, what, draws.mean(), draws.std(), *ends, truth))
    return rows


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--breakers", type=int, default=5)
    parser.add_argument("--types", type=int, default=8)
    parser.add_argument("--first", type=int, default=0, help="number of the first type")
    parser.add_argument("--share", type=float, default=0.3)
    parser.add_argument("--other", action="store_true", help="drives of other code")
    options = parser.parse_args()
    config, rows = load([DEFAULTS]), []
    for number in range(options.first, options.first + options.types):
        with tempfile.TemporaryDirectory() as folder:
            rows += one_type(number, options, config, Path(folder))
    print(vars(options))
    scores: dict[tuple, dict] = defaultdict(dict)
    for number, i, name, what, mean, sd, low, high, truth in rows:
        score = -0.5 * ((truth - mean) / sd) ** 2 - np.log(sd)
        scores[name, what][number, i] = score, low <= truth <= high, high - low
    for name in dict.fromkeys(row[2] for row in rows):
        for what in SHOWN:
            of, alone = scores[name, what], scores["alone", what]
            both = [key for key in of if key in alone]
            gain = np.mean([of[key][0] - alone[key][0] for key in both])
            held, width = (np.array([each[k] for each in of.values()]) for k in (1, 2))
            print(
                f"{name:20s} {what:8s} {len(of):3d} {gain:+.2f} nats, {100.0 * held.mean():3.0f} % "
                f"in intervals of {np.median(width):.3f}",
                flush=True,
            )


if __name__ == "__main__":
    main()
