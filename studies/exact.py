"""Is the exact posterior in the family calibrated, and how far are the networks from it?

    python -m studies.exact --rows exact.csv --drives 40       # a minute of two cores each
    python -m studies.exact --rows exact.csv --drives 20 --of 'other code'
    python -m studies.exact --rows exact.csv --table docs/exact.csv --drives 0

Drives of the family that no training has seen, each with a record of one motion, closing and
opening in turn, as a file that is read as a user's is; the size is not given. `infer --exact`
answers. Where the posterior is exact, 90 % of its 90 % intervals hold, ranks of the truth are flat,
and no other answer has a higher log density at the truth on average. Of both answers the density is
that of a normal distribution in the logarithms of the parameters. Other drives have both motions of
an operation recorded (`--of 'both motions'`). Drives of other code (`studies.other_code`) are none
of the family: there the exact posterior is exact for a family that is wrong.
"""

import argparse
import os
import time
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")  # as the command line does

import numpy as np
import pandas as pd
from scipy.stats import kstest, multivariate_normal

from breaker.common.randomness import generator
from breaker.configuration.loading import load
from breaker.drive.answers.assessment import Assessment
from breaker.drive.exact.exact_posterior import ENOUGH, exactly
from breaker.drive.simulation.drive_family import Family
from breaker.mechanism.prior import Prior
from breaker.quantities.parameters import MOTIONS, NAMES
from breaker.shipped import DEFAULTS
from studies.next_test import Bench
from studies.other_code import Other
from studies.shared import append, write_table

DRAWS = 2000  # of an answer
ENDS = (0.05, 0.95)
OWN, BOTH, OTHER = "the family", "both motions", "other code"
ELSEWHERE = "the family, answered by another"
SURPRISING = 0.01  # p-value


class Strange(Other):
    """A drive of other code on a bench."""

    def travel(self, motion: str, times: np.ndarray) -> np.ndarray:
        return super().travel(motion, times)[0]


def scored(of: str, number: int, config: dict) -> dict:
    """A row of one drive."""
    prior, told = Prior.from_settings(config["prior"]), () if of == OWN else (of,)
    rng = generator(config["seed"], "exact posterior, held out", *told, number)
    motion, contact = MOTIONS[number % len(MOTIONS)], None
    if of == OTHER:
        drive = Strange.drawn(prior, rng)
    else:
        drive = Family(prior, config["family"]).new(rng)
        contact = drive.elements.contact
    bench = Bench(drive, motion, config, rng)
    records = bench.records(dict.fromkeys(MOTIONS, 1)) if of == BOTH else [bench.record]
    assessment = Assessment(config)
    networks = assessment.infer(records)
    network = networks[0]
    row = {"of": of, "drive": number, "motion": motion, "contact": contact}
    if network.levels is None or network.misfit:
        return row | {"told": False}
    if of != OTHER and network.levels.settings["family"] != config["family"]["name"]:
        row["of"] = ELSEWHERE
    begin = np.array([time.monotonic(), time.process_time()])
    exact = exactly(networks, assessment.given, assessment.settings)[0]
    taken = np.array([time.monotonic(), time.process_time()]) - begin
    row |= {"seconds": taken[0], "processor": taken[1], "told": exact.draws is not None}
    if (found := exact.exact) is None:
        return row | {"told": False}
    row |= {n: getattr(found, n) for n in ("effective_size", "drives", "gap", "p_value")}
    row["right_contact"] = found.contacts.get(contact, np.nan)
    true = np.log(drive.theta)
    for by, answer in (("exact", exact), ("network", network)):
        if answer.draws is None:
            continue
        draws = np.log(answer.draws.theta)
        normal = multivariate_normal(draws.mean(axis=0), np.cov(draws.T))
        row[f"{by} log density"] = normal.logpdf(true)
        for name, each, value in zip(NAMES, draws.T, true, strict=True):
            row[f"{by} rank {name}"] = float((each < value).mean())
            row[f"{by} sd {name}"] = each.std()
    return row


def table(rows: pd.DataFrame) -> pd.DataFrame:
    """Sum rows up: of drives that their own family answers by one motion, closing, opening and
    either, or by both; and of others.
    """
    own = rows[rows.of == OWN]
    groups = {motion: own[own.motion == motion] for motion in MOTIONS}
    groups |= {"either": own} | {of: rows[rows.of == of] for of in (BOTH, OTHER)}
    found = {name: summed(some) for name, some in groups.items() if len(some)}
    return pd.DataFrame({name: pd.Series(each) for name, each in found.items()})


def summed(some: pd.DataFrame) -> dict[str, float]:
    """Scores of some records."""
    told = some[some.told]
    found = {
        "records": len(some),
        "resolved": len(told) / len(some),
        f"effective size at least {ENOUGH:.0f}": (some.effective_size >= ENOUGH).mean(),
        "effective size, median": some.effective_size.median(),
        "seconds of processors, median": some.processor.median(),
        "simulated drives, median": some.drives.median(),
        "network off, nats, median": some.gap.median(),
        f"p-value of the record below {SURPRISING}": (told.p_value < SURPRISING).mean(),
        "probability of the true contact, mean": told.right_contact.mean(),
    }
    for by in ("exact", "network"):
        ranks = told[[f"{by} rank {name}" for name in NAMES]].to_numpy()
        within = (ranks > ENDS[0]) & (ranks < ENDS[1])
        found[f"{by}: 90 % intervals hold"] = np.nanmean(within)
        found[f"{by}: smallest p of flat ranks"] = min(
            kstest(each[np.isfinite(each)], "uniform").pvalue for each in ranks.T
        )
    both = told.dropna(subset=["exact log density", "network log density"])
    gain = both["exact log density"] - both["network log density"]
    found["gain in log density at the truth, nats"] = gain.mean()
    found["standard error of the gain"] = gain.std() / np.sqrt(len(gain))
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--rows", type=Path, required=True, help="a table to which rows are added")
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--drives", type=int, default=40)
    parser.add_argument("--of", choices=[OWN, BOTH, OTHER], default=OWN)
    parser.add_argument("--table", type=Path)
    options = parser.parse_args()
    config = load([DEFAULTS])
    config["endurance"]["draws"] = DRAWS
    for number in range(options.first, options.first + options.drives):
        row = scored(options.of, number, config)
        append(pd.DataFrame([row]).reindex(columns=COLUMNS), options.rows)
        size = row.get("effective_size", np.nan)
        print(f"{number} {row['motion']}: effective size {size:.0f}", flush=True)
    if options.table:
        found = table(pd.read_csv(options.rows)).map(lambda each: f"{each:.3g}")
        found.to_csv(options.table, index_label="score")
        lines = [f"| | {' | '.join(found)} |", "|---|" + "---|" * found.shape[1]]
        lines += [f"| {score} | {' | '.join(row)} |" for score, *row in found.itertuples()]
        write_table(
            "evidence", options.table.stem, [line.replace("nan", "") for line in lines], "exact"
        )


COLUMNS = [
    *("of", "drive", "motion", "contact", "seconds", "processor", "told", "effective_size"),
    *("drives", "gap", "p_value", "right_contact", "exact log density", "network log density"),
    *(f"{by} {what} {n}" for by in ("exact", "network") for what in ("rank", "sd") for n in NAMES),
]


if __name__ == "__main__":
    main()
