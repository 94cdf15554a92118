"""What tables of a report are made of: cells and notes, in words."""

from collections.abc import Iterable, Sequence
from typing import NamedTuple

from breaker.inspection import alike

__all__ = ["NONE", "RESULTS", "Cell", "Table", "few", "named", "some_of"]

RESULTS = {
    "fail": ("FAIL", "bad"),
    "not shown": ("not shown", "doubt"),
    "pass": ("pass", "good"),
}
"""Text and tone of verdicts, the worst first."""

_MOST = 8  # notes below a table


class Cell(NamedTuple):
    """A text, and what it means: "good", "bad", "doubt", "faint" or nothing particular."""

    text: str
    tone: str = ""


NONE = Cell("–", "faint")
"""Where no value is."""


class Table(NamedTuple):
    """A table of a report, with notes below it."""

    title: str
    head: tuple[str, ...]
    rows: list[tuple[Cell, ...]]
    notes: list[str]


def some_of(text: str, where: Iterable[str], channels: int) -> str:
    """A text, with the channels that it is about where these are not all."""
    names = [*filter(None, dict.fromkeys(where))]
    return f"{text} ({', '.join(names)})" if 0 < len(names) < channels else text


def named(said: Iterable[tuple[str, str]], channels: int) -> list[str]:
    """Sentences, those that differ in numbers only once, with channels where these are not all.

    Args:
        said: Channel and sentence.
        channels: Number of channels in all.
    """
    groups = alike(("", channel, text) for channel, text in said)
    return few(
        [some_of(each[0][2], (channel for _, channel, _ in each), channels) for each in groups]
    )


def few(lines: Sequence[str]) -> list[str]:
    """The first lines, and how many more there are."""
    more = len(lines) - _MOST
    return [*lines[:_MOST], *([f"and {more} more, which breaker infer prints"] if more > 0 else [])]
