"""Does a test of `breaker plan` narrow what it is foretold to narrow, and does its choice pay?

    python -m studies.next_test --rows rows.csv --table docs/next_test.csv   # 10 minutes of a core
    python -m studies.next_test --rows rows.csv --first 60 --drives 40       # more drives

Drives of the family that no training has seen, of the default size and each with a record of one
motion, closing and opening in turn, as a file that is read as a user's is. The plan is made, all
tests at the same cost. Then every test is done: its result is simulated from the drive itself, and
`infer` answers with it.

Rows have, of each drive, test and parameter, the variance of the logarithm before, foretold and
found, and the error of the mean of the posterior after the test. The table and what is printed have
the mean found variances over those foretold, both over that before, the mean square of errors over
found variances, and of each target the mean variance after the chosen test, after one chosen at
random and after the best that there was, all over the variance before.
"""

import argparse
import csv
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pandas as pd

from breaker.common.randomness import generator
from breaker.configuration.loading import load
from breaker.drive.answers.assessment import Assessment
from breaker.drive.answers.evidence import Answer, DriveRecord, Given
from breaker.drive.simulation.drive_family import Family
from breaker.drive.simulation.rich_drive import Drive
from breaker.mechanism.prior import Prior
from breaker.quantities.parameters import GAP, MOTIONS, NAMES
from breaker.quantities.size import Size
from breaker.reading.files.operations_table import Operation
from breaker.reading.instruments.export import write_curve
from breaker.reading.records.contact_edges import Contact
from breaker.shipped import DEFAULTS

NOISE, SCATTER = 0.1, 0.004  # mm of a sample; share of parameters from operation to operation
DRAWS = 2000  # of an answer, so that its variance is known
TIME, LEAD = np.arange(0.0, 75.0, 0.1), 10.0  # ms
COLUMNS = ("drive", "motion", "test", "parameter", "before", "foretold", "found", "error")
CHEAP = ("more_records", "other_motion", "contact", "size")
"""Tests of about an hour, in the defaults."""

TARGETS = ("L", "mu", "k_b")


