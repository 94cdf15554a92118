"""Exports in the layout of a breaker analyser: a preamble in pairs, no time column, 27 columns.

Six coil currents, six travels of which some are unused, six contacts, and nine others.
Curves are made up: smooth strokes with over-travel, damping and bounce at high-voltage size.
"""

import re
from pathlib import Path

import numpy as np

USUAL = {"rate": 10.0, "stroke": 178.0, "motions": ("closing",), "length": 400.0, "seed": 0}
USUAL |= {"noise": 0.1, "channels": 3, "trip": 30.0, "ratio": 1.0, "unused": "zeros"}
USUAL |= {"zero": 0.0}  # where the open breaker rests
STATED = {"date": "14/03/2021", "clock": "10:42:17", "serial": "HV-20417", "bay": "Bay 4"}
STATED |= {"results": {}, "plot": None}


def way(time, begin, duration, *, over=0.06):
    """Share of the stroke (0 to 1) at times, ms: a smooth rise, over-travel, a damped return."""
    u = np.clip((time - begin) / duration, 0, None)
    rise = np.where(u < 1, u**2 * (3 - 2 * u), 1.0)
    after = np.clip(u - 0.93, 0, None)
    swing = over * np.sin(2 * np.pi * after / 0.9) * np.exp(-after / 0.45)
    return rise + swing


def record(**given):
    """Columns of an export by name, of 27."""
    of = {**USUAL, **given}
    rng, channels, motions = np.random.default_rng(of["seed"]), of["channels"], of["motions"]
    t = np.arange(round(of["length"] * of["rate"])) / of["rate"]
    starts = of["trip"] + 150.0 * np.arange(len(motions))
    coils, travels, contacts, resistances = {}, {}, {}, {}
    for i in range(6):
        current = 0.02 * rng.normal(size=t.size)
        for on in starts if i < channels else ():
            rise = 1 - np.exp(-np.clip(t - on, 0, None) / 6.0)
            current += 4.0 * rise * ((t > on) & (t < on + 60))
        coils[f"Coil {i + 1} (A)"] = np.round(current, 3)
    exact = []
    for i in range(6):
        if i < channels:
            y = np.full(t.size, float(motions[0] != "closing"))
            for m, on in zip(motions, starts, strict=True):
                sign, duration = (1, 62.0) if m == "closing" else (-1, 38.0)
                y += sign * way(t, on + 25.0 + 0.4 * i, duration)
            exact.append(of["stroke"] * (1 + 0.002 * i) * y * of["ratio"])
            reading = exact[i] + of["zero"] + of["noise"] * rng.normal(size=t.size)
        elif of["unused"] == "zeros":
            reading = np.zeros(t.size)
        else:
            reading = 0.08 * exact[i - channels] + of["noise"] * rng.normal(size=t.size)
        travels[f"Travel {i + 1} (mm)"] = np.round(reading, 2)
    for i in range(6):  # main contacts, 1 closed
        used = i < channels
        closed = exact[i] > 0.45 * of["stroke"] * of["ratio"] if used else np.zeros(t.size, bool)
        contacts[f"Contact {i + 1}"] = closed.astype(int)
        ohms = np.round(45 + rng.normal(size=t.size), 1) if used else np.nan
        resistances[f"Res {i + 1} (uOhm)"] = np.where(closed | (not used), ohms, 8000.0)
    return coils | travels | contacts | resistances | {f"Aux {i}": np.nan * t for i in (1, 2, 3)}


def preamble(**given):
    """Lines above the columns: what is stated in pairs, and the results that are printed."""
    of = {**USUAL, **STATED, **given}
    kind = "-".join(m[0].upper() for m in of["motions"])
    pairs = [
        [("Test Report", None)],
        [("Company :", "Utility"), ("Operator :", "A. Tester")],
        [("Station :", "North 400 kV"), ("Bay :", of["bay"])],
        [("CB Make :", "Maker"), ("CB Type :", "LTB 420")],
        [("Serial No :", of["serial"]), ("Rated Voltage (kV) :", "420")],
        [("Mechanism :", "Spring"), ("Year :", "2004")],
        [("Test Date :", of["date"]), ("Test Time :", of["clock"])],
        [("Test No :", "12"), ("Operation :", kind)],
        [("Sampling Speed (kC) :", f"{of['rate']:g}"), ("Resistance Range (uOhm) :", "8000")],
        [("Plot Length (ms) :", f"{of['plot'] or of['length']:g}"), ("Pre Trigger (ms) :", "30")],
        [("Linkage Ratio :", f"{of['ratio']:g}"), ("Transducer :", "Linear 225 mm")],
        [("Travel Unit :", "mm"), ("Velocity Unit :", "m/s")],
        [("Closing Velocity Point 1 (%) :", "40"), ("Closing Velocity Point 2 (%) :", "80")],
        [("Opening Velocity Point 1 (%) :", "20"), ("Opening Velocity Point 2 (%) :", "60")],
        [("Ambient Temp (C) :", "24"), ("SF6 Pressure (bar) :", "6.2")],
        [("Channel 1 :", "R"), ("Channel 2 :", "Y"), ("Channel 3 :", "B")],
    ]
    lines = [",".join(f"{a},{b or ''},," for a, b in row) for row in pairs] + [",,,"]
    if of["results"]:
        channels = ",".join(f"CH{i + 1}" for i in range(of["channels"]))
        lines += ["Travel Analysis,,,", f"Parameter,{channels},,"]
    for name, values in of["results"].items():
        lines.append(name + "," + ",".join(f"{v:.2f}" for v in values) + ",,")
    return lines + [",,,"] * (43 - len(lines))


def write(path, **given):
    """Write an export, with what is given in place of the usual."""
    columns = record(**{key: given[key] for key in USUAL if key in given})
    rows = np.stack([*columns.values()], axis=1)
    cells = [",".join("" if np.isnan(v) else f"{v:g}" for v in row) + "," for row in rows]
    lines = [*preamble(**given), ",".join(columns) + ",", *cells]
    Path(path).write_text("\n".join(lines) + "\n", encoding="latin-1")


def pole(name, phase, seed, clock="10:42:17", **more):
    """Write a file of one pole, whose phase stands above its samples if it is given."""
    write(name, rate=5.0, seed=seed, channels=1, motions=("closing",), clock=clock, **more)
    text = Path(name).read_text(encoding="latin-1")
    for k in (2, 3):
        text = re.sub(rf"Channel {k} :,\w,*", "", text)
    text = text.replace("Channel 1 :,R", f"Channel 1 :,{phase}" if phase else "Remark :,NIL")
    Path(name).write_text(text, encoding="latin-1")
