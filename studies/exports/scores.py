"""Compare the reading of an export with its truth: right, withheld, missing or false."""

import re
from typing import NamedTuple

import numpy as np

from breaker.model.quantities import SHARES

VERDICTS = ("right", "withheld", "missing", "false")
_LATE = 0.5  # ms, largest error of a time that counts as right
_SURE = 3.0  # standard deviations from the truth beyond which a value is false
_HALF = 1.96  # half the width of a 95 % interval, in standard deviations


class Row(NamedTuple):
    """Reading of one true value."""

    kind: str
    name: str
    channel: str
    true: object
    said: object
    sd: float | None
    verdict: str


def bare(column: str) -> str:
    """Return the name of a column without its unit."""
    return re.sub(r"\s*( in \w+|[(\[][^()\[\]]*[)\]])$", "", column).strip()


def judge(true: list, item: dict, tolerance: float, withheld: bool) -> tuple[str, float | None]:
    """Return the verdict on a value, and its sd towards the nearest true value.

    True values are the value of the drive, and the value that its transducer shows.
    """
    median = item.get("median")
    if median is None:
        return "withheld" if withheld or item.get("reason") else "missing", None
    value = min((v for v in true if v is not None), key=lambda v: abs(median - v), default=np.inf)
    low, high = item.get("interval_95") or (median, median)
    sd = (high - median if value > median else median - low) / _HALF
    error = abs(median - value)
    return "false" if error > tolerance and error > _SURE * sd else "right", sd


def true_speeds(move: dict, meaning: str) -> list[float]:
    """Return the true speeds in the sheet's zone, or next to the contact touch or separation."""
    if "of stroke" in meaning or "mm from" in meaning:
        return [m["speed"] for m in (move, move["shown"])]
    match = re.search(r"([\d.]+) (mm|ms) (before|after)", meaning)
    if move["contact"] is None or not match:
        return []
    sign = -1 if match[3] == "before" else 1
    event, distance, speeds = move["contact"] - move["first"], sign * float(match[1]), []
    for curve in (move, move["shown"]):
        times, travel = curve["crossings"], np.arange(100) / 100 * curve["stroke"]
        level, in_mm = np.interp(event, times, travel), match[2] == "mm"
        end = np.interp(level + distance, travel, times) if in_mm else event + distance
        speeds.append(float((np.interp(end, times, travel) - level) / (end - event)))
    return speeds


def true_values(move: dict, kind: str, quantities: dict) -> dict[str, tuple[list, float]]:
    """Return true values and tolerances by the package's names of quantities.

    Values that begin with None are optional: a main contact that the record does not show, and
    bounces that a resistance without a test current may not show.
    """
    motion, shown, stroke = move["motion"], move["shown"], move["stroke"]
    over = "over_travel" if motion == "closing" else "opening_over_travel"
    first, on, contact, main = (move[k] for k in ("first", "energised", "contact", "main"))
    two = contact is not None and main != contact and kind.startswith("resistance")

    def since(begin, end):
        return None if None in (begin, end) else end - begin

    after = [since(first, time) for time in (contact, main)]
    wipes, between = [None], [None]
    if contact is not None:
        curves, shares = (move, shown), np.arange(100) / 100
        levels = [m["stroke"] * np.interp(after, m["crossings"], shares) for m in curves]
        wipes = [float(mm[0]) for mm in levels]
        if motion == "closing":
            wipes = [m["stroke"] - mm for m, mm in zip(curves, wipes, strict=True)]
        between = [None] * (not two) + [float(abs(mm[1] - mm[0])) for mm in levels]
    speed = f"{motion}_speed"
    near = true_speeds(move, (quantities.get(speed) or {}).get("meaning") or "")
    event = "touch_time" if motion == "closing" else "separation_time"
    values = {
        "stroke": ([m["stroke"] for m in (move, shown)], 0.01 * stroke),
        "travel_time": ([m["travel_time"] for m in (move, shown)], _LATE),
        over: ([m["over_travel"] for m in (move, shown)], 0.01 * stroke),
        f"{speed}_zone": ([m["speed"] for m in (move, shown)], 0.02 * move["speed"]),
        speed: (near or [None], 0.02 * near[0] if near else 0.0),
        "reaction_time": ([since(on, first)], _LATE + move["slack"]),
        event: (after[:1], _LATE + move["slack"]),
        f"{motion}_time": ([since(on, contact)], _LATE),
        f"main_{motion}_time": ([None] * (not two) + [since(on, main)], _LATE),
        "arcing_wipe": (between, 0.01 * stroke),
        f"{motion}_wipe": (wipes, 0.01 * stroke),
    }
    if motion == "closing":
        values["bounce_time"] = ([None] * (kind == "resistance alone") + [move["bounce"]], _LATE)
    for name, percent in SHARES.items():
        crossed = [since(on, first + m["crossings"][percent]) for m in (move, shown)]
        values[name] = (crossed if on is not None else [None], _LATE)
    return values