class Bench:
    """A drive on a bench, of which records are taken.

    Attributes:
        drive: The drive.
        motion: That of the record at hand.
        record: It.
    """

    def __init__(self, drive: Drive, motion: str, config: Mapping, rng: np.random.Generator):
        self.drive, self.motion, self.rng = drive, motion, rng
        self.form = config["endurance"]["format"]
        self.tests, self.config = config["next_tests"], config
        (self.record,) = self.records({motion: 1})

    def records(self, counts: Mapping[str, int], noise: float = NOISE) -> list[DriveRecord]:
        """Records of motions, read from files; several scatter as operations do."""
        with TemporaryDirectory() as folder:
            operations = {motion: [] for motion in counts}
            for motion, count in counts.items():
                for k in range(count):
                    late = LEAD + 0.3 * self.rng.standard_normal()
                    way = self._operated(count > 1).travel(motion, TIME - late)
                    way += noise * self.rng.standard_normal(TIME.size)
                    file = Path(folder) / f"{motion}_{k}.csv"
                    write_curve(file, TIME, way, motion=motion, operation=1 + k)
                    operations[motion].append(Operation(1 + k, file))
            return Assessment(self.config).read(operations)

    def _operated(self, scatters: bool) -> Drive:
        """The drive as it is in one operation, in which it holds its closed position."""
        while scatters:
            factors = 1.0 + SCATTER * self.rng.standard_normal(len(NAMES))
            values = {n: self.drive.value(n) * f for n, f in zip(NAMES, factors, strict=True)}
            if (drive := self.drive.changed(**values)).holds:
                return drive
        return self.drive

    def infer(self, records: list[DriveRecord], given: Given) -> np.ndarray | None:
        """Draws of the logarithms of the parameters, ``(d, p)``; None where there is no answer."""
        assessment = Assessment(self.config, given=given)
        answers = assessment.infer(records)
        means = assessment.infer_means(answers)
        answer: Answer = means[0][0] if means else answers[0]
        return None if answer.draws is None else np.log(answer.draws.theta)

    def done(self, test: str, rng: np.random.Generator) -> np.ndarray | None:
        """Draws after a test; None where there is no answer."""
        self.rng = rng
        records, given = [self.record], Given()
        if test == "other_motion":
            other = next(motion for motion in MOTIONS if motion != self.motion)
            records += self.records({other: 1})
        elif test == "more_records":
            records += [
                replace(each, operation=replace(each.operation, number=2 + k))
                for k, each in enumerate(self.records({self.motion: self.tests[test]["records"]}))
            ]
        elif test == "finer_transducer":
            records = self.records({self.motion: 1}, NOISE * self.tests[test]["noise"])
        elif test == "contact":
            records = [self._timed()]
        elif test == "size":
            given = Given(Size())
        elif test != "moving_mass":
            value = self._value(test)
            whole = value if test in NAMES else self.record.shape.stroke
            sd = self.tests["facts"][test]["sd"] * whole
            given = Given(known={test: [max(value + sd * self.rng.standard_normal(), 0.0), sd]})
        return self.infer(records, given)

    def _value(self, name: str) -> float:
        if name in NAMES:
            return self.drive.value(name)
        rests = [self.drive.travel("closing", np.array([0.0, 1e3]))[k] for k in (0, 1)]
        return rests[1] - rests[0] - self.drive.value(GAP.name)

    def _timed(self) -> DriveRecord:
        """The record with the time of its contact, which is counted from 10 % of the way."""
        raw, sd = self.record.raw, self.form["timing_sd"]
        time = np.arange(0.0, 75.0, 0.005)
        way, switching = self.drive.operate(self.motion, time)
        done = (way - way[0]) / (way[-1] - way[0])
        at = self.record.tenth + switching - time[(done >= 0.1).argmax()]
        contact = Contact(at + sd * self.rng.standard_normal(), sd)
        return replace(self.record, raw=replace(raw, contact=contact))


def rows_of(number: int, config: Mapping, family: Family) -> Iterator[tuple]:
    """Rows of a drive: nothing where it is not answered."""
    rng = generator(48, "next test", number)
    drive, motion = family.new(rng), MOTIONS[number % 2]
    endurance = {**config["endurance"], "draws": DRAWS}
    config = config | {"seed": number, "endurance": endurance}  # else all have the same numbers
    bench = Bench(drive, motion, config, rng)
    if bench.record.reason:
        return
    (pole,) = Assessment(config).plan([bench.record]).poles
    truth = np.log(drive.theta)
    for test in pole.tests:
        draws = bench.done(test.name, generator(48, "next test", number, test.name))
        if draws is None:
            continue
        found, error = draws.var(axis=0), draws.mean(axis=0) - truth
        for k, name in enumerate(NAMES):
            told = test.narrowing[name]
            before, foretold = np.square([told.now / 100.0, told.expected / 100.0])
            yield number, motion, test.name, name, before, foretold, found[k], error[k]


def at_one_cost(config: Mapping, tests: Sequence[str]) -> dict:
    """The configuration with these tests at the cost 1, all if none is named, and no others."""

    def costing(name: str, each: Mapping) -> dict:
        return {**each, "cost": None if tests and name not in tests else 1.0}

    section = {n: costing(n, each) for n, each in config["next_tests"].items() if n != "facts"}
    facts = {n: costing(n, each) for n, each in config["next_tests"]["facts"].items()}
    return config | {"next_tests": section | {"facts": facts}}


