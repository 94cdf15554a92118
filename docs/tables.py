"""Write the tables of results into the pages, from the CSV files in this folder.

    python docs/tables.py

A page has the mark ``<!-- table: NAME -->`` above each table. The function NAME returns the rows of
the table, with the header first.
"""

import csv
import re
import sys
from collections.abc import Mapping
from pathlib import Path

DOCS = Path(__file__).resolve().parent
PAGES = (DOCS / "evidence.md", DOCS / "research" / "reproduce.md")
NAMES = ("mu", "k_a", "k_b", "gamma_a", "gamma_b", "f", "L")
FAMILIES = ("medium_voltage", "any")
MOTIONS = ("closing", "opening")

Rows = list[list[str]]
_PLACE = re.compile(r"(<!-- table: (\w+) -->\n)(?:\|.*\n)*")


def read(name: str) -> list[dict[str, str]]:
    """Return the rows of a CSV file."""
    with (DOCS / f"{name}.csv").open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def runs() -> dict[str, str]:
    """Return the numbers of the default run, and of the paper's setting with "paper." before."""
    both = {"": read("numbers"), "paper.": read("paper_numbers")}
    return {prefix + row["name"]: row["value"] for prefix, rows in both.items() for row in rows}


def percent(share: str | float) -> str:
    """Return a share as a percentage without a decimal."""
    return f"{100 * float(share):.0f} %"


def _of_both(rows: Mapping[str, str]) -> Rows:
    """Return table rows for ends of names of ``runs``, in both settings and motions."""
    numbers, settings = runs(), ("paper.", "")
    table = [["", "paper's setting: closing", "opening", "default: closing", "opening"]]
    for word, name in rows.items():
        table.append([word, *(numbers[f"{s}{m}.{name}"] for s in settings for m in MOTIONS)])
    return table


def paper_quality() -> Rows:
    """Quality of the networks of the paper's method."""
    return _of_both(
        {
            "calibration p-value": "calibration_p",
            "coverage of 95 % intervals, lowest output, %": "coverage_95.lowest",
            "the same, highest output, %": "coverage_95.highest",
            "divergence from the exact posterior, nats": "gap",
            "relative effective sample size, median, %": "efficiency_median",
            "the same, lowest of 1,000 curves, %": "efficiency_lowest",
        }
    )


def contraction() -> Rows:
    """Contraction of each parameter."""
    return _of_both({name: f"contraction.{name}" for name in NAMES})


def attributed() -> Rows:
    """True change over the endurance test, and changes of the posterior medians."""
    true, rest = runs(), _of_both({name: f"paper_change.{name}" for name in NAMES})
    added = ["true", *(true[f"closing.true_change.{name}"] for name in NAMES)]
    return [[row[0], more, *row[1:]] for row, more in zip(rest, added, strict=True)]


def blocks() -> Rows:
    """Coverage of the intervals of both kinds of networks over the endurance test."""
    numbers, kinds = runs(), ("paper", "family")
    rows = [["", "closing: paper's networks", "family", "opening: paper's networks", "family"]]
    for name in NAMES:
        ends = (f"{motion}.{kind}_holds.{name}" for motion in MOTIONS for kind in kinds)
        rows.append([name, *(numbers[end] for end in ends)])
    return rows


def state() -> Rows:
    """Contraction and coverage of the state networks on held-out drives."""
    return _family("levels", "contraction")


def change() -> Rows:
    """Errors and coverage of the change networks on held-out drives."""
    return _family("changes", "rms_error", ("both",))


def _family(network: str, shown: str, sources: tuple[str, ...] = (*MOTIONS, "both")) -> Rows:
    table = [["family, motions", *NAMES, "coverage of 90 % intervals", "uniform ranks"]]
    for family in FAMILIES:
        every = [row for row in read(f"family_{family}") if row["network"] == network]
        for motions in sources:
            some = {row["output"]: row for row in every if row["motions"] == motions}
            held = [float(row["coverage_90"]) for row in some.values()]
            uniform = sum(row["calibrated"] == "True" for row in some.values())
            row = [f"{family}, {motions}", *(f"{float(some[n][shown]):.2f}" for n in NAMES)]
            table.append([*row, f"{100 * min(held):.0f} to {percent(max(held))}"])
            table[-1].append(f"{uniform} of {len(some)}")
    return table


