"""Whether levels and changes drawn jointly, and scatter common to both motions, would gain.

    python -m studies.joint_draws joint.csv docs/joint_draws.csv   # six minutes of a core

A limit ``of: model`` multiplies draws of the level as new by independent draws of the change. Other
ways to the worn drive are scored at the end of lives of ``studies.lives`` (development seed):

- pairs: draws weighed by the network of levels on the worn curves, over its prior, as a Gaussian;
- ranks: the changes in the order of how that network moves a draw from new to worn;
- worn: that network's draws alone;
- exact: the true change at each draw of the level, which no way to draw can have.

The tracker takes both motions of an operation as independent. Here they are followed with the
correlation of their scatter as well, of the new records (``as new``), and of all (``hindsight``).
Both motions' coordinates are turned so that they are independent again.
"""

import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from unittest.mock import patch

import numpy as np
import pandas as pd
from scipy.interpolate import PchipInterpolator
from scipy.linalg import eigh
from tqdm import tqdm

from breaker.configuration.loading import load
from breaker.drive.family.network_files import shipped_networks
from breaker.drive.family.network_inputs import NormalisedRecords
from breaker.drive.life import path_fit
from breaker.drive.life.path import Block
from breaker.drive.life.path import Path as Followed
from breaker.drive.life.readout import Readout
from breaker.drive.life.tracker import Tracker
from breaker.mechanism.evaluation import evaluate
from breaker.mechanism.prior import Prior
from breaker.quantities.parameters import NAMES
from breaker.reading.records.normalised_shape import SHAPE_STEP, SHAPE_TIMES, shape_of
from breaker.shipped import DEFAULTS
from studies.lives import EVERY, INTERVAL, LIFE, SEEDS, Life, _at, simulated
from studies.shared import append, write_table

TODAY = {"level": "independent", "quantity": "independent", "change": "apart"}
LIVES, SOME, DRAWS = 12, ("family", "foreign", "faults"), 1000
OF_MODEL = {"closing": ("travel_time", "touch_time"), "opening": ("travel_time", "part_time")}
FINE = 10  # points in a step of the grid
LEADING = 12  # coordinates of a motion whose scatter may be common
KNOWN, CLOSEST = 20, 0.95  # records that none in common counts for; largest correlation
SHIFTED = 7  # records, by which motions are shifted for their scatter to be common by chance alone


def drawn(readout: Readout, path: Followed, ratio: np.ndarray, prior: Prior) -> Mapping:
    """Draws of the parameters at the end of a life by each way, ``(d, p)``."""
    end = path.change[-1:], path.variance[-1:]
    new, change = readout.curves(*end)
    worn = {m: in_own_units(each, change[m]) for m, each in new.items()}
    rng = np.random.default_rng(readout.seed)
    seen = readout.levels.draw(worn, readout.draws, rng).theta
    factors = 1.0 + readout.parameters(*end)[0] / 100.0
    apart, by_rank = readout.theta * factors, np.empty_like(factors)
    places = np.argsort(seen / readout.theta, axis=0, kind="stable")
    np.put_along_axis(by_rank, places, np.sort(factors, axis=0), axis=0)
    usual = np.log(prior.sample(4000, rng))
    told = density(np.log(apart), np.log(seen)) - density(np.log(apart), usual)
    share = np.exp(told - told.max())
    pairs = apart[rng.choice(len(apart), len(apart), p=share / share.sum())]
    found = {"independent": apart, "pairs": pairs, "ranks": readout.theta * by_rank}
    return found | {"worn": seen, "exact": readout.theta * ratio}


def in_own_units(new: NormalisedRecords, change: NormalisedRecords) -> NormalisedRecords:
    """The worn curve in its own stroke and duration, as networks of levels see it, ``(1, g)``."""
    curve = PchipInterpolator(SHAPE_TIMES, new.way[0] + change.way[0])
    fine = np.arange(SHAPE_TIMES[0], SHAPE_TIMES[-1], SHAPE_STEP / FINE)
    own = shape_of(curve(fine), SHAPE_STEP / FINE)
    times = np.clip(SHAPE_TIMES * own.duration + own.origin + fine[0], fine[0], fine[-1])
    return new._replace(
        way=((curve(times) - own.rest) / own.stroke)[None],
        stroke=new.stroke * own.stroke,
        duration=new.duration * own.duration,
        noise=np.hypot(new.noise, change.noise) / own.stroke,
    )


