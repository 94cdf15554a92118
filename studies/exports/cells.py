"""How the cells of a table of operations stand to the truth of the folder's exports."""

import re
from collections import Counter, defaultdict
from datetime import datetime

from studies.exports.scores import bare

FILL_IN = "FILL IN"
KINDS = ("right", "wrong", "needless", "guessed", "fill in")
NAMES = {"contact": "contact_column", "coil": "trigger_column", "part": "from"}


def true_rows(folder: dict) -> list[dict]:
    """Return a row for each motion of each channel, with what is known of it and how surely."""
    rows, base = [], Counter()
    serials = defaultdict(set)
    for visit in folder["visits"]:
        serials[visit["serial"]].add(visit["bay"])
    for visit in sorted(folder["visits"], key=lambda each: each["date"]):
        drive, most = visit["equipment"], 0
        same = [f for v in folder["visits"] if v["equipment"] == drive for f in v["files"]]
        linked = any(f["says"]["breaker"] for f in same)
        for truth in visit["files"]:
            says, poles = truth["says"], len(truth["channels"])
            shared = len(serials[visit["serial"]]) > 1 and not visit["known"]["plain"]
            about = {"file": truth["path"], "layout": truth["layout"], "drive": drive}
            about |= {"shared": shared, "rate": truth["rate"], "date": visit["date"]}
            about |= {"breaker": next(filter(None, (f["says"]["breaker"] for f in same)), "")}
            named = linked or visit["sorted"]
            about |= {"sure breaker": "yes" if says["breaker"] else "either" if named else "no"}
            about |= {"sure date": surely_dated(visit, says), "sure motion": says["motions"]}
            about["sure rate"] = says["rate"]
            phased = says["phases"] or visit["form"] > 0
            about |= {"sure phase": phased, "poles": max(poles, len(visit["files"]))}
            for column, channel in truth["channels"].items():
                places = Counter()
                for move in channel["motions"]:
                    motion = move["motion"]
                    number = base[drive] + places[motion] + 1
                    row = about | {"channel": column, "phase": channel["phase"], "motion": motion}
                    row |= {"operation": number, "first": move["first"], "coil": move["coil"]}
                    row |= {"last": move["first"] + move["crossings"][95]}
                    row |= {"contacts": list(move["contacts"]), "place": places[motion]}
                    row["parts"] = [m["first"] for m in channel["motions"]]
                    row["coils"] = [m["coil"] for m in channel["motions"]]
                    rows.append(row)
                    places[motion] += 1
                most = max(most, *places.values())
        base[drive] += most
    return rows


def surely_dated(visit: dict, says: dict) -> bool:
    """Say whether the date of a visit can be read in one way alone."""
    date = datetime.fromisoformat(visit["date"])
    clear = date.day > 12 or date.day == date.month
    words = "." in says["date"] or re.search("[A-Z]", says["date"]) is not None
    return clear or visit["form"] != 1 or words


def judged(cell: str, right: bool, sure: str | bool) -> str:
    """Return which of ``KINDS`` a cell is."""
    if cell == FILL_IN:
        return "needless" if sure in (True, "yes", "stated") else "fill in"
    if not right:
        return "wrong"
    return "guessed" if sure in (False, "no", "") and cell else "right"


def cells_of(row: dict, true: dict) -> dict[str, str]:
    """Return the kind of each cell of a row of the table."""
    sure = true["sure motion"]
    found = {"motion": judged(row["motion"], row["motion"] == true["motion"], sure)}
    named = true["breaker"] in row["breaker"] if true["shared"] else true["breaker"]
    right = named is True or row["breaker"] in (named, true["drive"])
    found["breaker"] = judged(row["breaker"], right and bool(row["breaker"]), true["sure breaker"])
    alone = true["poles"] == 1 and not true["sure phase"] and not row["phase"]
    found["phase"] = judged(
        row["phase"], alone or row["phase"] == true["phase"], true["sure phase"]
    )
    right = row["date"][:10] == true["date"][:10]
    if "T" in row["date"]:  # poles are written seconds apart
        times = map(datetime.fromisoformat, (row["date"], true["date"]))
        right = abs((next(times) - next(times)).total_seconds()) < 5
    found["date"] = judged(row["date"], right, "yes" if true["sure date"] else "either")
    rate, timed = row.get("rate", ""), row.get("time_column", "none") != "none"
    right = timed or (rate not in ("", FILL_IN) and float(rate) == true["rate"])
    found["rate"] = judged(rate, right, true["sure rate"])
    ends = [row["from"], row["to"]]
    if FILL_IN in ends:
        found["part"] = "needless" if true["sure rate"] else "fill in"
    else:
        begin, end = (float(e) if e else d for e, d in zip(ends, (-1e9, 1e9), strict=True))
        inside = [first for first in true["parts"] if begin < first < end]
        alike = true["place"] == 0 and not any(ends)
        right = begin < true["first"] and true["last"] < end and (alike or len(inside) == 1)
        found["part"] = "right" if right else "wrong"
    coils = [true["coil"]] if row["motion"] != FILL_IN else true["coils"]
    for kind, names in (("contact", true["contacts"]), ("coil", coils)):
        column = row.get(NAMES[kind], "")
        right = not column or column == FILL_IN or bare(column) in [bare(c or "") for c in names]
        found[kind] = "right" if right else "wrong"
    return found


