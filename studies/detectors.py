"""Change detectors beside the tracker, at equal false alarms: how many changes they find, how late.

    studies/.venv/bin/python -m studies.detectors 60 docs/detectors.csv    # requirements.txt

What an engineer would watch: stroke and travel time of both motions, as they are measured. Wear
moves them all the time, so each detector gets what a line through all earlier records leaves of the
next one, in units of its scatter. EWMA; FOCuS for an unknown mean before and after (Romano et al.
2023), of changepoint-online; Page-Hinkley and ADWIN of river.
Thresholds of all, the tracker's among them, are the least with which one in fifty ``steady`` lives
has an alarm.
"""

import sys
from collections.abc import Callable

import numpy as np
import pandas as pd
from changepoint_online import Focus, Gaussian
from river import drift
from tqdm import tqdm

from breaker.configuration.loading import load
from breaker.drive.family.network_files import shipped_networks
from breaker.drive.life.readout import Readout
from breaker.drive.life.tracker import Tracker
from breaker.shipped import DEFAULTS
from studies.lives import EVERY, LIFE, SEEDS, Life, simulated

FALSE = 0.02  # share of lives with a false alarm
START = 100  # records before which no alarm counts
FIRST = 50  # records that the scatter is of


def left_of_line(values: np.ndarray) -> np.ndarray:
    """What a line through all earlier records leaves of the next one, in its scatter, ``(o,)``."""
    time, found = np.arange(values.size), np.zeros(values.size)
    there = np.isfinite(values)
    for i in range(FIRST, values.size):
        past = np.flatnonzero(there[:i])
        if there[i]:
            slope, level = np.polyfit(past, values[past], 1)
            found[i] = values[i] - level - slope * time[i]
    first = np.flatnonzero(there[: 2 * FIRST])
    apart = np.diff(values[first]) / np.sqrt(2.0)
    return found / np.median(np.abs(apart)) * 0.6745


def ewma(x: np.ndarray) -> np.ndarray:
    """Exponentially weighted mean of weight 0.1, in its sd."""
    found, mean = np.zeros(x.size), 0.0
    for i, each in enumerate(x):
        mean += 0.1 * (each - mean)
        found[i] = abs(mean) / np.sqrt(0.1 / 1.9)
    return found


def focus(x: np.ndarray) -> np.ndarray:
    """Largest likelihood ratio of a change of the mean, over all its times."""
    detector, found = Focus(Gaussian()), np.zeros(x.size)
    for i, each in enumerate(x):
        detector.update(each)
        found[i] = detector.statistic()
    return found


def of_river(make: Callable, scale: np.ndarray) -> Callable:
    """The finest of some sensitivities at which a detector of river has had an alarm, by record."""

    def statistic(x: np.ndarray) -> np.ndarray:
        found = np.zeros(x.size)
        for level, value in enumerate(scale, start=1):
            detector = make(value)
            for i, each in enumerate(x):
                detector.update(float(each))
                if i >= START and detector.drift_detected:
                    found[i:] = np.maximum(found[i:], level)
                    break
        return found

    return statistic


DETECTORS = {
    "EWMA": ewma,
    "FOCuS": focus,
    "Page-Hinkley": of_river(
        lambda h: drift.PageHinkley(min_instances=FIRST, delta=0.2, threshold=h, mode="both"),
        np.geomspace(2.0, 200.0, 25),
    ),
    "ADWIN": of_river(lambda d: drift.ADWIN(delta=d, clock=1), np.geomspace(0.5, 1e-9, 25)),
}


def statistics(name: str, number: int, config, networks) -> tuple[Life, dict[str, np.ndarray]]:
    """Statistics of all detectors over a life, by record."""
    life, series, _, _ = simulated("detectors", name, number, SEEDS["score"], config)
    columns = [left_of_line(v) for m in series.motions.values() for v in m.measured.values()]
    found = {key: np.max([of(x) for x in columns], axis=0) for key, of in DETECTORS.items()}
    readout = Readout.of(series, networks, draws=20, seed=1, misfit_p_value=0.0)
    tracker = Tracker.from_settings({**config["wear_model"], "threshold": np.inf})
    path = tracker.follow(series.operations, readout.coordinates.blocks(series))
    return life, found | {"tracker": np.nan_to_num(path.evidence, nan=-np.inf)}


def main(count: str, table: str) -> None:
    """Calibrate on steady lives, score on others, and write the table."""
    config = load([DEFAULTS])
    networks = [*shipped_networks()]

    def lives(name: str) -> list:
        numbers = tqdm(range(int(count)), desc=name, mininterval=10)
        return [statistics(name, k, config, networks) for k in numbers]

    steady = [found for _, found in lives("steady")]
    rows = []
    for name in ("family", "faults"):
        some = [each for each in lives(name) if each[0].fault[1] or each[0].knee < LIFE]
        for key in steady[0]:
            most = np.sort([each[key][START:].max() for each in steady])
            threshold = most[-1 - int(FALSE * len(most))]
            late = []
            for life, found in some:
                true = min(life.fault[0], life.knee) / EVERY
                seen = np.arange(LIFE // EVERY) >= START
                over = np.flatnonzero((found[key] > threshold) & seen)
                after, early = over[over + 1 > true], over.size and over[0] + 1 <= true
                late.append(after[0] + 1 - true if after.size and not early else np.nan)
            late = np.array(late)
            rows.append(
                {
                    "lives": name,
                    "detector": key,
                    "threshold": threshold,
                    "found": np.isfinite(late).mean(),
                    "within_3": (late <= 3.0).mean(),
                    "records_late": np.nanmedian(late),
                    "count": len(late),
                }
            )
    frame = pd.DataFrame(rows)
    frame.to_csv(table, index=False, float_format="%.3g")
    print(frame.round(3).to_string())


if __name__ == "__main__":
    main(*sys.argv[1:])
