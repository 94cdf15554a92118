"""Write random exports of breaker analysers with their truth, by a grammar of layouts."""

import csv
import io
import re
from datetime import datetime, timedelta
from pathlib import Path

import numpy as np

from studies.exports.contacts import (
    STEP,
    bounces_of,
    contact_times,
    draw_bounces,
    draw_meter,
    measured,
    reached,
    signal,
)

PHASES = ["R Y B", "A B C", "L1 L2 L3"]
PLANS = ["closing", "opening", "closing opening", "opening closing", "opening closing opening"]
RATES = [1, 2, 2.5, 4, 5, 8, 10, 12, 12.5, 16, 20, 25]  # kHz
# Words of plain sheets: time, travel, contact, closing coil, opening coil, motor; station, number,
# date, rate; format of the date; resistance, test current, closed and open contact.
WORDS = [
    "Time|Travel {}|Contact {}|Close coil {}|Trip coil {}|Motor current"
    "|Station|Breaker|Date|Sample rate [kHz]|%m/%d/%Y|Resistance {}|Test current {}|ON|OFF",
    "t|Stroke {}|Main contact {}|I close {}|I trip {}|I motor"
    "|Substation|CB No.|Test date|Sampling frequency [kHz]|%d %b %Y"
    "|Contact resistance {}|DC current {}|CLOSED|OPEN",
    "Zeit|Weg {}|Hauptkontakt {}|Spule EIN {}|Spule AUS {}|Motorstrom"
    "|Umspannwerk|Schalter-Nr.|Prüfdatum|Abtastrate [kHz]|%d.%m.%Y"
    "|Widerstand {}|Prüfstrom {}|EIN|AUS",
    "Zeit|Hub {}|Kontakt {}|Strom Ein-Spule {}|Strom Aus-Spule {}|Motor"
    "|Anlage|Gerät|Datum|Abtastfrequenz [kHz]|%d.%m.%y|Kontaktwiderstand {}|Prüfstrom {}|ZU|AUF",
    "Temps|Course {}|Contact {}|Bobine enclenchement {}|Bobine déclenchement {}|Courant moteur"
    "|Poste|N° disjoncteur|Date d'essai|Fréquence [kHz]|%d/%m/%Y"
    "|Résistance {}|Courant d'essai {}|FERMÉ|OUVERT",
]
# Names and values above the samples of a resistance and travel analyser.
SETTINGS = """Station Name|{station};Bay Name|{bay};Equipment No|{equipment};CB Type|{type}
Rated Voltage (kV)|245;Gas Pressure (bar)|6.4;Test Date|{day};Ambient Temp (°C)|21.5
Trigger Option|Coil;{rate_name}|{rate};Resistance Range (uOhm)|{range};Linkage Ratio|{ratio}
Plot Length (ms)|{length};C - O Delay (ms)|300;T1 (mm)|150.0;T2 (mm)|0;Velocity Points In|{unit}
Close1|{c1};Open1|{o1};Close2|{c2};Open2|{o2};Mechanism Travel(T1)(mm)|{drive:.2f}"""


def pick(rng: np.random.Generator, choices, p=None):
    """Return a random choice."""
    return choices[int(rng.choice(len(choices), p=p))]


def motion_curve(rng: np.random.Generator, stroke: float, closing: bool) -> np.ndarray:
    """Return the travel, mm, at steps of STEP from the first motion on.

    Some drives start slowly: the travel first grows by a power of the time, or creeps.
    """
    speed = rng.uniform(2.0, 4.0) if closing else rng.uniform(4.0, 9.0)
    rise = rng.uniform(4.0, 9.0) if closing else rng.uniform(2.5, 5.0)
    zone = stroke * rng.uniform(0.12, 0.3)  # mm, travel in which the damper acts
    zeta, omega = rng.uniform(0.5, 0.95), speed / zone * rng.uniform(1.0, 1.5)
    creep = stroke * rng.uniform(0.01, 0.05) if not closing and rng.random() < 0.6 else 0.0
    tau, slow = rng.uniform(15.0, 45.0), rng.random(2) < [0.35, 0.15]
    power, long = rng.uniform(1.5, 4.0), rng.uniform(4, 20) * (1.0 if closing else 0.4)
    power = power if slow[0] else 2.0
    until, crawl = rng.uniform(3, 15) * slow[1] * (1.0 if closing else 0.4), rng.uniform(0.02, 0.15)
    curve = np.zeros(int(450 / STEP))
    x = v = damped = since = 0.0
    for i in range(1, len(curve)):
        share = min(max((x - stroke + zone) / (0.3 * zone), 0.0), 1.0)
        damped = max(damped, share * share * (3 - 2 * share))
        since += STEP * (damped > 0)
        rest = stroke - creep * np.exp(-since / tau)
        after = i * STEP - until
        push = (speed - v) / rise * min(max(after, STEP) / long, 1.0) ** (power - 2)
        push = (crawl - v) / 0.5 if after <= 0 else push
        stop = omega * omega * (x - rest) + 2 * zeta * omega * v
        v += STEP * ((1 - damped) * push - damped * stop)
        x += STEP * v
        curve[i] = x
    return curve * (stroke / curve[-1])


