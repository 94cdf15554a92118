"""Which operation of which breaker each file of a folder is: its breaker, its date, its counter.

What files state goes before their names, and names before the order in which they were written.
"""

import re
from collections import Counter, defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import replace
from datetime import datetime
from itertools import pairwise
from pathlib import Path

from breaker.common.numerals import natural
from breaker.reading.files.date_text import dates_of, earlier, moments
from breaker.reading.files.file_facts import FoundFile, Row
from breaker.reading.files.file_names import numbers_in
from breaker.reading.files.operations_table import FILL_IN
from breaker.reading.files.preamble import Preamble
from breaker.reading.files.word_meanings import bare

_LONGEST = 200  # signs of a cell
_LONG = re.compile(r"\d{5,}")  # a number of a breaker, rather than a counter

_APART = 6 * 3600.0  # s, from which a file is of another visit, as dates alone are


def with_breakers(files: Sequence[FoundFile]) -> tuple[list[FoundFile], list[str]]:
    """Return files with their breakers, and what to check of these.

    A breaker is the serial number that a file states, or else the bay. One serial number in two
    bays stands for two breakers, since operations of two drives must not become those of one. Of
    what states neither, files of the same name but for date and phase tell, or those of its folder,
    or else the folder itself; where some files state a breaker and nothing tells, it is to be
    filled in.
    """
    named, remarks = _stated_breakers(files)
    by_name, by_folder = defaultdict(set), defaultdict(set)
    for file in files:
        if name := named.get(file.path):
            by_name[file.folder, file.key].add(name)
            by_folder[file.folder].add(name)
    numbers = [{*_LONG.findall(file.key)} for file in files]
    several = 1 < len(set().union(*numbers)) < len(files)
    counted = all(isinstance(each, int) for each in numbers_in([file.stem for file in files]))
    found, linked = [], 0
    for file in files:
        name = named.get(file.path, "")
        if not name:
            same = by_name.get((file.folder, file.key), set()) if file.key else set()
            there = by_folder.get(file.folder, set())
            if len(same) == 1:
                (name,) = same
                linked += 1
            elif file.folder and not there:
                name = file.folder
            elif there or named or (several and not counted):
                name = FILL_IN
        found.append(file._replace(breaker=name[:_LONGEST]))
    if linked:
        remarks.append(
            f"the breaker of {linked} files is that of files of the same name but for date and "
            "phase, as they state none"
        )
    if lacking := [file.path for file in found if file.breaker == FILL_IN]:
        remarks.append(
            f"the breaker of {len(lacking)} files, first {lacking[0]}, is to be filled in: neither "
            "they nor their names state it"
        )
    return found, remarks


def _stated_breakers(files: Sequence[FoundFile]) -> tuple[dict[str, str], list[str]]:
    """Breakers that files state, by their path, and serial numbers that stand in several bays."""
    bays: dict[str, dict[str, str]] = defaultdict(dict)
    for file in files:
        stated = file.seen.preamble
        if stated.serial and stated.bay:
            bays[stated.serial].setdefault(bare(stated.bay), " ".join(stated.bay.split()))
    found = {}
    for file in files:
        stated = file.seen.preamble
        name = stated.serial or " ".join(stated.bay.split())
        if len(bays.get(stated.serial, ())) > 1:
            name = f"{stated.serial} {bays[stated.serial][bare(stated.bay)]}" if stated.bay else ""
        if name:
            found[file.path] = name
    return found, [_twice(serial, each) for serial, each in bays.items() if len(each) > 1]


def _twice(serial: str, bays: Mapping[str, str]) -> str:
    return (
        f"serial number {serial} is on files of {len(bays)} bays, {' and '.join(bays.values())}: "
        "taken for as many breakers, with the bay in their names; if it is one that was moved, "
        "name it alike and number its operations anew"
    )


def days_of(stated: Mapping[str, Preamble]) -> tuple[dict[str, str], list[str]]:
    """Return the date of each file as ISO 8601, and what to check of them.

    What a file states goes before its name. Where day and month may be either, the name tells
    which it is, or else other files do, texts those of texts and names those of names. A date that
    none tells is to be filled in.

    Args:
        stated: What the text of each file says, by its path.
    """
    named = {path: _dates_in_name(Path(path).stem) for path in stated}
    by_names = {first for each in named.values() for first in each if len(each) == 1}
    several = [path for path, each in named.items() if len({*each.values()}) > 1]
    if len(by_names) == 1:
        (first,) = by_names
        named |= {path: {first: named[path][first]} for path in several}
    by_texts = {each.day_first for each in stated.values()} - {None}
    found, open_, others = {}, [], []
    for path, each in stated.items():
        own, name = each.dates, [*dict.fromkeys(named[path].values())]
        if right := [day for day in own if {day[:10]} == {day[:10] for day in name}]:
            own = tuple(right)
        elif len({*own}) > 1 and len(by_texts) == 1 and not _disagree(own, name, by_texts):
            own = replace(each, dates=own).with_days(first=by_texts == {True}).dates
            others.append(path)
        days = [*dict.fromkeys(own or name)]
        if len(days) > 1:
            open_.append(path)
        more = [day for day in name if days == [day[:10]]]  # of the same day, with its time
        found[path] = FILL_IN if len(days) > 1 else next(iter(more or days), "")
    return found, [
        *_of_names(found, stated, several, by_names),
        *_of_texts(others, by_texts, open_),
    ]


