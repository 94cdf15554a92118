"""The tracker on the annotated series of the Turing Change Point Dataset.

    git clone https://github.com/alan-turing-institute/TCPD
    python -m studies.tcpd TCPD docs/tcpd.csv

After van den Burg and Williams (2020), "An evaluation of change point detection algorithms":
covering of the segments and F1 with a margin of 5, against all annotators. Those series that may be
redistributed; the tracker as it is shipped but for the size of changes, which no family tells here,
and the length of the reference, a tenth of a series. The second row is that of no change at all.
"""

import json
import sys
from collections.abc import Mapping, Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np
import pandas as pd

from breaker.drive.life.path import Block
from breaker.drive.life.tracker import Tracker

MARGIN, SIZE = 5, 0.3
SHARE, FEWEST = 10, 10  # reference: a tenth of a series, and at least so many


def series_in(file: Path) -> np.ndarray:
    """Values of a series, ``(o, k)``; missing ones are those before."""
    data = json.loads(file.read_text())
    columns = [
        np.array([np.nan if v is None else v for v in each["raw"]], dtype=float)
        for each in data["series"]
    ]
    return pd.DataFrame(np.column_stack(columns)).ffill().bfill().to_numpy()


def changes_in(values: np.ndarray) -> list[int]:
    """Indices after which the tracker sees a change."""
    n = len(values)
    reference = max(FEWEST, n // SHARE)
    noise = np.median(np.abs(np.diff(values, axis=0)), axis=0) / 0.6745 / np.sqrt(2.0)
    spread = values.std(axis=0)
    noise = np.maximum(np.where(noise > 0.0, noise, 0.05 * spread), 1e-3 * spread + 1e-12)
    scaled = (values - values[:reference].mean(axis=0)) / noise
    variance = np.square(spread / noise) + 1.0
    order = np.argsort(-variance)
    tracker = Tracker(reference=reference, settle=max(3, reference // 2), size=SIZE)
    path = tracker.follow(np.arange(n), [Block(scaled[:, order], variance[order])])
    return [change.start for change in path.changes if change.evidence >= 0.0]


def covering(annotations: Mapping[str, Sequence[int]], found: Sequence[int], n: int) -> float:
    """Mean over annotators of how well their segments are covered."""

    def segments(points: Sequence[int]) -> list[set[int]]:
        ends = [0, *sorted({p for p in points if 0 < p < n}), n]
        return [set(range(a, b)) for a, b in pairwise(ends)]

    mine = segments(found)
    each = []
    for points in annotations.values():
        true = segments(points)
        best = [max(len(a & b) / len(a | b) for b in mine) for a in true]
        each.append(sum(len(a) * share for a, share in zip(true, best, strict=True)) / n)
    return float(np.mean(each))


def f1(annotations: Mapping[str, Sequence[int]], found: Sequence[int]) -> float:
    """F1 by the union of annotators for precision, and their mean recall; 0 counts as a change."""

    def hits(true: set[int], some: set[int]) -> int:
        left, count = set(some), 0
        for point in sorted(true):
            near = [x for x in left if abs(x - point) <= MARGIN]
            if near:
                left.discard(min(near, key=lambda x: abs(x - point)))
                count += 1
        return count

    mine = {0, *found}
    every = {k: {0, *points} for k, points in annotations.items()}
    precision = hits(set().union(*every.values()), mine) / len(mine)
    recall = float(np.mean([hits(true, mine) / len(true) for true in every.values()]))
    return 2.0 * precision * recall / (precision + recall) if precision + recall else 0.0


def main(folder: str, table: str) -> None:
    """Score all series, and write the table."""
    annotated = json.loads((Path(folder) / "annotations.json").read_text())
    rows = []
    for file in sorted(Path(folder).glob("datasets/*/*.json")):
        values, name = series_in(file), file.stem
        if name not in annotated:
            continue
        found, n = changes_in(values), len(values)
        of = annotated[name]
        rows.append(
            {
                "series": name,
                "dimensions": values.shape[1],
                "length": n,
                "changes": len(found),
                "covering": covering(of, found, n),
                "f1": f1(of, found),
                "covering_none": covering(of, [], n),
                "f1_none": f1(of, []),
            }
        )
    frame = pd.DataFrame(rows)
    mean = frame.drop(columns="series").mean().to_dict() | {"series": "mean"}
    frame = pd.concat([frame, pd.DataFrame([mean])])[frame.columns]
    frame.to_csv(table, index=False, float_format="%.3g")
    print(frame.round(3).to_string())


if __name__ == "__main__":
    main(*sys.argv[1:])