def mean_speed(curve: np.ndarray, begin: float, end: float) -> float:
    """Return the mean speed, m/s, between two positions in mm."""
    return (end - begin) / (reached(curve, end) - reached(curve, begin))


def values_of(curve: np.ndarray, zone: list[float]) -> dict:
    """Return the quantities of a curve; `crossings` are the times of 0, 1, ... 99 % of stroke."""
    stroke, top = float(curve[-1]), int(np.argmax(curve))
    over = max(float(curve[top]) - stroke, 0.0)
    crossings = [reached(curve, stroke * k / 100) for k in range(100)]
    return {
        "stroke": stroke,
        "over_travel": over,
        "rebound": max(stroke - float(curve[top:].min()), 0.0) if over > 0.01 else 0.0,
        "travel_time": crossings[90] - crossings[10],
        "speed": mean_speed(curve, zone[0] * stroke, zone[1] * stroke),
        "crossings": crossings,
    }


def draw_plan(rng: np.random.Generator) -> dict:
    """Return the properties that the poles of a breaker share: operation, drive and coils."""
    time = 0.0 if rng.random() < 0.4 else rng.uniform(5, 60)
    latches = {"closing": rng.uniform(25, 60), "opening": rng.uniform(8, 20)}
    moves = []
    for motion in pick(rng, PLANS, p=[0.25, 0.25, 0.35, 0.1, 0.05]).split():
        moves.append((motion, time, latches[motion]))
        time += rng.uniform(200, 400)
    return {
        "moves": moves,
        "length": sum(moves[-1][1:]) + rng.uniform(130, 300),
        "stroke": rng.uniform(100, 200),
        "lead": rng.uniform(2, 15) if rng.random() < 0.75 else 0.0,
        "seeds": {m: int(rng.integers(2**31)) for m in latches},
        "ganged": rng.random() < 0.4,
        "spread": rng.uniform(0, 3) * (rng.random() < 0.3),
    }


def draw_pole(rng: np.random.Generator, phase: str, plan: dict) -> dict:
    """Return a pole: its contacts, the times at which its coil is energised, and its motions."""
    stroke = plan["stroke"] * rng.uniform(0.98, 1.02)
    gap = stroke * rng.uniform(0.58, 0.7)
    pole = {"phase": phase, "stroke": stroke, "motions": []}
    pole["contacts"] = {"arcing": gap, "main": gap + plan["lead"]}
    for motion, coil, latch in plan["moves"]:
        energised = coil + rng.uniform(0, 1) * plan["spread"] * (not plan["ganged"])
        same = np.random.default_rng(plan["seeds"][motion])  # poles of a type have equal curves
        curve = motion_curve(same, stroke, motion == "closing")
        first = energised + latch * rng.uniform(0.97, 1.03)
        bounces = draw_bounces(rng) if motion == "closing" else []
        move = {"motion": motion, "energised": energised, "first": first}
        pole["motions"].append(move | {"travel": curve, "bounces": bounces})
    ripple = (rng.uniform(1, 3) * stroke / 180, rng.uniform(3, 8))
    pole["ripple"] = ripple if rng.random() < 0.25 else None
    pole["slack"] = rng.uniform(0.5, 3.0) if rng.random() < 0.15 else 0.0
    return pole


def shown_travel(pole: dict, move: dict) -> np.ndarray:
    """Return the travel as a transducer shows it: with ripple of the linkage and slack."""
    curve, speed = move["travel"], np.gradient(move["travel"])
    if pole["slack"]:
        curve = curve * (1 - np.exp(-((curve / (2 * pole["slack"])) ** 2)))
    if pole["ripple"]:
        mm, period = pole["ripple"]
        swing = np.sin(2 * np.pi * np.arange(len(curve)) * STEP / period)
        curve = curve + mm * swing * np.clip(speed / speed.max(), 0, 1)
    return curve


