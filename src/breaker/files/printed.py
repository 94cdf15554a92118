"""What an analyser prints of its own results: pairs, or a table of quantities by channels."""

import math
import re
from collections.abc import Sequence
from typing import NamedTuple

from breaker.files.motions import motion_of
from breaker.files.names import by_words, split_unit, unit_of
from breaker.files.pairs import Pair, numbers_of
from breaker.files.settings import TO_MM, TO_MS

_QUANTITIES = {  # the first that a name has, if it has none of those that are no results
    "": r"point|punkt|range|limit|\bmin|rated|nominal|toler|refer|soll|sampl|ratio|unit|transducer"
    r"|sensor|gauge|scale|level|delay|length|\bto\b|\bfrom\b|type|resol|definition",
    "datum_speed": r"datum\W.*(?:veloc|speed)",
    "maximum_speed": r"\b(?:max|peak)\w*\W.*(?:veloc|speed|geschw)",
    "maximum_travel": r"\b(?:max|peak)\w*\W.*(?:travel|stroke)",
    "over_travel": r"over.?\s?(?:travel|stroke|shoot)|überhub|überschwing|sobre\w*carrera|超程",
    "rebound": r"re.?bound|back.?\s?travel|rückprall|rebote|反弹",
    "mechanism_travel": r"(?:mech\w*|drive|rod)\W*(?:travel|stroke)|antriebs?(?:hub|weg)",
    "wipe": r"\bwipe\b|penetration|contact engagement",
    "damping_time": r"damp",
    "speed": r"veloc|speed|geschw|vitesse|\bv\b|速度",
    "travel_time": r"(?:travel|stroke|running|motion)\W*time|laufzeit",
    "closing_time": r"clos\w*\W*time|einschalt\w*zeit|temps de fermeture|合闸时间",
    "opening_time": r"(?:open|trip)\w*\W*time|ausschalt\w*zeit|temps d.ouverture|分闸时间",
    "stroke": r"stroke|travel|\bhub\b|\bweg\b|schalthub|course|carrera|行程",
}
_meant = by_words(_QUANTITIES)
_NAN = math.nan
_SIZES = {  # mm/ms, ms and mm, by the end of a quantity's name
    "speed": {"m/s": 1.0, "mm/ms": 1.0, "cm/s": 1e-2, "mm/s": 1e-3, "ft/s": 0.3048, "in/s": 0.0254}
    | {"rad/s": _NAN, "deg/s": _NAN},
    "time": TO_MS,
    "": TO_MM | {"deg": _NAN},
}
_NONE = r"(?:(?<![^\W\d_])|(?<=[\u4e00-\u9fff]))"
_CHANNEL = re.compile(
    rf"{_NONE}(?:ch|channel|kanal|travel|trans(?:ducer)?|tr?|pole|pol)[\W_]*(\d+)\b", re.I
)
_PHASE = re.compile(
    rf"{_NONE}(?:(?:phase|pole|pol|leiter|ph)[\s_.:-]*(l?[123]|[a-cr-wy]|red|yellow|blue)(?![^\W_])"
    rf"|(l[123]|[rybabcstuvw]|red|yellow|blue)[\W_]*(?:phase|pole|ph|相)?$)",
    re.I,
)
_HEADS = re.compile(
    r"param|quantit|result|measur|value|mess|größe|grandeur|name|descr|item|channel|phase|pole|^$",
    re.I,
)


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


def channel_of(text: str) -> int:
    """Return the number of the channel that a text names, 0 where it names none."""
    found = _CHANNEL.search(text) or re.fullmatch(r"\s*(\d{1,2})\s*()", text)
    return int(found[1]) if found else 0


def phase_in(text: str) -> str:
    """Return the phase that a text names, empty where it names none.

    >>> phase_in("Phase R"), phase_in("L2"), phase_in("Travel 1")
    ('R', 'L2', '')
    """
    found = _PHASE.search(split_unit(text.strip())[0])
    return next(filter(None, found.groups()), "").strip() if found else ""


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
        channel = _CHANNEL.search(pair.name)
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
    named = _HEADS.search(cells[0]) and (any(channels[1:]) or any(quantities))
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
