"""What tables of a report are made of: cells, numbers and notes, in words."""

from collections.abc import Iterable, Sequence
from typing import NamedTuple

from breaker.inspection import alike

__all__ = ["RESULTS", "Cell", "Table", "few", "named", "number"]

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


class Table(NamedTuple):
    """A table of a report, with notes below it."""

    title: str
    head: tuple[str, ...]
    rows: list[tuple[Cell, ...]]
    notes: list[str]


def number(value: float, digits: int) -> str:
    """A number of so many digits, those before the point all there, zeros at the end, too."""
    if abs(value) >= 10.0**digits:
        return f"{value:.0f}"
    return f"{value:#.{digits}g}".removesuffix(".")


def named(said: Iterable[tuple[str, str]], channels: int) -> list[str]:
    """Sentences, those that differ in numbers only once, with channels where these are not all.

    Args:
        said: Channel and sentence.
        channels: Number of channels in all.
    """
    lines = []
    for members in alike(("", channel, text) for channel, text in said):
        where = [*filter(None, dict.fromkeys(channel for _, channel, _ in members))]
        text = members[0][2]
        lines.append(f"{text} ({', '.join(where)})" if 0 < len(where) < channels else text)
    return few(lines)


def few(lines: Sequence[str]) -> list[str]:
    """The first lines, and how many more there are."""
    more = len(lines) - _MOST
    return [*lines[:_MOST], *([f"and {more} more, which breaker infer prints"] if more > 0 else [])]