def sharpness() -> Rows:
    """Contraction for records of the default sensor, and errors of changes."""
    rows = read("sharpness")
    table = [["", *NAMES]]
    for motions in (*MOTIONS, "both"):
        some = {e["output"]: e for e in rows if (e["network"], e["motions"]) == ("levels", motions)}
        table.append(
            [f"contraction, {motions}", *(f"{float(some[n]['contraction']):.2f}" for n in NAMES)]
        )
    for wear, word in (("sparse", "1 to 3 parameters wear"), ("dense", "most wear")):
        some = {row["output"]: row for row in rows if row["wear"] == wear}
        count = int(some["f"]["drives"])
        cells = [f"{float(some[n]['rms_error']):.2g}" for n in NAMES]
        table.append([f"error of a change, %, {word} ({count:,} drives)", "–", *cells[1:]])
    return table


def independent() -> Rows:
    """Coverage of 95 % intervals for drives of the independent simulator, for the worst output."""
    every = [row for row in read("other_code") if row["of"] == "level"]
    table = [["drives", "closing", "opening", "both motions", "touch, both", "separation, both"]]
    for group in dict.fromkeys(row["group"] for row in every):
        cells = [group]
        for motions in (*MOTIONS, "both"):
            some = [r for r in every if (r["group"], r["drives"]) == (group, motions)]
            worst = min((r for r in some if r["name"] in NAMES), key=lambda r: float(r["hold"]))
            cells.append(f"{percent(worst['hold'])} ({worst['name']})")
        ends = {r["name"]: percent(r["hold"]) for r in some}
        table.append([*cells, ends["touch_from_10"], ends["separation_from_10"]])
    return table


def detected() -> Rows:
    """Reported changes of drives of the independent simulator."""
    changes = [row for row in read("other_code") if row["of"] == "change"]
    every = {(row["drives"], row["name"]): row for row in changes}
    names = [name for name in NAMES if name != "mu"]
    changed = [every["changed", name] for name in names]
    words = [f"{int(float(r['reported']))} of {int(float(r['truly_changed']))}" for r in changed]
    held = [percent(row["hold"]) for row in changed]
    rows = [["reported", *words], ["coverage of 90 % intervals, changed drives", *held]]
    return [["changed parameters", *names], *rows]


def real_shapes() -> Rows:
    """Times at which families contain the shapes of measured high-voltage breakers."""
    rows = read("real_shapes")
    cells = [[percent(row["inside"]) for row in rows if row["family"] == name] for name in FAMILIES]
    head = ["family", *(f"{row['motion']}, noise {float(row['noise']):.1%}" for row in rows[:4])]
    return [head, *([name, *some] for name, some in zip(FAMILIES, cells, strict=True))]


def force_or_ratio() -> Rows:
    """Changes of one parameter or of the ratio, and reported parameters."""
    words = {"f": "closing force", "k_a": "opening spring", "gamma_a": "damping of the drive"}
    words |= {"L": "contact gap", "ratio": "ratio"}
    rows, table = read("force_or_ratio"), [["change", "drives", "reported", "same transducer"]]
    for change in dict.fromkeys(row["change"] for row in rows):
        some = [row for row in rows if row["change"] == change]
        name, _, amount = change.partition(" ")
        key = "any" if name in ("unchanged", "ratio") else "own"
        of = {same: [r for r in some if r["same"] == same] for same in ("False", "True")}
        counts = [str(sum(int(float(r[key])) for r in of[same])) for same in of]
        counts[1] = "–" if name == "ratio" else counts[1]
        drives = str(sum(int(float(row["drives"])) for row in of["False"]))
        title = f"{words.get(name, 'none')} {amount} %" if amount else "none"
        table.append([title, drives, *counts])
    return table


def followed() -> Rows:
    """Coverage over lives, followed continuously and by inspections of few records."""
    table = [["coverage of 90 % intervals", "continuous monitoring", "few records"]]
    rows = {(row["set"], row["name"]): row for row in read("lives")}
    words = {name: name for name in NAMES}
    words |= {"measured": "operations left, limits on measured quantities"}
    words |= {"changed": "operations left, limits on changes"}
    for name, word in words.items():
        cells = []
        for row in (rows["other", name], rows["few", name]):
            share, low, high = (percent(row[key]) for key in ("coverage", "low", "high"))
            cells.append(f"{share} ({low} to {high}; n = {row['count']})")
        table.append([word, *cells])
    return table