def tables_of(rows: pd.DataFrame) -> dict[str, pd.DataFrame]:
    """Return what came out, by title."""
    shares = rows[["foretold", "found"]].div(rows["before"], axis=0)
    means = shares.groupby([rows["test"], rows["parameter"]]).mean()
    ratio = (means["found"] / means["foretold"]).unstack()[[*NAMES]]
    square = np.square(rows["error"]) / rows["found"]
    ratio["mean square of z"] = square.groupby(rows["test"]).mean()
    every = tuple(name for name in rows["test"].unique() if name != "moving_mass")
    return {
        "found over foretold": ratio,
        "all tests at one cost": chosen(rows, every),
        "tests of an hour at one cost": chosen(rows, CHEAP),
    }


def chosen(rows: pd.DataFrame, tests: tuple[str, ...]) -> pd.DataFrame:
    """Return what became of each target after the chosen test, by its variance over that before."""
    table = {}
    some = rows[rows["test"].isin(tests)]
    for target in TARGETS:
        one = some[some["parameter"] == target]
        foretold, found = (
            one.pivot(index="drive", columns="test", values=of) for of in ("foretold", "found")
        )
        share = found.div(one.groupby("drive")["before"].first(), axis=0)
        choice = foretold.idxmin(axis=1)
        after = pd.Series({drive: share.at[drive, test] for drive, test in choice.items()})
        at_random = share.mean(axis=1)
        table[target] = {
            "chosen": after.mean(),
            "at random": at_random.mean(),
            "chosen over random": after.mean() / at_random.mean(),
            "best": share.min(axis=1).mean(),
            "best was chosen": (choice == share.idxmin(axis=1)).mean(),
        }
    return pd.DataFrame(table).T.rename_axis("target")


def markdown(table: pd.DataFrame) -> str:
    """Return a table as the page has it."""
    head = [table.index.name, *table.columns]
    lines = [
        head,
        ["---"] * len(head),
        *([n, *(f"{v:.2f}" for v in r)] for n, *r in table.itertuples()),
    ]
    return "\n".join(f"| {' | '.join(map(str, line))} |" for line in lines)


def read(file: Path) -> dict[str, pd.DataFrame]:
    """Return the tables that were written."""
    whole = pd.read_csv(file)
    found = {}
    for title, part in whole.groupby("table", sort=False):
        index = part["index"].iloc[0]
        table = part.pivot(index="row", columns="column", values="value")
        order = part["row"].unique(), part["column"].unique()
        found[title] = table.loc[order[0], order[1]].rename_axis(index).rename_axis(None, axis=1)
    return found


def write(tables: Mapping[str, pd.DataFrame], file: Path) -> None:
    """Write tables as rows of table, row, column and value."""
    parts = [
        (title, table.index.name, row, column, f"{value:.4f}")
        for title, table in tables.items()
        for row, values in table.iterrows()
        for column, value in values.items()
    ]
    pd.DataFrame(parts, columns=["table", "index", "row", "column", "value"]).to_csv(
        file, index=False
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--drives", type=int, default=60)
    parser.add_argument("--first", type=int, default=0, help="number of the first drive")
    parser.add_argument("--tests", nargs="+", default=[], help="these alone")
    parser.add_argument("--rows", type=Path, default=Path("next_test.csv"))
    parser.add_argument("--table", type=Path, metavar="CSV", help="write the tables there")
    options = parser.parse_args()
    config = at_one_cost(load([DEFAULTS]), options.tests)
    family = Family(Prior.from_settings(config["prior"]), config["family"])
    new = not options.rows.exists()
    with options.rows.open("a", newline="") as file:
        table = csv.writer(file)
        if new:
            table.writerow(COLUMNS)
        for number in range(options.first, options.first + options.drives):
            for row in rows_of(number, config, family):
                table.writerow([*row[:4], *(f"{each:.6g}" for each in row[4:])])
            file.flush()
    rows = pd.read_csv(options.rows)
    tables = tables_of(rows)
    print(f"{rows['drive'].nunique()} drives")
    for title, table in tables.items():
        print(f"\n{title}\n\n{markdown(table)}")
    if options.table:
        write(tables, options.table)


if __name__ == "__main__":
    main()
