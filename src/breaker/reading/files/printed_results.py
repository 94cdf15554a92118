"""What an analyser prints of its own results: pairs, or a table of quantities by channels."""

import math
import re
from collections.abc import Sequence
from typing import NamedTuple

from breaker.reading.files.column_names import unit_of
from breaker.reading.files.format_settings import TO_MM, TO_MS
from breaker.reading.files.lexicon import RESULT_HEADS, RESULTS
from breaker.reading.files.motion_words import motion_of
from breaker.reading.files.name_value_pairs import Pair, numbers_of
from breaker.reading.files.phases import channel_in, channel_of, phase_in
from breaker.reading.files.word_lookup import by_words, says

_meant = by_words(RESULTS)
_NAN = math.nan
_SIZES = {  # mm/ms, ms and mm, by the end of a quantity's name
    "speed": {"m/s": 1.0, "mm/ms": 1.0, "cm/s": 1e-2, "mm/s": 1e-3, "ft/s": 0.3048, "in/s": 0.0254}
    | {"rad/s": _NAN, "deg/s": _NAN},
    "time": TO_MS,
    "": TO_MM | {"deg": _NAN},
}


class Printed(NamedTuple):
    """A result of an analyser.

    Attributes:
        quantity: What it is, such as "stroke", "speed" or "closing_time". A travel of the contact
            is a stroke, that of the mechanism, before its linkage, is none.
        motion: "closing" or "opening"; empty where the text does not say.
        channel: As the text names it, such as "CH1", "R" or "2"; empty for one of all.
        value: In its unit.
        unit: As it stands in the text.
        name: As it stands in the text.
    """

    quantity: str
    motion: str
    channel: str
    value: float
    unit: str
    name: str

    @property
    def size(self) -> float | None:
        """Size of its unit, mm, ms or mm/ms; NaN of an angle, None where it may have no such."""
        sizes = next(each for end, each in _SIZES.items() if self.quantity.endswith(end))
        return sizes.get(unit_of(self.unit) or self.unit.lower()) if self.unit else 1.0


def quantity_of(name: str) -> str:
    """Return the quantity that a name means, empty where it means none of an operation."""
    return next(iter(_meant(name)), "")


def printed_of(
    rows: Sequence[Sequence[str]], pairs: Sequence[Pair], decimal: str
) -> tuple[Printed, ...]:
    """Return the results that lines state, by their cells, their pairs and the sign of numbers.

    >>> rows = [["Parameter", "CH1", "CH2"], ["Stroke (mm)", "178.1", "178.4"]]
    >>> [each[:5] for each in printed_of(rows, (), ".")]
    [('stroke', '', 'CH1', 178.1, 'mm'), ('stroke', '', 'CH2', 178.4, 'mm')]
    """
    tables, taken = _tables(rows, decimal)
    found = list(tables)
    for pair in pairs:
        if pair.row in taken or not (quantity := quantity_of(pair.name)):
            continue
        numbers, unit = numbers_of(pair.values, decimal)
        channel = channel_in(pair.name)
        label = channel[0] if channel else phase_in(pair.name)
        several = sum(map(math.isfinite, numbers)) > 1
        texts = (v for v, n in zip(pair.values, numbers, strict=True) if math.isnan(n))
        unit, motion = pair.unit or unit or next(texts, ""), motion_of(pair.name)
        for place, number in enumerate(numbers, start=1):
            channel = str(place) if several else label
            found.append(Printed(quantity, motion, channel, number, unit, pair.name))
    fit = (each for each in found if math.isfinite(each.value) and each.size is not None)
    return tuple(dict.fromkeys(fit))


def _tables(rows: Sequence[Sequence[str]], decimal: str) -> tuple[list[Printed], set[int]]:
    """Results in tables, by quantities or by channels, and the lines that they take."""
    found, taken, head, title = [], set(), None, ""
    for place, row in enumerate(rows):
        cells = [cell.strip() for cell in row]
        while cells and not cells[-1]:
            cells.pop()
        if len(list(filter(None, cells))) == 1:
            title, head = motion_of(cells[0]) if cells[0] else "", None
        elif not cells or any(cell.endswith((":", "=")) for cell in cells):
            head = None
        elif not any(map(math.isfinite, numbers := numbers_of(cells[1:], decimal)[0])):
            head = cells if _is_head(cells) else None
            taken |= {place} if head else set()
        elif head:
            # The names of channels may stand alone, with none of the column of quantities.
            head = ["", *head] if len(head) == len(cells) - 1 else head
            each = _row(head, cells, numbers, title)
            found += each
            taken |= {place} if each else set()
    return found, taken


def _is_head(cells: Sequence[str]) -> bool:
    """Whether a line has names of channels, or of quantities, side by side."""
    channels = [bool(channel_of(cell) or phase_in(cell)) for cell in cells]
    quantities = [bool(quantity_of(cell)) for cell in cells[1:]]
    named = says(cells[0], RESULT_HEADS) and (any(channels[1:]) or any(quantities))
    return bool(named) or all(channels)


def _row(
    head: Sequence[str], cells: Sequence[str], numbers: Sequence[float], title: str
) -> list[Printed]:
    """Results in a line of a table."""
    found, columns = [], list(zip(head[1:], cells[1:], numbers, strict=False))
    unit = next((cell for label, cell, _ in columns if label.lower().startswith("unit")), "")
    for label, _, number in columns:
        heads = quantity_of(label) and not channel_of(label)
        name, channel = (label, cells[0]) if heads else (cells[0], label)
        if (quantity := quantity_of(name)) and not label.lower().startswith("unit"):
            inner = re.search(r"[\[(]\s*([^\[\]()]+?)\s*[\])]", name)
            own = inner[1] if inner else unit
            found.append(Printed(quantity, motion_of(name) or title, channel, number, own, name))
    return found
