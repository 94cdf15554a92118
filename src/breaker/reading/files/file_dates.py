"""Dates of the files of a folder, where day and month may be either."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from breaker.reading.files.date_text import dates_of, moments
from breaker.reading.files.operations_table import FILL_IN
from breaker.reading.files.preamble import Preamble


def days_of(stated: Mapping[str, Preamble]) -> tuple[dict[str, str], list[str]]:
    """Return the date of each file as ISO 8601, and what to check of them.

    What a file states goes before its name. Where day and month may be either, the name tells
    which it is, or else other files do, texts those of texts and names those of names. A date that
    none tells is to be filled in.

    Args:
        stated: What the text of each file says, by its path.
    """
    named = {path: _named(Path(path).stem) for path in stated}
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
    return found, [*_said(found, stated, several, by_names), *_of_texts(others, by_texts, open_)]


def _named(stem: str) -> dict[bool, str]:
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


def _said(
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
