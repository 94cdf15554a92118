"""Kinds about several files: copies, mixtures, orders, and motions in the wrong folder."""

import shutil

import numpy as np

from studies.wrong_inputs.ask import Kind, Question, answered, compared
from studies.wrong_inputs.desk import Desk
from studies.wrong_inputs.drives import Drive
from studies.wrong_inputs.visits import SAME, SAMES, same


def _none(_) -> str:
    return ""


def _pooled(said) -> str:
    """Return what was told of several records together."""
    found = []
    for each in said:
        for motion, together in (each.document.get("together") or {}).items():
            if isinstance(together, dict) and together.get("records", 0) > 1:
                found.append(f"{motion}: {together['records']} records together")
    return "; ".join(found)


def one_file_for_all(desk: Desk, wrong: bool) -> Question:
    """One file behind all operations of a folder or of its table."""
    count, table = int(desk.rng.integers(2, 6)), desk.rng.random() < 0.5
    records = [desk.record("closing") for _ in range(count)]
    names = [f"op/closing/operation_{n:04}.csv" for n in range(1, count + 1)]
    files = [desk.write(name, each) for name, each in zip(names, records, strict=True)]
    if wrong:
        for file in files[1:]:
            shutil.copy(files[0], file)
    if table:
        rows = [f"closing/operation_{n:04}.csv,closing,{n}" for n in range(1, count + 1)]
        text = "\n".join(["file,motion,operation", *rows]) + "\n"
        (desk.folder / "op/operations.csv").write_text(text, encoding="utf-8")
    own = "motions: [closing]\n"
    commands = [["infer", desk.folder / "op", "--json"], ["inspect", desk.folder / "op"]]
    return Question(commands, _pooled if wrong else _none, layout=files[0], own=own)


def exported_again(desk: Desk, wrong: bool) -> Question:
    """One record exported several times, given as several records of a drive."""
    record, ways = desk.record("closing"), desk.rng.permutation(SAMES)[:2]
    others = [desk.record("closing") for _ in ways]
    again = [same(desk, record, str(which)) for which in ways] if wrong else others
    files = [desk.write(f"r{i}.csv", each) for i, each in enumerate([record, *again])]
    command = ["infer", *files, "--json"]
    return Question([command], _pooled if wrong else _none, layout=files[0])


def same_phases(desk: Desk, wrong: bool) -> Question:
    """Three phases of the same samples, perhaps with other zeros."""
    names, zero = desk.pick([("R", "Y", "B"), ("A", "B", "C"), ("L1", "L2", "L3")]), None
    records = [desk.record("closing") for _ in names]
    size = min(each.time.size for each in records)
    zero = desk.pick([0.0, 0.5])
    table = {f"{desk.style.words['time']} [ms]": records[0].time[:size]}
    for i, name in enumerate(names):
        travel = records[0].travel + zero * i if wrong else records[i].travel
        table[f"{desk.style.words['travel']} {name} [mm]"] = travel[:size]
    file = desk.write_columns("a.csv", table)
    report = ["report", file, "--output", desk.folder / "r.html"]
    return Question([report], answered if wrong else _none, layout=file, look=True)


def _two_breakers(desk: Desk, wrong: bool):
    """Write six records of two breakers, or of one; their strokes are alike or differ by 16 %."""
    size = desk.pick([1.0, 1.06, 1.16, 1.16])
    own = [desk.record("closing") for _ in range(3)]
    other = Drive.draw(desk.rng, own[0].truth["stroke"] * size, desk.drive.times)
    more = [desk.record("closing", other if wrong else None) for _ in range(3)]
    order = desk.rng.permutation(6)
    return [desk.write(f"f/operation_{n}.csv", (own + more)[i]) for n, i in enumerate(order, 1)]


def mixture(desk: Desk, wrong: bool) -> Question:
    """Records of two breakers in one folder, such as of 13.5 and 15.7 mm, told as one drive."""
    files = _two_breakers(desk, wrong)
    commands = [["infer", desk.folder / "f", "--json", "--motion", "closing"]]
    false = _pooled if wrong else _none
    return Question(commands, false, layout=files[0], own="motions: [closing]\n", strip=True)