def score_motion(truth: dict, column: str, move: dict, record: dict | None, refused: bool):
    """Return rows that compare a record of `breaker infer` with a true motion."""
    name, rows = f"{column} {move['motion']} {move['first']:.1f}", []
    contact = truth["channels"][column]["kind"]
    fit, quantities = (record or {}).get("fit") or {}, (record or {}).get("quantities") or {}
    moves, room = fit.get("first_motion"), _HALF * fit.get("first_motion_sd", 0.0)
    first = {"median": moves, "interval_95": [moves - room, moves + room]} if fit else {}
    items = {("motion", "first motion"): (first, [move["first"]], _LATE + move["slack"])}
    for quantity, (true, tolerance) in true_values(move, contact, quantities).items():
        item = quantities.get(quantity) or {}
        item = {} if item.get("source") in ("estimated", "mixed") else item
        if true[0] is not None or item.get("median") is not None:
            items["value", quantity] = item, true, tolerance
    for (kind, quantity), (item, true, tolerance) in items.items():
        verdict, sd = judge(true, item, tolerance, refused)
        shown = next((v for v in true if v is not None), None)
        rows.append(Row(kind, quantity, name, shown, item.get("median"), sd, verdict))
    if "contact_time" in fit:
        verdict = "right" if fit["resolved"] else "withheld"
        rows.append(Row("motion", "resolved with a contact", name, None, None, None, verdict))
    return rows


def score_columns(truth: dict, column: str, motion: str, reported: list) -> list[Row]:
    """Return rows of the columns that are reported as contact and coil of a channel's motion."""
    rows, channel = [], truth["channels"][column]
    move = next(m for m in channel["motions"] if m["motion"] == motion)
    # coils of other poles that are energised at the same time are equally right
    others = [m for c in truth["channels"].values() for m in c["motions"]] * bool(move["coil"])
    same = [m for m in others if m["coil"] and m["motion"] == motion]
    coils = [m["coil"] for m in same if abs(m["energised"] - move["energised"]) < 0.3]
    named = (("contact column", list(move["columns"])), ("coil column", coils))
    for (name, true), shown in zip(named, reported, strict=True):
        true, shown = sorted({bare(c) for c in true}), bare(shown) if shown else None
        verdict = "right" if shown in true or not (shown or true) else "false"
        verdict = "missing" if shown is None and true else verdict
        expected = " ".join(true) or None
        rows.append(Row("column", name, f"{column} {motion}", expected, shown, None, verdict))
    return rows


def score(truth: dict, document: dict) -> list[Row]:
    """Return a row for each value of a file: right, withheld, missing, or false.

    `document` contains the `records` of `breaker infer --json`, each with its `channel`, the
    channels and motions `refused`, and from the output of `breaker inspect` the `columns` (contact
    and coil of a channel's motion) and `moves` (accepted channels and motions).
    """
    rows: list[Row] = []
    records = [r for r in document["records"] if r["accepted"]]
    for column, channel in truth["channels"].items():
        for move in channel["motions"]:
            same = [r for r in records if r["channel"] == column and r["motion"] == move["motion"]]
            near = [r for r in same if abs((r["fit"]["first_motion"] or 1e9) - move["first"]) < 40]
            refused = [column, move["motion"]] in document["refused"]
            rows += score_motion(truth, column, move, near[0] if near else None, refused)
            records = [r for r in records if r not in near[:1]]
        for motion in sorted({m["motion"] for m in channel["motions"]}):
            cells = next((c for c in document["columns"] if c[:2] == [column, motion]), [None] * 4)
            rows += score_columns(truth, column, motion, cells[2:])
    wrong = [("no such motion", r["channel"], r["motion"]) for r in records]
    known = [bare(name) for name in truth["channels"]]
    wrong += [("no such travel", *move) for move in document["moves"] if move[0] not in known]
    rows += [Row("motion", name, c, None, motion, None, "false") for name, c, motion in wrong]
    return rows
