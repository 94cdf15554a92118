"""Breakers of a type whose medians and spread are known, and their records."""

import numpy as np

from breaker.family.curve_file import write_curve
from breaker.family.drive_family import Family
from breaker.model.parameters import MOTIONS, Size
from breaker.model.prior import Prior

SHARE = 0.5  # spread between breakers, in log-sds of the default prior
NAMED = "file,motion,operation,breaker\n"


def type_of(prior, rng, off=0.7):
    """Prior of a type: medians that a draw of the default prior has, less spread."""
    while True:
        medians = prior.medians * np.exp(off * prior.log_sds * rng.standard_normal(7))
        drawn = Prior(medians, SHARE * prior.log_sds)
        if drawn.log_support > np.log(0.95):
            return drawn


def breakers_of(drawn, rigs, count, rng):
    """Drives of a type, each with what the model lacks on top."""
    family = Family(drawn, rigs)
    return [family.new(rng) for _ in range(count)]


def write_breakers(folder, drives, count, rng, size=None, motions=MOTIONS, head=NAMED):
    """Write files of breakers Q0, Q1 ... with their table."""
    size = size or Size()
    folder.mkdir(parents=True, exist_ok=True)
    time, lines = np.arange(0.0, 72.0 * size.times, 0.1 * size.times), []
    for number, drive in enumerate(drives):
        for motion in motions:
            for operation in range(1, count + 1):
                begins = size.times * (10.0 + 0.3 * rng.standard_normal())
                curve = drive.scaled(size).travel(motion, time - begins)
                curve += 0.1 * size.lengths * rng.standard_normal(time.size)
                file = folder / f"{motion}_{number}_{operation}.csv"
                write_curve(file, time, curve, motion=motion, operation=operation)
                line = f"{file.name},{motion},{operation + 100 * number}"
                lines.append(f"{line},Q{number}" if head == NAMED else line)
    table = head + "\n".join(lines) + "\n"
    (folder / "operations.csv").write_text(table, encoding="utf-8")
    return folder
