"""How what is said of an export stands to its truth: right, absent or false."""

import re
from typing import NamedTuple

import numpy as np

from breaker.model.quantities import EVENTS


class Row(NamedTuple):
    """What is said of one true value; `hint` is what a false value truly is."""

    kind: str
    name: str
    channel: str
    true: object
    said: object
    half: float | None
    verdict: str
    hint: str = ""


def bare(column: str) -> str:
    """Return the name of a column without its unit."""
    return re.sub(r"\s*( in \w+|[(\[][^()\[\]]*[)\]])$", "", column).strip()


def judge(true: list, said: float | None, half: float | None, tolerance: float) -> str:
    """Return how a value stands to the true ones (of the drive, or as its transducer shows it)."""
    if said is None:
        return "absent"
    away = min((abs(said - value) for value in true if value is not None), default=np.inf)
    return "false" if away > tolerance and away > 5 * (half or 0.0) else "right"


def speed_near_contact(move: dict, meaning: str) -> list[float]:
    """Return the true speeds over some mm before the touch or after parting."""
    found = re.search(r"([\d.]+) (mm|ms) (before|after)", meaning)
    if move["contact"] is None or not found:
        return []
    sign = -1 if found[3] == "before" else 1
    at, far, speeds = move["contact"] - move["first"], sign * float(found[1]), []
    for curve in (move, move["shown"]):
        times, ways = curve["crossings"], np.arange(100) / 100 * curve["stroke"]
        way = np.interp(at, times, ways)
        there = np.interp(way + far, ways, times) if found[2] == "mm" else at + far
        speeds.append(float((np.interp(there, times, ways) - way) / (there - at)))
    return speeds


def true_values(move: dict, quantities: dict) -> dict[str, tuple[list, float]]:
    """Return true values by the product's names of quantities, and what may be off."""
    motion, shown, stroke = move["motion"], move["shown"], move["stroke"]
    over = "over_travel" if motion == "closing" else "rebound"
    touch = "touch_time" if motion == "closing" else "part_time"
    start = 0.3 + move["slack"]
    contact, first, on = move["contact"], move["first"], move["energised"]
    after = None if contact is None else contact - first
    wipes, curves = [None], (move, shown)
    if after is not None:
        gone = [np.interp(after, m["crossings"], np.arange(100) * stroke / 100) for m in curves]
        wipes = [float(stroke - mm if motion == "closing" else mm) for mm in gone]
    speed = f"{motion}_speed"
    near = speed_near_contact(move, (quantities.get(speed) or {}).get("meaning") or "")
    return {
        "stroke": ([m["stroke"] for m in curves], 0.01 * stroke),
        "travel_time": ([m["travel_time"] for m in curves], 0.3),
        over: ([m["over_travel"] for m in curves], 0.01 * stroke),
        f"{speed}_zone": ([m["speed"] for m in curves], 0.02 * move["speed"]),
        speed: (near or [None], 0.02 * near[0] if near else 0.0),
        "latch_time": ([None if on is None else first - on], start),
        touch: ([after], start),
        f"{motion}_time": ([move["from_coil"]], 0.3),
        f"wipe_at_{EVENTS[motion]}": (wipes, 0.01 * stroke),
    }


def other_values(truth: dict, said: float, name: str) -> str:
    """Return which other contact, coil or channel of the file a false value is of."""
    for column, channel in truth["channels"].items():
        for move in channel["motions"]:
            if name in move and name != "contact" and abs(move[name] - said) < 0.005 * said:
                return f"{name} of {column}, {move['motion']}"
            for contact, kinds in move["contacts"].items():
                for kind, at in kinds.items():
                    for begin in ("energised", "first"):
                        if move[begin] is not None and abs(at - move[begin] - said) < 0.2:
                            return f"{kind} contact of {contact} since {begin}, {move['motion']}"
    return ""


def score_motion(truth: dict, column: str, move: dict, record: dict | None) -> list[Row]:
    """Return rows of what a record of `breaker infer` says of a true motion."""
    name = f"{column} {move['motion']} {move['first']:.1f}"
    fit, quantities = (record or {}).get("fit") or {}, (record or {}).get("quantities") or {}
    said, half = fit.get("moves"), 2.0 * fit.get("moves_sd", 0.0)
    verdict = judge([move["first"]], said, half, 1.5 + move["slack"] + 1 / truth["rate"])
    rows = [Row("motion", "first motion", name, move["first"], said, half, verdict)]
    if "contact_time" in fit:
        verdict = "right" if fit["resolved"] else "absent"
        rows.append(Row("motion", "resolved with a contact", name, None, None, None, verdict))
    for quantity, (true, tolerance) in true_values(move, quantities).items():
        item = quantities.get(quantity) or {}
        inferred = "inferred" in (item.get("source") or "")
        said = None if inferred else item.get("median")
        if true[0] is None and said is None:
            continue
        ends = item.get("interval_95") if said is not None else None
        half = (ends[1] - ends[0]) / 2 if ends else None
        verdict = judge(true, said, half, tolerance)
        hint = other_values(truth, said, quantity) if verdict == "false" else ""
        rows.append(Row("value", quantity, name, true[0], said, half, verdict, hint))
    return rows