def position(pole: dict, time: np.ndarray, shown: bool) -> np.ndarray:
    """Return the contact's travel from open at times ``(t,)``, true or as the transducer shows."""
    stroke = pole["stroke"]
    travel = np.full(len(time), 0.0 if pole["motions"][0]["motion"] == "closing" else stroke)
    for move in pole["motions"]:
        curve, since = shown_travel(pole, move) if shown else move["travel"], time - move["first"]
        done = np.interp(since, np.arange(len(curve)) * STEP, curve)
        moved = done if move["motion"] == "closing" else stroke - done
        travel = np.where(since > 0, moved, travel)
    return travel


def travel_column(rng: np.random.Generator, pole: dict, time: np.ndarray) -> np.ndarray:
    """Return a travel channel with random noise, hum, bursts and quantisation."""
    noise = pick(rng, [0.02, 0.05, 0.1, 0.2, 0.5, 1.2], p=[0.1, 0.2, 0.4, 0.2, 0.07, 0.03])
    x = position(pole, time, shown=True) + noise * rng.standard_normal(len(time))
    if rng.random() < 0.15:  # mains hum
        turn = 2 * np.pi * pick(rng, [0.05, 0.06, 0.1]) * time
        x += rng.uniform(0.05, 0.4) * np.sin(turn + rng.uniform(0, 2 * np.pi))
    if rng.random() < 0.15:
        move = pick(rng, pole["motions"])
        touch = move["first"] + contact_times(pole, move)["main"]
        begin = move["energised"] if rng.random() < 0.5 else touch
        hit = (time >= begin) & (time < begin + rng.uniform(0.5, 4))
        x = np.where(hit, x + rng.uniform(5, 40) * rng.standard_normal(len(x)), x)
    quantum = rng.uniform(0.08, 0.32) if rng.random() < 0.1 else 300 / 2**16  # counter, or 16 bits
    return quantum * np.round(x / quantum)


def coil_current(rng: np.random.Generator, time, move: dict, amps: float) -> np.ndarray:
    """Return the current of a coil, which rises, dips as its armature moves, and falls."""
    latch, since = move["first"] - move["energised"], time - move["energised"]
    long, rise, dip = max(rng.uniform(10, 40), latch), rng.uniform(2, 6), rng.uniform(0.4, 0.7)
    on = np.clip(since, 0, long)
    notch = 1 - 0.3 * np.exp(-(((on / latch - dip) / 0.12) ** 2))
    return amps * (1 - np.exp(-on / rise)) * notch * np.exp(-np.maximum(since - long, 0) / 0.6)


def settings(rng: np.random.Generator, plan: dict, pole: dict, style: dict) -> list[list[str]]:
    """Return lines of cells with the nameplate, settings and points of speed, 1 to 4 on a line."""
    rate, zones = style["rate"], style["zones"]
    names = [("Sampling Speed (kC)", rate), ("Sampling Rate (kHz)", rate)]
    names += [("Sample Rate (Hz)", 1000 * rate), ("Sampling Interval (ms)", 1 / rate)]
    rate_name, value = pick(rng, names, p=[0.6, 0.2, 0.1, 0.1])
    filled = SETTINGS.format(
        **{key: style[key] for key in ("station", "bay", "equipment", "type", "ratio")},
        **{f"{m[0]}{i + 1}": zones[m][i] for m in ("closing", "opening") for i in (0, 1)},
        unit=zones["unit"],
        rate_name=rate_name,
        rate=f"{value:g}" if style["stated"] else "NIL",
        day=f"{style['date']:%d-%m-%Y}",
        range=f"{style['range']:g}",
        length=f"{plan['length']:.0f}",
        drive=pole["stroke"] / style["ratio"],
    )
    pairs = [pair.split("|") for line in filled.splitlines() for pair in line.split(";")]
    lines: list[list[str]] = []
    while pairs:
        many = int(rng.integers(1, 5))
        lines.append([cell for name, value in pairs[:many] for cell in (f"{name} :", value, "")])
        lines += [[]] * int(rng.random() < 0.1)
        pairs = pairs[many:]
    return lines


def share_of(zones: dict, motion: str, stroke: float) -> list[float]:
    """Return the points of speed as shares of the stroke."""
    return [value / (100 if zones["unit"] == "%" else stroke) for value in zones[motion]]