def _dates_in_name(stem: str) -> dict[bool, str]:
    """The first date in a name, with its time: by whether its day stands before its month, where
    that is to be told; once where it is not.
    """
    moment = next((each for each in moments(stem) if each.when), None)
    if moment is None:
        return {}
    either = dates_of(stem[moment.start : moment.stop])
    rest = moment.iso[10:]
    if moment.iso[:10] not in either.values() or len({*either.values()}) == 1 < len(either):
        return {True: moment.iso, False: moment.iso}
    return {first: day + rest for first, day in either.items()}


def _disagree(own: Sequence[str], name: Sequence[str], orders: set[bool]) -> bool:
    """Whether the name has one of two dates of the text, and not that which other files tell."""
    told = own[0] if orders == {True} else own[-1]
    return bool({day[:10] for day in own} & {day[:10] for day in name}) and all(
        day[:10] != told[:10] for day in name
    )


def _of_names(
    found: Mapping[str, str],
    stated: Mapping[str, Preamble],
    several: Sequence[str],
    orders: set[bool],
) -> list[str]:
    """What to check of dates that are from names."""
    own = [path for path, day in found.items() if day not in ("", FILL_IN)]
    own = [path for path in own if not stated[path].dates]
    if not own:
        return []
    said = f"dates of {len(own)} files are from their names"
    if orders and {*own} & {*several}:
        said += (
            f", the day {'before' if orders == {True} else 'after'} the month, as others have it"
        )
    return [said]


def _of_texts(others: Sequence[str], orders: set[bool], open_: Sequence[str]) -> list[str]:
    said = []
    if others:
        order = "before" if orders == {True} else "after"
        said.append(f"dates of {len(others)} files have the day {order} the month, as others do")
    if open_:
        said.append(
            f"the date of {len(open_)} files, first {open_[0]}, is to be filled in: day and month "
            "may be either, and no other file tells"
        )
    return said


def with_counters(rows: Sequence[Row]) -> tuple[list[tuple[int, Row]], list[str]]:
    """Return the operations of a breaker with their counters, and what to check of these.

    Files of one pole each are poles of the same operations. Where names say no counter, the first
    operations of a visit, in any motion and pole, are those after the last of the visit before.
    """
    groups: dict[tuple[str, str], list[Row]] = defaultdict(list)
    for row in rows:
        groups[row.motion, row.phase].append(row)
    said: dict[tuple[str, str, int], int] = {}
    for group in groups.values():
        numbers = numbers_in([row.file.stem for row in group])
        if all(isinstance(each, int) for each in numbers) and len({*numbers}) == len(numbers):
            said |= dict(zip(map(_motion_of_file, group), numbers, strict=True))
    remarks, visits = [], _by_visits(rows)
    found = [(said.get(_motion_of_file(row), visits[_motion_of_file(row)]), row) for row in rows]
    if len(said) < len(rows):
        open_ = [row.file for row in rows if _motion_of_file(row) not in said]
        name = "" if open_[0].breaker == FILL_IN else open_[0].breaker
        remarks.append(
            f"{name}: ".removeprefix(": ") + f"{len(open_)} operations are numbered from 1 in the "
            f"order of {_order(open_)}, as the names do not say the counter"
        )
    for key in groups:
        own = {n: row for n, row in found if (row.motion, row.phase) == key}
        remarks += _falling(dict(sorted(own.items())))
    return found, remarks


def _motion_of_file(row: Row) -> tuple[str, str, int]:
    return row.file.path, row.motion, row.place


def _by_visits(rows: Sequence[Row]) -> dict[tuple[str, str, int], int]:
    """Counters in the order of dates, or else of the times of writing."""
    found: dict[tuple[str, str, int], int] = {}
    before, counts, last = 0, Counter(), ""
    dated = all(row.file.day not in ("", FILL_IN) for row in rows)
    for row in sorted(rows, key=lambda row: (_when(row.file), natural(row.file.path), row.place)):
        when = _when(row.file)
        if dated and last and _are_apart(last, when):
            before, counts = before + max(counts.values()), Counter()
        # Poles without a name have one operation each.
        poles = {p.phase if p.phase != FILL_IN else row.file.path for p in row.parts} or {""}
        keys = [(row.motion, pole) for pole in poles]
        number = max(counts[key] for key in keys) + 1
        counts.update({key: number - counts[key] for key in keys})
        found[_motion_of_file(row)] = before + number
        last = when
    return found


def _when(file: FoundFile) -> str:
    """Date and time by which files are in order, as ISO 8601."""
    known = file.day not in ("", FILL_IN)
    return file.day if known else datetime.fromtimestamp(file.written).isoformat()


def _are_apart(one: str, other: str) -> bool:
    if "T" not in one or "T" not in other:
        return one[:10] != other[:10]
    first, second = (datetime.fromisoformat(each) for each in (one, other))
    return (second - first).total_seconds() > _APART


def _order(files: Sequence[FoundFile]) -> str:
    """By what files are in order, in words."""
    if any(file.day in ("", FILL_IN) for file in files):
        return "the times at which the files were written, where they have no date"
    stated = all(file.seen.preamble.dates for file in files)
    return "the dates that they state" if stated else "the dates in their names"


def _falling(rows: Mapping[int, Row]) -> list[str]:
    """Say where the dates of files fall while the numbers in their names rise."""
    for (first, one), (second, other) in pairwise(rows.items()):
        if FILL_IN not in (one.file.day, other.file.day) and earlier(one.file.day, other.file.day):
            return [
                f"the date of {other.file.path}, operation {second}, {other.file.day}, is earlier "
                f"than that of operation {first}, {one.file.day}: mend the numbers or the dates; "
                "the table is refused as it is"
            ]
    return []