def services() -> Rows:
    """Services of lives by the plan, and their cost."""
    table = [["limits on", "records", "lives", "serviced in time", "cost (90 % interval)"]]
    for row in read("plans"):
        n, share = int(row["lives"]), float(row["serviced in time"])
        cost, low, high = (f"{float(row[key]):.2f}" for key in ("cost", "low", "high"))
        limit = {"changed": "changes", "measured": "measured quantities"}[row["limit"]]
        cells = [limit, row["looked at"], str(n), f"{share * n:.0f} of {n}"]
        table.append([*cells, f"{cost} ({low} to {high})"])
    return table


def alarms() -> Rows:
    """False alarms of drives that do not wear."""
    table = [["reported", "limits on", "false", "per 1,000 operations, at most (95 %)"]]
    for row in read("alarms"):
        limit = {"": "–", "changed": "changes", "measured": "measured quantities"}[row["limit"]]
        false, most = f"{row['false']} of {row['of']}", f"{float(row['at_most']):.2f}"
        table.append([row["reported"], limit, false, most])
    return table


def measured() -> Rows:
    """Coverage of the 95 % intervals of measured quantities."""
    rows = read("measuring")
    first = rows[0]["column"]
    table = [["quantity", "usual sd", f"coverage ({first})", "worst condition"]]
    for name in dict.fromkeys((row["motion"], row["quantity"]) for row in rows):
        some = [row for row in rows if (row["motion"], row["quantity"]) == name]
        worst = min(some, key=lambda row: float(row["covered"]))
        unit = "m/s" if "speed" in name[1] else "ms" if "time" in name[1] else "mm"
        sd = f"{float(some[0]['sd']):.2g} {unit}"
        cells = [f"{name[1]}, {name[0]}", sd, percent(some[0]["covered"])]
        where = f"n = {worst['records']}; {worst['column']}"
        table.append([*cells, f"{percent(worst['covered'])} ({where})"])
    return table


def damaged() -> Rows:
    """Outcomes of damaged files: the worst kinds, and all."""
    keys = ("files", "rejected", "right", "masked", "flagged", "silent")
    rows = {row["kind"]: [f"{int(row[key]):,}" for key in keys] for row in read("faults")}
    none, total = rows.pop("nothing"), rows.pop("all")
    worst = sorted(rows.items(), key=lambda row: -int(row[1][-1]))[:3]
    table = [["kind of damage", *keys], ["none", *none], *([kind, *row] for kind, row in worst)]
    return [*table, ["all damaged", *total]]


def networks() -> Rows:
    """Both inference networks after the same training time."""
    rows = {(r["population"], r["network"], r["quantity"]): r for r in read("default_network")}
    table = [
        ["curves", "network", "log density behind, nats", "divergence, nats", "draws per second"]
    ]
    for population, network in dict.fromkeys(key[:2] for key in rows):
        lost, divergence = (rows[population, network, q] for q in ("lost", "divergence"))
        cells = ["0" if network == "coupling_flow" else _interval(lost), _interval(divergence)]
        speed = f"{float(rows[population, network, 'draws_per_second']['value']):,.0f}"
        table.append([population, network.replace("_", " "), *cells, speed])
    return table


def _interval(row: Mapping[str, str]) -> str:
    value, low, high = (float(row[key]) for key in ("value", "low", "high"))
    return f"{value:.3f} ({low:.3f} to {high:.3f})"


def placed(text: str) -> str:
    """Return a page with tables from the files."""

    def table(match: re.Match) -> str:
        head, *rows = globals()[match[2]]()
        lines = [head, ["---"] * len(head), *rows]
        return match[1] + "".join(f"| {' | '.join(line)} |\n" for line in lines)

    return _PLACE.sub(table, text)


def main() -> int:
    """Update the tables of all pages."""
    for page in PAGES:
        page.write_text(placed(page.read_text(encoding="utf-8")), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