def analyser(rng: np.random.Generator, plan: dict, poles: list[dict], style: dict) -> dict:
    """Return lines, columns and channels of a resistance and travel analyser's export."""
    time = np.arange(int(plan["length"] * style["rate"])) / style["rate"]
    same = np.random.default_rng(style["seed"])  # files of an inspection have the same layout
    coil = pick(same, ["Coil Current C{} (A)", "C{} Current (A)"], p=[0.8, 0.2])
    travel = pick(same, ["Travel T{} (mm)", "Travel T{} in mm", "Contact Travel T{} (mm)"])
    ohms = ["DCRM Res CH{} in uOhm", "Resistance CH{} (uOhm)", "Resistance CH{} (mOhm)"]
    ohms = pick(same, ohms, p=[0.6, 0.2, 0.2])
    milli = 1000 if "mOhm" in ohms else 1
    meter, amperes = draw_meter(same, style["range"]), same.random() < 0.8
    ampere = pick(same, ["DCRM Current CH{} in Amp", "Test Current CH{} (A)"], p=[0.7, 0.3])
    currents = [0.01 * rng.standard_normal(len(time)) for _ in range(6)]
    quiet = pick(rng, [0.0, 0.02, 0.1, 0.5])
    travels = [quiet * rng.standard_normal(len(time)) for _ in range(6)]
    channels = []
    for i, pole in enumerate(poles):
        travels[i] = travel_column(rng, pole, time) + rng.uniform(5, 40) * style["offset"]
        coils, amps = {}, rng.uniform(1, 5)
        for move in pole["motions"]:
            n = (0 if move["motion"] == "closing" else 3) + i * (not plan["ganged"])
            coils[move["motion"]] = coil.format(n + 1)
            if i == 0 or not plan["ganged"]:
                currents[n] += coil_current(rng, time, move, amps)
        channel = {"column": travel.format(i + 1), "pole": pole, "coils": coils}
        channels.append(channel | {"contacts": [], "kind": "none"})
    columns = [("Time (ms)", time, 4)] * style["timed"]
    columns += [(coil.format(k + 1), x, 3) for k, x in enumerate(currents)]
    columns += [(travel.format(k + 1), x, style["digits"]) for k, x in enumerate(travels)]
    columns.append(("", None, 0))
    above = [[""] * len(columns), [""] * len(columns)]
    wired = channels * (style["wired"] > 0.15)
    for n, channel in enumerate([*wired, *[None] * 6][:6] if style["dcrm"] else [], 1):
        ohm, amps = measured(rng, channel and channel["pole"], time, meter)
        paired = [(ohms.format(n), ohm / milli, 1 if milli == 1 else 4)]
        paired += [(ampere.format(n), amps, 2)] * amperes
        columns += paired
        above[0] += [f"TR{n}", ""][: len(paired)]
        phase = channel["pole"]["phase"] + "Break1" if channel else "NA"
        above[1] += [phase, ""][: len(paired)]
        if channel:
            channel["contacts"] = [name for name, _, _ in paired]
            channel["kind"] = "resistance and current" if amperes else "resistance alone"
    lines = [] if style["bare"] else settings(rng, plan, poles[0], style)
    lines += above if style["rows"] and style["dcrm"] else []
    return {"lines": lines, "columns": columns, "channels": channels, "shift": 0.0}


def contact_columns(rng, pole: dict, time: np.ndarray, kind: str, style: tuple) -> list[tuple]:
    """Return columns of a contact: place in ``WORDS``, unit, values and digits; ``style`` is the
    meter, whether a signal rises as the contact closes, and words of a closed and an open one.
    """
    meter, rises, states = style
    if kind.startswith("resistance"):
        ohm, amps = measured(rng, pole, time, meter)
        return [(11, "mOhm", ohm / 1000, 4), (12, "A", amps, 2)][: 1 + (kind != "resistance alone")]
    if kind == "voltage":
        volts = signal(pole, time, rises, 24.0) + 0.2 * rng.standard_normal(len(time))
        return [(2, "V", volts, 2)]
    state = signal(pole, time, rises or kind == "words", 1.0)
    state = np.where(state > 0, *states) if kind == "words" else state
    return [(2, "", state, 0)] * (kind != "none")


