"""Exports in the layout of a breaker analyser: a preamble in pairs, no time column, 27 columns.

Six coil currents, six travels of which some are unused, six contacts, and nine others.
Curves are made up: smooth strokes with over-travel, damping and bounce at high-voltage size.
"""

from pathlib import Path

import numpy as np


def way(time, begin, duration, *, over=0.06):
    """Share of the stroke (0 to 1) at times, ms: a smooth rise, over-travel, a damped return."""
    u = np.clip((time - begin) / duration, 0, None)
    rise = np.where(u < 1, u**2 * (3 - 2 * u), 1.0)
    after = np.clip(u - 0.93, 0, None)
    swing = over * np.sin(2 * np.pi * after / 0.9) * np.exp(-after / 0.45)
    return rise + swing


def record(
    rate=10.0,
    stroke=178.0,
    *,
    motions=("closing",),
    length=400.0,
    seed=0,
    noise=0.1,
    channels=3,
    trip=30.0,
    ratio=1.0,
    unused="zeros",
):
    """Columns of an export: names and values ``(n, 27)``."""
    rng = np.random.default_rng(seed)
    t = np.arange(round(length * rate)) / rate
    columns = {}
    begins = [trip + 25.0 + 150.0 * k for k in range(len(motions))]
    for i in range(6):  # coil currents
        pulse = np.zeros_like(t)
        if i < channels:
            for k in range(len(motions)):
                on = trip + 150.0 * k
                pulse += (
                    4.0 * (1 - np.exp(-np.clip(t - on, 0, None) / 6.0)) * (t > on) * (t < on + 60)
                )
        columns[f"Coil {i + 1} (A)"] = np.round(pulse + 0.02 * rng.normal(size=t.size), 3)
    travels = []
    for i in range(6):
        if i < channels:
            position = 0.0 if motions[0] == "closing" else 1.0
            y = np.full_like(t, position)
            for m, begin in zip(motions, begins, strict=True):
                s = way(t, begin + 0.4 * i, 62.0 if m == "closing" else 38.0)
                y += s if m == "closing" else -s
            mm = stroke * (1 + 0.002 * i) * y * ratio
            travels.append(mm)
            columns[f"Travel {i + 1} (mm)"] = np.round(mm + noise * rng.normal(size=t.size), 2)
        elif unused == "zeros":
            columns[f"Travel {i + 1} (mm)"] = np.zeros_like(t)
        else:
            columns[f"Travel {i + 1} (mm)"] = np.round(
                0.08 * travels[i - channels] + noise * rng.normal(size=t.size), 2
            )
    for i in range(6):  # main contacts, 1 closed
        closed = np.zeros_like(t)
        if i < channels:
            closed = (travels[i] > 0.45 * stroke * ratio).astype(float)
        columns[f"Contact {i + 1}"] = closed.astype(int)
    for i in range(6):
        closed = columns[f"Contact {i + 1}"]
        columns[f"Res {i + 1} (uOhm)"] = (
            np.where(closed > 0, np.round(45 + rng.normal(size=t.size), 1), 8000.0)
            if i < channels
            else np.full_like(t, np.nan)
        )
    for i in range(3):
        columns[f"Aux {i + 1}"] = np.full_like(t, np.nan)
    return t, columns


def preamble(
    rate=10.0,
    length=400.0,
    ratio=1.0,
    *,
    date="14/03/2021",
    clock="10:42:17",
    serial="HV-20417",
    bay="Bay 4",
    motions=("closing",),
    results=None,
    channels=3,
    plot=None,
):
    kind = "".join(m[0].upper() for m in motions)
    kind = "-".join(kind)
    pairs = [
        [("Test Report", None)],
        [("Company :", "Utility"), ("Operator :", "A. Tester")],
        [("Station :", "North 400 kV"), ("Bay :", bay)],
        [("CB Make :", "Maker"), ("CB Type :", "LTB 420")],
        [("Serial No :", serial), ("Rated Voltage (kV) :", "420")],
        [("Mechanism :", "Spring"), ("Year :", "2004")],
        [("Test Date :", date), ("Test Time :", clock)],
        [("Test No :", "12"), ("Operation :", kind)],
        [("Sampling Speed (kC) :", f"{rate:g}"), ("Resistance Range (uOhm) :", "8000")],
        [("Plot Length (ms) :", f"{plot or length:g}"), ("Pre Trigger (ms) :", "30")],
        [("Linkage Ratio :", f"{ratio:g}"), ("Transducer :", "Linear 225 mm")],
        [("Travel Unit :", "mm"), ("Velocity Unit :", "m/s")],
        [("Closing Velocity Point 1 (%) :", "40"), ("Closing Velocity Point 2 (%) :", "80")],
        [("Opening Velocity Point 1 (%) :", "20"), ("Opening Velocity Point 2 (%) :", "60")],
        [("Ambient Temp (C) :", "24"), ("SF6 Pressure (bar) :", "6.2")],
        [("Channel 1 :", "R"), ("Channel 2 :", "Y"), ("Channel 3 :", "B")],
    ]
    lines = [
        ",".join(f"{a},{b},," if b is not None else f"{a},,," for a, b in row) for row in pairs
    ]
    lines.append(",,,")
    if results:
        lines.append("Travel Analysis,,,")
        lines.append("Parameter," + ",".join(f"CH{i + 1}" for i in range(channels)) + ",,")
        for name, values in results.items():
            lines.append(name + "," + ",".join(f"{v:.2f}" for v in values) + ",,")
    while len(lines) < 43:
        lines.append(",,,")
    return lines


def write(path, **given):
    keys = (
        "rate",
        "stroke",
        "motions",
        "length",
        "seed",
        "noise",
        "channels",
        "trip",
        "ratio",
        "unused",
    )
    _, columns = record(**{k: given[k] for k in keys if k in given})
    lines = preamble(
        **{
            k: v
            for k, v in given.items()
            if k
            in (
                "rate",
                "length",
                "ratio",
                "date",
                "clock",
                "serial",
                "bay",
                "motions",
                "results",
                "channels",
                "plot",
            )
        }
    )
    lines.append(",".join(columns) + ",")
    table = np.stack([np.asarray(c, float) for c in columns.values()], axis=1)
    for row in table:
        lines.append(",".join("" if np.isnan(v) else f"{v:g}" for v in row) + ",")
    Path(path).write_text("\n".join(lines) + "\n", encoding="latin-1")
