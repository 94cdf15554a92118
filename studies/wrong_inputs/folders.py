"""Kinds about several files: copies, orders, and motions in the wrong folder."""

import shutil

import numpy as np

from studies.wrong_inputs.ask import Kind, Question, answered
from studies.wrong_inputs.desk import Desk
from studies.wrong_inputs.visits import SAME


def _none(_) -> str:
    return ""


def _pooled(said) -> str:
    """Return how many records are taken for several operations of one drive."""
    count = sum(len(each.records) for each in said)
    return f"{count} records" if count > 1 else ""


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


def same_phases(desk: Desk, wrong: bool) -> Question:
    """Three phases of the same samples."""
    names = desk.pick([("R", "Y", "B"), ("A", "B", "C"), ("L1", "L2", "L3")])
    records = [desk.record("closing") for _ in names]
    size = min(each.time.size for each in records)
    table = {f"{desk.style.words['time']} [ms]": records[0].time[:size]}
    for i, name in enumerate(names):
        travel = records[0 if wrong else i].travel
        table[f"{desk.style.words['travel']} {name} [mm]"] = travel[:size]
    file = desk.write_columns("a.csv", table)
    report = ["report", file, "--output", desk.folder / "r.html"]
    return Question([report], answered if wrong else _none, layout=file, look=True)


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
    """Files whose numbers rise while the dates that they state fall, and their proposed table."""
    files, _ = _dated(desk, wrong)
    own, table = "motions: [closing]\n", desk.folder / "op/operations.csv"
    propose = ["inspect", desk.folder / "op", "--output", table]
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


FOLDERS = {
    "one file for all": Kind(one_file_for_all, SAME),
    "same phases": Kind(same_phases, SAME),
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