def density(x: np.ndarray, draws: np.ndarray) -> np.ndarray:
    """Log density ``(n,)`` at ``(n, p)`` of a Gaussian like draws ``(d, p)``, but for its norm."""
    off, cov = x - draws.mean(axis=0), np.cov(draws.T)
    return -0.5 * (off * np.linalg.solve(cov, off.T).T).sum(axis=1)


def common(motions: Sequence[np.ndarray]) -> np.ndarray:
    """Correlation of the scatter of two motions' coordinates, over differences of neighbours."""
    k, sizes = LEADING, [each.shape[1] for each in motions]
    both = [np.diff(each[:, :k], axis=0) for each in motions]
    square = sum(np.square(each).sum(axis=1) for each in both)
    one, two = (each[square < 4.0 * np.median(square)] for each in both)
    shares = len(one) / (len(one) + KNOWN) / np.outer(*(each.std(axis=0) for each in (one, two)))
    across = one.T @ two / len(one) * shares
    across *= min(1.0, CLOSEST / np.linalg.norm(across, 2))
    found = np.eye(sum(sizes))
    found[:k, sizes[0] : sizes[0] + k] = across
    found[sizes[0] : sizes[0] + k, :k] = across.T
    return found


def largest(scatter: np.ndarray) -> float:
    """Largest correlation of one motion's scatter with the other's."""
    return float(np.linalg.eigvalsh(scatter)[-1] - 1.0)


def together(
    tracker: Tracker, readout: Readout, blocks: list[Block], scatter: np.ndarray
) -> Followed:
    """Follow both motions with the correlation of their scatter; in their own coordinates."""
    n, series = len(scatter), readout.series
    family = np.concatenate([each.variance for each in blocks[:2]])
    variance, forward = (each[..., ::-1] for each in eigh(np.diag(family), scatter))
    turned = Block(np.hstack([each.values for each in blocks[:2]]) @ forward, variance)
    with patch.object(path_fit, "_LEADING", 2 * LEADING):
        path = tracker.follow(series.operations, [turned, *blocks[2:]], new=series.new)
    back = np.linalg.inv(forward)
    change = np.hstack([path.change[:, :n] @ back, path.change[:, n:]])
    spread = np.hstack([path.variance[:, :n] @ np.square(back), path.variance[:, n:]])
    return Followed(**{**vars(path), "change": change, "variance": spread})


def rows_of(name: str, number: int, config: Mapping, networks: list) -> list[dict]:
    """Rows of one life."""
    life, series, truth, _ = simulated("lives", name, number, SEEDS["develop"], config)
    asked = {"draws": DRAWS, "seed": SEEDS["develop"], "misfit_p_value": 0.001}
    readout = Readout.of(series, networks, **asked)
    blocks = readout.coordinates.blocks(series)
    tracker = Tracker.from_settings(config["wear_model"])
    paths = {"apart": tracker.follow(series.operations, blocks, new=series.new)}
    scatter = {"apart": {}}
    for way, last in (("as new", series.new[-1] + 1), ("hindsight", len(series.operations))):
        one, two = (each.values[:last] for each in blocks[:2])
        found = common([one, two])
        paths[way] = together(tracker, readout, blocks, found)
        chance = common([one, np.roll(two, SHIFTED, axis=0)])
        scatter[way] = {"common": largest(found), "chance": largest(chance)}
    theta = truth[list(NAMES)]
    new = np.mean([_at(theta, each) for each in series.operations[series.new]], axis=0)
    worn = _at(theta, series.operations[-1])
    rows, prior = [], Prior.from_settings(config["prior"])
    for way, draws in drawn(readout, paths["apart"], worn / new, prior).items():
        rows += interval_rows("level", way, NAMES, draws, worn)
        for motion, names in OF_MODEL.items():
            told, true = (evaluate(names, each, motion) for each in (draws, worn[None]))
            rows += interval_rows("quantity", way, [f"{n} {motion}" for n in names], told, true[0])
    for way, path in paths.items():
        told = readout.parameters(path.change[-1:], path.variance[-1:])[0]
        rows += interval_rows("change", way, NAMES, told, 100.0 * (worn / new - 1.0))
        found = noticed(life, path, series.operations)
        rows.append({"score": "noticed", "way": way} | found | scatter[way])
    return [{"set": name, "life": number} | each for each in rows]