def plain(rng: np.random.Generator, plan: dict, poles: list[dict], style: dict) -> dict:
    """Return lines, columns and channels of a plain sheet: time, travel, contacts and coils."""
    time = np.arange(int(plan["length"] * style["rate"])) / style["rate"]
    same = np.random.default_rng(style["seed"])  # files of an inspection have the same layout
    which = int(same.integers(len(WORDS)))
    words = WORDS[which].split("|")
    shift = pick(same, [0.0, -20.0, 100.0], p=[0.7, 0.2, 0.1])
    brackets, unit = pick(same, [" ({})", " [{}]"]), pick(same, ["ms", "ms", "s"])
    kinds = ["binary", "voltage", "words", "resistance and current", "resistance alone", "none"]
    kind = pick(same, kinds, p=[0.25, 0.2, 0.1, 0.2, 0.1, 0.15])
    meter = draw_meter(same, style["range"])
    coiled, flips, rises = same.random() < 0.8, same.random() < 0.1, same.random() < 0.7
    alone = len(poles) == 1 and same.random() < 0.5

    def named(word, unit, phase=""):
        name = words[word].format("" if alone else phase).strip()
        return name + brackets.format(unit) * bool(unit)

    columns = [(named(0, unit), (time + shift) / (1000 if unit == "s" else 1), 6)]
    channels, contacts, coils = [], [], []
    for i, pole in enumerate(poles):
        x = travel_column(rng, pole, time)
        x = (pole["stroke"] - x if flips else x) + rng.uniform(5, 40) * style["offset"]
        columns.append((named(1, "mm", pole["phase"]), x, style["digits"]))
        channel = {"column": columns[-1][0], "pole": pole, "coils": {}, "kind": kind}
        paired = contact_columns(rng, pole, time, kind, (meter, rises, words[13:]))
        paired = [(named(word, unit, pole["phase"]), *column) for word, unit, *column in paired]
        contacts += paired
        channel["contacts"] = [name for name, _, _ in paired]
        for motion in sorted({m["motion"] for m in pole["motions"]} if coiled else []):
            phase = "" if plan["ganged"] else pole["phase"]
            name = named(3 if motion == "closing" else 4, "A", phase)
            channel["coils"][motion] = name
            amps, current = rng.uniform(1, 5), 0.01 * rng.standard_normal(len(time))
            for move in [m for m in pole["motions"] if m["motion"] == motion]:
                current += coil_current(rng, time, move, amps)
            coils += [(name, current, 3)] * (i == 0 or not plan["ganged"])
        channels.append(channel)
    columns += contacts + coils
    if rng.random() < 0.2:
        since = np.maximum(time - plan["moves"][0][1] - rng.uniform(60, 150), 0)
        current = 4 * (1 + 4 * np.exp(-since / 40)) * (1 - np.exp(-since / 5))
        columns.append((named(5, "A"), current + 0.05 * rng.standard_normal(len(time)), 2))
    shown = [style["station"], style["equipment"], f"{style['date']:{words[10]}}"]
    lines = [list(pair) for pair in zip(words[6:10], [*shown, f"{style['rate']:g}"], strict=True)]
    lines = lines[: 4 if style["stated"] else int(rng.integers(4))] * (not style["bare"])
    return {"lines": lines, "columns": columns, "channels": channels, "shift": shift}


def write_table(rng: np.random.Generator, path: Path, sheet: dict, style: dict) -> None:
    """Write lines and columns as the text that an analyser exports."""
    comma, buffer = style["decimal"] == ",", io.StringIO()
    names = [name for name, _, _ in sheet["columns"]] + [""] * int(rng.random() < 0.3)
    writer = csv.writer(buffer, delimiter=style["separator"], lineterminator="\n")
    for cells in sheet["lines"]:
        if comma:
            cells = [re.sub(r"^(\d*)\.(\d+)$", r"\1,\2", cell) for cell in cells]
        writer.writerow(cells + [""] * ((len(names) - len(cells)) * style["padded"]))
    writer.writerow(names)
    n = len(sheet["columns"][0][1])
    cells = [
        [""] * n if x is None else [v if isinstance(v, str) else f"{v:.{d}f}" for v in x]
        for _, x, d in sheet["columns"]
    ]
    cells += [[""] * n] * (len(names) - len(cells))
    samples = "\n".join(style["separator"].join(row) for row in zip(*cells, strict=True)) + "\n"
    text = buffer.getvalue() + (samples.replace(".", ",") if comma else samples)
    path.write_bytes(text.replace("\n", style["newline"]).encode(style["encoding"]))