def score_columns(truth: dict, column: str, motion: str, said: list) -> list[Row]:
    """Return rows of the columns that are said to be contact and coil of a channel's motion."""
    rows, channel = [], truth["channels"][column]
    move = next(m for m in channel["motions"] if m["motion"] == motion)
    # coils of other poles that are energised at the same time are as good
    coils = [move["coil"]] if move["coil"] else []
    for other in (
        m for c in truth["channels"].values() for m in c["motions"] if m["coil"] and coils
    ):
        near = abs(other["energised"] - move["energised"]) < 0.3
        coils += [other["coil"]] if near and other["motion"] == motion else []
    named = (("contact column", list(move["contacts"])), ("coil column", coils))
    for (name, true), one in zip(named, said, strict=True):
        true, one = sorted({bare(c) for c in true}), bare(one) if one else None
        verdict = "right" if one in true or not (one or true) else "false"
        verdict = "absent" if one is None and true else verdict
        hint = "" if truth["rows"] else "no row above says which"
        shown = " ".join(true) or None
        rows.append(Row("column", name, f"{column} {motion}", shown, one, None, verdict, hint))
    return rows


def score(truth: dict, document: dict) -> list[Row]:
    """Return a row for each value of a file: right, absent, or false.

    `document` has `records` as `breaker infer --json` writes them, each with its `channel`, and of
    what `breaker inspect` prints `columns` (contact and coil of a channel's motion), `printed`
    results, and `moves` (channels and motions accepted).
    """
    rows: list[Row] = []
    records = [r for r in document["records"] if r["accepted"]]
    for column, channel in truth["channels"].items():
        for move in channel["motions"]:
            alike = [r for r in records if r["channel"] == column and r["motion"] == move["motion"]]
            near = [r for r in alike if abs((r["fit"]["moves"] or 1e9) - move["first"]) < 40]
            rows += score_motion(truth, column, move, near[0] if near else None)
            records = [r for r in records if r not in near[:1]]
        for motion in sorted({m["motion"] for m in channel["motions"]}):
            said = next((c for c in document["columns"] if c[:2] == [column, motion]), [None] * 4)
            rows += score_columns(truth, column, motion, said[2:])
    wrong = [("no such motion", r["channel"], r["motion"]) for r in records]
    known = [bare(name) for name in truth["channels"]]
    wrong += [("no such travel", *move) for move in document["moves"] if move[0] not in known]
    rows += [Row("motion", name, c, None, motion, None, "false") for name, c, motion in wrong]
    return rows + score_printed(truth, document)


def score_printed(truth: dict, document: dict) -> list[Row]:
    """Return rows of printed results: whose they are said to be, and how they are compared."""
    rows, said = [], []
    columns = {c["transducer"]: bare(name) for name, c in truth["channels"].items()}
    for column, motion, quantity, printed, marked in document["printed"]:
        quantity = quantity.replace(" ", "_")
        alike = [p for p in truth["printed"] if p["quantity"] == quantity]
        off = 0.06 if quantity == "speed" else 0.006  # one speed is printed with one digit
        alike = [p for p in alike if abs(p["value"] - printed) < max(off, 0.001 * printed)]
        own = [p for p in alike if columns[p["transducer"]] == column]
        own = [p for p in own if None in (motion, p["motion"]) or p["motion"] == motion]
        right = [p["name"] for p in own if p["of"] == "contact"]
        if not column or quantity in ("mechanism_travel", "datum_speed"):  # compared with nothing
            continue
        hint = right or [p["name"] for p in own + alike] or [""]
        verdict = "right" if right else "false"
        name = f"{column} {motion}"
        rows.append(Row("printed", quantity, name, None, printed, None, verdict, hint[0]))
        if right and marked:  # a true result of the contact is said to differ
            rows.append(rows[-1]._replace(name=f"{quantity} compared", verdict="false"))
        said += right
    for p in truth["printed"]:
        if p["of"] == "contact" and p["value"] and p["name"] not in said:
            name, hint = f"{columns[p['transducer']]} {p['motion'] or ''}", p["name"]
            rows.append(Row("printed", p["quantity"], name, p["value"], None, None, "absent", hint))
    return rows