def interval_rows(score: str, way: str, names, draws: np.ndarray, truth: np.ndarray) -> list[dict]:
    """Intervals of draws ``(d, k)`` beside true values ``(k,)``."""
    ends = np.quantile(draws, [0.05, 0.5, 0.95], axis=0).T
    about = {"score": score, "way": way}
    return [
        about | {"name": name, "truth": true} | dict(zip(INTERVAL, each, strict=True))
        for name, true, each in zip(names, truth, ends, strict=True)
    ]


def noticed(life: Life, path: Followed, operations: np.ndarray) -> dict:
    """How many records late a change was noticed, and how many false ones were."""
    true = life.fault[0] if life.fault[1] else life.knee if life.knee < LIFE else np.inf
    when = np.array([operations[change.noticed] for change in path.changes], dtype=float)
    late = when[when > true] - true
    late = late.min() / EVERY if late.size else np.nan
    return {"truth": true, "late": late, "false": int((when <= true).sum())}


def summed(rows: pd.DataFrame) -> pd.DataFrame:
    """Sum up, by what is told and the way: how often intervals hold, and changes found."""
    slack = 0.05 * (rows.score == "change")  # percent, for what has not changed at all
    holds = (rows.low - slack <= rows.truth) & (rows.truth <= rows.high + slack)
    rows, found = rows.assign(holds=holds, width=rows.high - rows.low), []
    for score, way in rows[rows.name.notna()][["score", "way"]].drop_duplicates().values:
        each = rows[(rows.score == score) & (rows.way == way)]
        today = rows[(rows.score == score) & (rows.way == TODAY[score])]
        both = each.merge(today[today.width > 0.0], on=["set", "life", "name"])
        row = {"told": score, "way": way, "intervals": len(each), "90 % hold": each.holds.mean()}
        row["width beside today's"] = (both.width_x / both.width_y).median()
        seen = rows[(rows.score == "noticed") & (rows.way == way)]
        if len(seen):
            for what, some in (("rates", seen.set != "faults"), ("faults", seen.set == "faults")):
                there = seen[some & np.isfinite(seen.truth)]
                row |= {f"{what} found": there.late.notna().mean(), f"of {what}": len(there)}
                row[f"{what}, records late"] = there.late.median()
            row["false changes"] = int(seen.false.sum())
            row |= {"largest correlation": seen.common.median(), "by chance": seen.chance.median()}
        found.append(row)
    return pd.DataFrame(found).sort_values("told", kind="stable")


def main(rows: str, table: str) -> None:
    config, networks = load([DEFAULTS]), [*shipped_networks()]
    done = set()
    if Path(rows).exists():
        done = set(pd.read_csv(rows)[["set", "life"]].itertuples(index=False, name=None))
    columns = ["set", "life", "score", "way", "name", "truth", *INTERVAL]
    columns += ["late", "false", "common", "chance"]
    for name in SOME:
        for number in tqdm(range(LIVES), desc=name, mininterval=10):
            if (name, number) not in done:
                each = pd.DataFrame(rows_of(name, number, config, networks))
                append(each.reindex(columns=columns), rows)
    found = summed(pd.read_csv(rows))
    found.to_csv(table, index=False, float_format="%.3g")
    lines = [f"| {' | '.join(found)} |", "|---|" + "---|" * (len(found.columns) - 1)]
    for row in pd.read_csv(table, dtype=str).fillna("").itertuples(index=False):
        lines.append(f"| {' | '.join(row)} |")
    write_table("decisions", "joint_draws", lines, study="joint_draws")


if __name__ == "__main__":
    main(*sys.argv[1:])