def compared(rows: list[dict], truth: list[dict], copies: dict) -> tuple[list[dict], Counter]:
    """Return kinds of cells by file, and how many rows are double or missing."""
    places = defaultdict(list)
    for row in rows:
        key = copies.get(row["file"], row["file"]), bare(row["channel"])
        places[key].append(row)
    counts: Counter = Counter()
    scored = []
    known = {(true["file"], bare(true["channel"])) for true in truth}
    counts["double"] += sum(len(some) for key, some in places.items() if key not in known)
    for key in known:
        own = [true for true in truth if (true["file"], bare(true["channel"])) == key]
        there = places[key]
        counts["missing"] += max(len(own) - len(there), 0)
        counts["double"] += max(len(there) - len(own), 0)
        for row, true in paired(there, own):
            scored.append({"true": true, "row": row, "kinds": cells_of(row, true)})
    numbered(scored)
    return scored, counts


def paired(rows: list[dict], truth: list[dict]) -> list[tuple[dict, dict]]:
    """Return rows of a channel with what they are of, by motion where they have one, and place."""
    if any(row["motion"] == FILL_IN for row in rows):
        return list(zip(rows, truth, strict=False))
    rows, found = sorted(rows, key=lambda row: int(row["operation"])), []
    for motion in ("closing", "opening"):
        some = ([each for each in which if each["motion"] == motion] for which in (rows, truth))
        found += zip(*some, strict=False)
    return found


def numbered(scored: list[dict]) -> None:
    """Judge the numbers of operations, where breaker and dates of a drive are sure throughout."""
    for drive in {each["true"]["drive"] for each in scored}:
        own = [each for each in scored if each["true"]["drive"] == drive]
        certain = all(e["true"]["sure breaker"] == "yes" and e["true"]["sure date"] for e in own)
        certain = certain and all(e["true"]["sure phase"] or e["true"]["poles"] == 1 for e in own)
        names = {each["row"]["breaker"] for each in own}
        for each in own:
            right = int(each["row"]["operation"]) == each["true"]["operation"] and len(names) == 1
            each["kinds"]["operation"] = "right" if right or not certain else "wrong"
    drives = defaultdict(set)
    for each in scored:
        drives[each["row"]["breaker"]].add(each["true"]["drive"])
    for each in scored:
        if len(drives[each["row"]["breaker"]]) > 1 and each["row"]["breaker"] != FILL_IN:
            each["kinds"]["breaker"] = "wrong"


def states_all(true: dict) -> bool:
    """Say whether file and name state all that the row needs."""
    sure = true["sure breaker"] == "yes" and true["sure motion"] == "stated"
    poles = true["sure phase"] or true["poles"] == 1
    return bool(sure and true["sure date"] and true["sure rate"] and poles)


def filled(scored: list[dict]) -> list[dict]:
    """Return rows of a table with what is wrong, or to be filled in, as it truly is."""
    rows = []
    for each in scored:
        row, true = each["row"], each["true"]
        known = {"rate": f"{true['rate']:g}", "sign": "1"}
        known |= {"from": f"{true['first'] - 90:.1f}", "to": f"{true['last'] + 100:.1f}"}
        row = row | {key: known.get(key, "") for key, cell in row.items() if cell == FILL_IN}
        truth = {key: true[key] for key in ("motion", "operation", "phase", "date")}
        rows.append(row | truth | {"breaker": true["drive"]})
    return rows