def truth_of(path: Path, sheet: dict, style: dict) -> dict:
    """Return the truth of one file as plain values; times are ms of the file."""
    channels = {}
    for channel in sheet["channels"]:
        pole, motions = channel["pole"], []
        for move in pole["motions"]:
            curve, first = move["travel"], move["first"] + sheet["shift"]
            zone = share_of(style["zones"], move["motion"], pole["stroke"])
            coil, seen = channel["coils"].get(move["motion"]), shown_travel(pole, move)
            truth = {"motion": move["motion"], "first": first, "zone": zone, "coil": coil}
            truth |= {"energised": move["energised"] + sheet["shift"] if coil else None}
            late = reached(seen, 0.3)  # slack hides the start
            truth |= {"shown": values_of(seen, zone), "slack": late * (pole["slack"] > 0)}
            truth |= {"columns": channel["contacts"]} | dict.fromkeys(("contact", "main", "bounce"))
            if channel["contacts"]:
                arcing, main = (first + t for t in contact_times(pole, move).values())
                bounces = [end for _, end in bounces_of(pole, move)]
                truth |= {"contact": arcing, "main": main, "bounce": max(bounces, default=0.0)}
            motions.append(truth | values_of(curve, zone))
        channels[channel["column"]] = {"motions": motions, "kind": channel["kind"]}
    columns = [name for name, _, _ in sheet["columns"]]
    layout = {key: style[key] for key in ("rate", "zones", "separator", "decimal", "encoding")}
    return layout | {"file": path.name, "channels": channels, "columns": columns}


def write_export(folder: Path, rng: np.random.Generator) -> list[dict]:
    """Write the export of an inspection, in one file or a file for each pole; return the truths."""
    folder.mkdir(parents=True, exist_ok=True)
    plan, many = draw_plan(rng), pick(rng, [1, 2, 3], p=[0.35, 0.2, 0.45])
    layout = pick(rng, [analyser, plain], p=[0.65, 0.35])
    separator = pick(rng, [",", ";", "\t"], p=[0.6, 0.25, 0.15])
    date = datetime(2012, 1, 1) + timedelta(seconds=int(rng.integers(12 * 365 * 86400)))
    percent = rng.random() < 0.7
    zones = {m: [int(rng.integers(10, 41)), int(rng.integers(50, 81))] for m in plan["seeds"]}
    style = {
        "station": pick(rng, ["Norden  220 kV", "Süd", "Lake Side", "Bellevue", "Grünau"]),
        "bay": f"{rng.integers(1, 9)}0{rng.integers(1, 9)}  {pick(rng, ['Line', 'Bus', 'ICT'])}",
        "equipment": f"{rng.integers(10**7, 10**8)}",
        "type": pick(rng, ["GL314", "GL 314", "HX 145", "VR-245", "GL318 CR"]),
        "date": date,
        "rate": pick(rng, RATES if rng.random() < 0.5 else [5, 10, 12]),
        "stated": rng.random() < 0.85,
        "bare": rng.random() < 0.24,
        "zones": zones | {"unit": "%" if percent else "mm"},
        "seed": int(rng.integers(2**31)),
        "separate": many > 1 and rng.random() < 0.35,
        "offset": rng.random() < 0.25,
        "digits": pick(rng, [1, 2, 2, 3]),
        "wired": rng.random(),
        "dcrm": rng.random() < 0.8,
        "timed": rng.random() < 0.1,
        "rows": rng.random() < 0.75,
        "range": pick(rng, [4000.0, 8000.0, 10000.0, 20000.0]),
        "ratio": round(float(rng.uniform(0.9, 1.9)), 2),
        "separator": separator,
        "decimal": "," if separator != "," and rng.random() < 0.6 else ".",
        "encoding": pick(rng, ["utf-8", "utf-8-sig", "latin-1", "cp1252"]),
        "newline": pick(rng, ["\n", "\r\n"]),
        "padded": rng.random() < 0.5,
    }
    poles = [draw_pole(rng, phase, plan) for phase in pick(rng, PHASES).split()[:many]]
    files, form = [], int(rng.integers(3))
    for i, group in enumerate([[pole] for pole in poles] if style["separate"] else [poles]):
        sheet, names = layout(rng, plan, group, style), [pole["phase"] for pole in group]
        made = date + timedelta(seconds=i)  # files made seconds apart are poles, not repeats
        name = [
            f"{style['equipment']}_{made:%Y%m%d%H%M%S}.csv",
            f"{style['bay'][:3]}-{','.join(names)} {date:%d-%m-%Y}.csv",
            f"{style['equipment']} {'_'.join(names)} {date:%d.%m.%Y}.txt",
        ][form]
        write_table(rng, folder / name, sheet, style)
        files.append(truth_of(folder / name, sheet, style))
    return files