def mixed_visit(desk: Desk, wrong: bool) -> Question:
    """The same six records as one visit that is compared."""
    files = _two_breakers(desk, wrong)
    again = [desk.write(f"g/operation_{n}.csv", desk.record("closing")) for n in (1, 2, 3)]
    command = ["compare", *files, "--today", *again, "--json"]
    false = compared if wrong else _none
    return Question([command], false, layout=files[0], strip=True)


def two_serials(desk: Desk, wrong: bool) -> Question:
    """Files of two serial numbers in one call, which is of one drive."""
    numbers = desk.rng.integers(10**4, 10**6, 2)
    files = []
    for i in range(2):
        header = desk.header(serial=numbers[i if wrong else 0])
        files.append(desk.write(f"{i}.csv", desk.record("closing"), header))
    return Question([["infer", *files, "--json"]], _pooled if wrong else _none, layout=files[0])


def _dated(desk: Desk, wrong: bool):
    """Write closings and return rows of a table whose dates rise, or fall, with the numbers."""
    count = int(desk.rng.integers(3, 6))
    first = np.datetime64("2015-01-01") + int(desk.rng.integers(900))
    days = np.cumsum(desk.rng.integers(20, 900, count)) + first
    days = days[::-1] if wrong else days
    files = []
    for number, day in enumerate(days, 1):
        name = f"op/closing/operation_{number:04}.csv"
        files.append(desk.write(name, desk.record("closing"), desk.header(date=day)))
    return files, [str(day) for day in days]


def dates_of_table(desk: Desk, wrong: bool) -> Question:
    """A table whose numbers rise while its dates fall."""
    files, days = _dated(desk, wrong)
    rows = [
        f"closing/{f.name},closing,{n},{d}"
        for n, (f, d) in enumerate(zip(files, days, strict=True), 1)
    ]
    table = "\n".join(["file,motion,operation,date", *rows]) + "\n"
    (desk.folder / "op/operations.csv").write_text(table, encoding="utf-8")
    own = "motions: [closing]\n"
    commands = [["inspect", desk.folder / "op"], ["infer", desk.folder / "op", "--json"]]
    return Question(commands, answered if wrong else _none, layout=files[0], own=own)


def dates_of_files(desk: Desk, wrong: bool) -> Question:
    """Files whose numbers rise while the dates that they state fall."""
    files, _ = _dated(desk, wrong)
    own = "motions: [closing]\n"
    propose = ["inspect", desk.folder / "op", "--output", desk.folder / "t.csv"]
    commands = [propose, ["inspect", desk.folder / "op"]]
    return Question(commands, answered if wrong else _none, layout=files[0], own=own)


def motions_swapped(desk: Desk, wrong: bool) -> Question:
    """Closings in the folder of openings, and openings in that of closings."""
    other = {"closing": "opening", "opening": "closing"}
    files = []
    for n in (1, 2):
        for motion in other:
            where = other[motion] if wrong else motion
            name = f"op/{where}/operation_{n:04}.csv"
            files.append(desk.write(name, desk.record(motion)))
    plain = desk.write("plain.csv", desk.record("closing"))
    commands = [["infer", desk.folder / "op", "--json"], ["inspect", desk.folder / "op"]]

    def false(said):
        found = [r["motion"] for each in said for r in each.records]
        return f"{len(found)} records told as the other motion" if found and wrong else ""

    return Question(commands, false, layout=plain)


MIXED = r"strokes?\b|two (drives|breakers)|several|unlike|apart|other (drive|breaker)|differ"
FOLDERS = {
    "one file for all": Kind(one_file_for_all, SAME),
    "exported again": Kind(exported_again, SAME),
    "same phases": Kind(same_phases, SAME),
    "mixture": Kind(mixture, MIXED),
    "mixed visit": Kind(mixed_visit, MIXED),
    "two serials": Kind(two_serials, r"serial|several breakers|number|different breakers"),
    "dates of a table": Kind(
        dates_of_table,
        r"\bdates? .*(fall|order|before|earlier)|(earlier|older) than|against the order",
    ),
    "dates of files": Kind(
        dates_of_files,
        r"\bdates? .*(fall|order|before|earlier)|(earlier|older) than|against the order",
    ),
    "motions swapped": Kind(motions_swapped, r"which is no|wrong folder|direction|swapped"),
}
