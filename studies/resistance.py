"""Length of the arcing contact against the times that its resistance shows.

``python -m studies.resistance FILE`` reads openings of contacts of known length, finds when the
main and the arcing contact separate, and prints a table. FILE is a CSV with
the columns remaining_length_mm, time_ms and resistance_mohm; source and licence are in the page.
"""

import argparse
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pandas as pd
from scipy.stats import chi2

from breaker.records.contacts import FEWEST, LEAST, ContactTimes, times_of
from breaker.records.rejections import NotShownError

_COLUMNS = ["remaining_length_mm", "time_ms", "resistance_mohm"]
_CLOSED = 0.05  # share of a record in which the contact rests closed
_INTERVAL = 0.05, 0.95  # of the residual sd: a 90 % interval


def read(file: Path) -> dict[float, tuple[np.ndarray, np.ndarray]]:
    """Read times and resistances of every opening, by the length of its contact.

    Raises:
        ValueError: If a column is missing or a cell is not a number.
    """
    rows = pd.read_csv(file, usecols=_COLUMNS, dtype=float)
    openings = rows.groupby(_COLUMNS[0])
    return {length: tuple(own[_COLUMNS[1:]].values.T) for length, own in openings}


def separations(time: np.ndarray, resistance: np.ndarray) -> ContactTimes:
    """Find the separations of the main and of the arcing contact in an opening without a current.

    Args:
        time: Times, ``(n,)``, ms, evenly spaced, from the closed contact on.
        resistance: Of the contact, ``(n,)``, milliohm; nan where a sample is missing.

    Returns:
        Times whose ``main`` and ``arcing`` are nan, and ``why`` the reason, where not seen.
    """
    there = ~np.isnan(resistance)
    first, last = np.quantile(time[there], _CLOSED), time[there][-FEWEST]
    ends = resistance[there][-FEWEST:]
    if ends.min() < (1.0 - 0.1 * LEAST) * resistance[there].max():  # a rise that is cut goes on
        return ContactTimes(why="the arcing contact does not separate within the record")
    try:
        sides = time <= first, time >= last
        return times_of(time, resistance, None, True, sides, False, -np.inf)
    except NotShownError as error:
        return ContactTimes(why=str(error))


def fit(lengths: np.ndarray, between: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Fit a line of lengths ``(n,)``, mm, against the times between both separations, ms.

    Returns:
        Its slope, mm/ms, and length at 0, ``(2,)``; residuals, ``(n,)``, mm; residual standard
        deviation with its 90 % interval, ``(3,)``, mm.
    """
    line = np.polyfit(between, lengths, 1)
    residuals = lengths - np.polyval(line, between)
    free = lengths.size - line.size
    squares = float(residuals @ residuals)
    low, high = (float(np.sqrt(squares / chi2.ppf(1.0 - part, free))) for part in _INTERVAL)
    return line, residuals, np.array([np.sqrt(squares / free), low, high])


def table(result: Mapping[float, ContactTimes]) -> pd.DataFrame:
    """Return a row for each contact, whose line of best fit is in the attributes."""
    rows = pd.DataFrame(
        {
            "length, mm": [*result],
            "main, ms": [times.main for times in result.values()],
            "arcing, ms": [times.arcing for times in result.values()],
        }
    )
    between = rows["arcing, ms"] - rows["main, ms"]
    seen = between.notna()
    (slope, _), residuals, sd = fit(rows["length, mm"][seen].values, between[seen].values)
    rows.loc[seen, "residual, mm"] = residuals
    rows["not seen because"] = [times.why for times in result.values()]
    rows.attrs = {"n": int(seen.sum()), "slope, mm/ms": slope}
    rows.attrs |= dict(zip(("residual sd, mm", "from (90 %)", "to (90 %)"), sd, strict=True))
    return rows


def main() -> None:
    """Print the table of a file."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("file", type=Path, help="CSV of openings of contacts of known length")
    openings = read(parser.parse_args().file)
    rows = table({length: separations(*opening) for length, opening in openings.items()})
    print(rows.round(2).fillna("").to_string(index=False))
    print(*(f"{name}: {value:.3g}" for name, value in rows.attrs.items()), sep=", ")


if __name__ == "__main__":
    main()
