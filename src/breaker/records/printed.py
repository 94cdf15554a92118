"""Results that an analyser printed, and the same quantities measured in the same record.

The words around a number define it: the name in its line, the head of its column, and the titles
above. A result is compared where these words state the quantity and the channel, for a speed the
points, and for a time the contact, if the pole has several. All other results have a reason.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import lru_cache
from itertools import accumulate
from statistics import median
from typing import TYPE_CHECKING, NamedTuple

from breaker.common.numerals import in_digits
from breaker.model.quantities import EVENTS, SPEEDS, Speed
from breaker.records.header_pairs import Line, Token, name_of, numbers_of
from breaker.records.lexicon import WORDS
from breaker.records.settings import TO_MM, TO_MS
from breaker.records.words import (
    COLUMN_PHASE,
    MOTION_OF,
    any_of,
    by_words,
    channel_in,
    channel_of,
    holds,
    motion_of,
    motions_in,
    phase_in,
    sequence_of,
    unit_of,
)

if TYPE_CHECKING:
    from breaker.records.channels import Travel
    from breaker.records.header import Header
    from breaker.records.sheet import Sheet

_results_in, _parts_in = by_words(WORDS["results"]), by_words(WORDS["contact parts"])
_heads_in = by_words({each: WORDS[each] for each in ("result_heads", "barred_heads")})
_stated_in = by_words({key: WORDS["stated"][key] for key in ("operation", "phases")})
_LABELS = {key: any_of(words) for key, words in WORDS["labels"].items()}
_BREAK = re.compile(rf"{_LABELS['break']}[\W_]*(\d)", re.I)
_COIL = re.compile(r"\bc(?:oil)?[\W_]*(\d)", re.I)
_TRANSDUCER = re.compile(rf"{_LABELS['transducer']}\W{{0,2}}(\d+)", re.I)
_PHASE = re.compile(rf"({COLUMN_PHASE})[\W_]*{_LABELS['phase behind its letter']}\b", re.I)
_SHARES = re.compile(
    r"(?:from |between )?([\d.]+)\s*%?\s*(?:-|–|\.\.+|to|bis)\s*([\d.]+)\s*%(?: of \w+)?", re.I
)
_NEAR = re.compile(rf"([\d.]+) ?(ms|mm) (before|after) (?:the )?{WORDS['contact_event']}\w*", re.I)
_REMARK = re.compile(r"(?<=\S)\s*[(\[][^()\[\]]*\d[^()\[\]]*[)\]]\s*$")  # such as (max 60 ms)
_LABELLED = re.compile(r"(.*[^\s:=])\s*[:=\s]\s*(?=[-+]?\d)")  # such as R=52.3
_OF_CLOSING = ("over_travel", "wipe", "bounce_time")  # where no motion is stated

# Shares by which a printed value may differ from the measured value, beyond the error of that:
# printed strokes are rounded to 1 mm of 100, and zones of speeds to a sample at each end.
_DIFFERS = {"stroke": 0.01, "speed": 0.03}
_CLOSE = 0.05  # share between strokes that show whether samples are multiplied by the ratio


class Printed(NamedTuple):
    """A result of an analyser.

    Attributes:
        quantity: Key of ``results`` in the lexicon, such as "stroke" or "closing_time".
        motion: "closing" or "opening"; empty where the text does not state it.
        channel: Channel or phase as in the text, such as "CH1", "R" or "2"; empty without one.
        value: Number in its unit.
        unit: Unit as in the text.
        name: Name as in the text.
        part: Contact of the pole: "main", "arcing" or "break 1"; empty where none is named.
        points: Points of a speed, as ``Point.read`` takes them; empty where the name has none.
    """

    quantity: str
    motion: str
    channel: str
    value: float
    unit: str
    name: str
    part: str = ""
    points: tuple[str, ...] = ()

    @property
    def size(self) -> float | None:
        """Size of the unit in mm, ms, A or mm/ms; NaN for an angle, None for a wrong unit."""
        kind = self.quantity.rpartition("_")[2]
        sizes = {"speed": WORDS["speeds"], "current": WORDS["amperes"], "time": TO_MS}
        known = sizes.get(kind, TO_MM | {"deg": math.nan})
        return known.get(unit_of(self.unit) or self.unit.lower()) if self.unit else 1.0

    def speed(self, motion: str, stated: Mapping[str, Speed]) -> Speed | None:
        """Return the definition of a printed speed; None where no two points are stated."""
        if self.quantity != "speed" or not self.points:
            return stated.get(motion) if self.quantity == "speed" else None
        with suppress(ValueError):  # such as from 90 to 10 %
            return Speed.read(f"{motion}_speed", self.points)
        return None


def printed_in(
    lines: Sequence[Line], decimal: str = ".", widths: Mapping[str, tuple[str, ...]] | None = None
) -> tuple[Printed, ...]:
    """Return the results in the lines above the samples.

    Args:
        lines: The lines.
        decimal: Decimal sign.
        widths: Points between which speeds above the columns of contacts are means, by motion.

    >>> from breaker.records.header_pairs import lines_of
    >>> lines = lines_of([["Parameter", "CH1", "CH2"], ["Stroke (mm)", "178.1", "178.4"]])
    >>> [each[:5] for each in printed_in(lines)]
    [('stroke', '', 'CH1', 178.1, 'mm'), ('stroke', '', 'CH2', 178.4, 'mm')]
    """
    above = ([(i, cell.strip()) for i, cell in enumerate(e.cells) if cell.strip()] for e in lines)
    named = ({i: _TRANSDUCER.fullmatch(cell) for i, cell in row} for row in above)
    wired = next((row for row in named if row and all(row.values())), {})
    reader = _Reader(decimal, widths or {}, {i: match[0] for i, match in wired.items()})
    for line in lines:
        reader.read(line)
    fit = (each for each in reader.found if math.isfinite(each.value) and each.size is not None)
    return tuple(dict.fromkeys(fit))


@dataclass
class _Reader:
    """A reader of lines, with the titles and heads of columns that hold for the next line.

    Attributes:
        decimal: Decimal sign.
        widths: As for ``printed_in``.
        wired: Transducers by the place of their cell, in the row that states those of contacts.
    """

    decimal: str
    widths: Mapping[str, tuple[str, ...]]
    wired: Mapping[int, str]

    def __post_init__(self) -> None:
        self.found: list[Printed] = []
        self.title = self.pole = ""  # words of the motion, and of the channel
        self.barred = self.filled = self.apart = False
        self.heads: list[str] = []

    def read(self, line: Line) -> None:
        """Read the next line."""
        tokens = [token for token in line.tokens if token.text]
        if not tokens:
            self.heads, self.apart = [], True
            return
        cells = [cell.lstrip("#%! ").rstrip() for cell in line.cells]
        if sum(map(bool, cells)) == 1:
            cells = [token.text for token in tokens]  # a line that has not been split
        numbers = any(math.isfinite(self._number(cell)[0]) for cell in cells)
        heads = [] if numbers or line.signed else self._heads_of(cells)
        if self.heads and all(unit_of(token.text) for token in tokens):
            heads = [cell and f"({cell})" for cell in cells]
        if len(tokens) == 1 and not numbers:
            self._entitle(tokens[0].text)
        elif self.heads and not line.signed and numbers and sum(map(_names, cells)) < 2:
            self._table(cells)
        else:
            if self.heads and heads:  # below heads of several columns, or a line of units
                above = accumulate([*self.heads, *[""] * len(heads)], lambda a, b: b or a)
                heads = [f"{a} {b}".strip() for a, b in zip(above, heads, strict=False)]
            self.heads = heads
            if not heads:
                self._pairs(tokens, line.signed)

    def _number(self, text: str) -> tuple[float, str]:
        """Return a cell as a number without a remark in brackets, and its unit."""
        numbers, unit = numbers_of([_REMARK.sub("", text)], self.decimal)
        return numbers[0], unit

    def _entitle(self, text: str) -> None:
        """Take a title; one of a section ends the motion and the channel of that before."""
        motion, channel, section = motion_of(text), _channel_in(text), _heads_in(text)
        if motion:
            self.title, self.pole = text, text if channel else ""
        elif channel:
            self.pole = text
        elif section or (self.filled and self.apart):
            self.title, self.pole, self.barred = "", "", "barred_heads" in section
        self.heads, self.filled, self.apart = [], False, False

    def _heads_of(self, cells: Sequence[str]) -> list[str]:
        """Return heads of columns: channels, motions or quantities, or none of these."""
        known = [any((_channel_in(c), motion_of(c), _quantity(c))) for c in cells if c]
        corner = not cells or not cells[0] or bool(_heads_in(cells[0]))
        several = sum(known) > 1 or any(map(_heads_in, cells[1:]))
        headed = any(known) or (cells and cells[0] and corner)
        return [*cells] if headed and several and (corner or all(known)) else []

    def _table(self, cells: Sequence[str]) -> None:
        """Read a line below heads of columns."""
        alone = _channel_in(self.heads[0]) and _quantity(cells[0])  # heads of the channels alone
        heads = [*[""] * bool(alone), *self.heads, *[""] * len(cells)]
        words, unit, values = [], "", []
        for head, cell in zip(heads, cells, strict=False):
            number = self._number(cell)[0]
            label = _heads_in(head) and not _channel_in(head) and not _quantity(head)
            if head.lower().startswith("unit"):
                unit = cell
            elif math.isnan(number):
                words += [cell] if cell and not values else []
            elif label and (channel_of(f"{head} {cell}") or _BREAK.search(f"{head} {cell}")):
                words.append(f"{head} {cell}")
            else:
                values.append((head, number))
        name = next(filter(_quantity, words), "")
        words = [word for word in words if word != name]
        for head, number in values:
            self._add(name or head, [head, *words] if name else words, number, unit)

    def _pairs(self, tokens: Sequence[Token], signed: bool) -> None:
        """Read names with their values."""
        name, words, values = Token("", False, 0), [], []
        for token in [*tokens, Token("", True, 0)]:
            quantity = math.isnan(self._number(token.text)[0]) and _quantity(token.text)
            if token.named and signed and name.text and not quantity and _is_channel(token.text):
                words = [token.text]  # a channel behind the name of a quantity
            elif quantity or (token.named and (signed or not token.text)):
                before = [] if self._values(name, values) or signed else words
                name = token._replace(text=" ".join([*before, token.text]))
                words, values = [], []
            else:
                values.append((" ".join(words), token.text))
                words = [token.text] if math.isnan(self._number(token.text)[0]) else []

    def _values(self, name: Token, values: Sequence[tuple[str, str]]) -> bool:
        """Read the values of a name, one or several that have a label each, if it has numbers."""
        found, units = [], []
        for label, text in values:
            number, unit = self._number(text)
            if (match := _LABELLED.match(text)) and _is_channel(match[1]):
                label, (number, unit) = match[1], self._number(text[match.end() :])
            if math.isfinite(number):
                remark = "".join(_REMARK.findall(text)).strip(" ()[]")
                zone = remark if _points_in(remark)[0] else ""
                known = not label or _channel_in(label) or _part_in(label) or _heads_in(label)
                found += [([label, zone], number)] if known else []
            units.append(unit or (text if found and unit_of(text) else ""))
        if len({label for (label, _), _ in found}) == len(found):
            for labels, number in found:
                self._add(name.text, labels, number, next(filter(None, units), ""), name.place)
        if len(values) == 1 and not _quantity(name.text):  # a name of the lines below
            kinds = _stated_in(name_of(name.text)[0])
            if "operation" in kinds:
                self.title = MOTION_OF.get(sequence_of(values[0][1]), "")
            elif "phases" in kinds and _channel_in(values[0][1]):
                self.pole = f"{name.text} {values[0][1]}"
        return bool(found)

    def _add(self, name: str, labels: Sequence[str], value: float, unit: str, at: int = -1) -> None:
        """Add a result, if its words state what it is and nothing else."""
        points = next(filter(None, (_points_in(each)[0] for each in (name, *labels))), ())
        quantity = _quantity(name)
        others = {kind for each in labels for kind in _results_of(each)[:1]}
        others -= {
            kind for each in labels for kind in _results_of(each) if channel_of(each) and kind
        }
        if self.barred or not quantity or others - {quantity, "contact_time"}:
            return
        self.filled = True
        (bare, own), *more = map(name_of, (name, *labels))
        unit = next(filter(None, (own, *(each[1] for each in more))), unit)
        texts = (quantity.replace("_", " "), name, *labels, self.title)
        motion = next(filter(None, map(motion_of, texts)), "")
        channel = next(filter(None, map(_channel_in, (*labels, bare, self.pole))), "")
        part = next(filter(None, map(_part_in, (*labels, name, self.pole, self.title))), "")
        if quantity == "coil_current" and not (channel or motion):
            channel = found[0] if (found := _COIL.search(bare)) else ""
        elif quantity == "speed" and not (points or channel) and at in self.wired:
            points, channel = self.widths.get(motion, ()), self.wired[at]
        if len(points) > 2:
            points = near_event(motion, *points)
        one = all(len(motions_in(text)) < 2 for text in (name, *labels))
        if one and ((motion and unit) or quantity != "contact_time"):
            self.found.append(Printed(quantity, motion, channel, value, unit, bare, part, points))


def _quantity(text: str) -> str:
    """Return the quantity of a name; empty where it has none, or not one of an operation."""
    return next(iter(_results_of(text)), "")


@lru_cache(maxsize=4096)  # files of a folder have the same names
def _results_of(text: str) -> tuple[str, ...]:
    """Return the meanings of a name as one of results, of which the first counts."""
    bare, unit = name_of(_points_in(text)[1])
    return _results_in(bare) or _results_in(f"{bare} in {unit}")


def _names(text: str) -> bool:
    return bool(_quantity(text))


@lru_cache(maxsize=4096)
def _channel_in(text: str) -> str:
    """Return the channel or phase in a text; a number of its own is a channel."""
    found = channel_in(text) or re.fullmatch(r"\d{1,2}", text.strip()) or _PHASE.match(text)
    return found[0] if found else phase_in(text)


def _is_channel(text: str) -> bool:
    return bool(_channel_in(text)) and not _quantity(text)


def _part_in(text: str) -> str:
    """Return the contact of a pole that a text names, empty where it names none."""
    found = _BREAK.search(text)
    return f"break {found[1]}" if found else next(iter(_parts_in(text)), "")


def _points_in(name: str) -> tuple[tuple[str, ...], str]:
    """Return the points of a speed in a name, and the name without them."""
    found = _SHARES.search(name) or _NEAR.search(name)
    points = found.groups() if found else ()
    points = tuple(f"{each} % of stroke" for each in points) if len(points) == 2 else points
    return points, name.replace(found[0], "") if found else name


def near_event(motion: str, amount: str, unit: str, side: str = "") -> tuple[str, ...]:
    """Return the points between a contact event and an amount before or after it, which is before
    the touch and after the parting unless stated; what is known of them without a motion.
    """
    side = side.lower() or ("before" if motion == "closing" else "after")
    if not (event := EVENTS.get(motion)):
        return amount, unit, side
    points = (f"{amount} {unit.lower()} {side} {event}", event)
    return points if side == "before" else points[::-1]


# ---- comparing -----------------------------------------------------------------------------------


@dataclass(frozen=True)
class PrintedComparison:
    """A result of the analyser, and the same quantity measured in the record.

    Attributes:
        column: Column of the travel; empty where the result belongs to no column of travel.
        motion: "closing" or "opening"; empty where neither is known.
        printed: The result.
        quantity: Name of the measured quantity; empty where there is none.
        zone: Points of a speed, in words; empty for others.
        measured: Measured value in the unit of the result; NaN where it is not measured.
        reason: Reason of that; empty where it is measured.
        sd: Standard deviation of the measured value, in that unit.
    """

    column: str | int
    motion: str
    printed: Printed
    quantity: str = ""
    zone: str = ""
    measured: float = math.nan
    reason: str = ""
    sd: float = 0.0

    @property
    def difference(self) -> float:
        """Share of the printed value by which the measured one differs; NaN without either."""
        value = self.printed.value
        return self.measured / value - 1.0 if value else math.nan

    @property
    def differs(self) -> bool:
        """Whether it does by more than such values do, and than its error is."""
        return differs(self.printed.quantity, self.printed.value, self.measured, self.sd)


def differs(quantity: str, printed: float, measured: float, sd: float) -> bool:
    """Return whether a printed value differs from the measured one by more than such values do and
    more than its error, all in one unit. Makers count other quantities in different ways.

    >>> differs("stroke", 150.0, 135.3, 0.2), differs("stroke", 136.0, 135.3, 0.2)
    (True, False)
    """
    most = _DIFFERS.get(quantity, math.inf) * abs(printed)
    return bool(printed and abs(measured - printed) > most + 2.0 * sd)


def measured_name(printed: Printed, motion: str) -> str:
    """Return the name of the measured quantity of a result; empty where there is none."""
    found = WORDS["measured"].get(printed.quantity, {}).get(motion, "")
    return f"main_{found}" if found.endswith("ing_time") and printed.part == "main" else found


def meant_motions(printed: Printed, motions: Iterable[str]) -> list[str]:
    """Return the motions of a record that a result belongs to: all where it names none, but for an
    over-travel, a wipe and a bounce the closing, where there is one.
    """
    there = list(dict.fromkeys(motions))
    if not printed.motion and printed.quantity in _OF_CLOSING and "closing" in there:
        return ["closing"]
    return [printed.motion] if printed.motion else there


def stated_speeds(stated: Header) -> dict[str, Speed]:
    """Return the speeds between the points that a text states in % of the stroke, by motion."""
    found, points = {}, [(pair.name, *pair.number()) for pair in stated.speed_points]
    units = {e.strip().lower() for pair in stated.speed_points for e in (pair.text, pair.unit)}
    usual = "%" if units & {*WORDS["share_of_stroke"]} else ""  # a unit of all, by itself
    for motion in EVENTS:
        own = [each for each in points if motion_of(each[0]) in (motion, "")]
        shares = [n for _, n, unit in own if (unit or usual) == "%" and math.isfinite(n)]
        if len(shares) == 2 and 0 < shares[0] < shares[1] < 100:
            texts = [f"{share:g} % of stroke" for share in shares]
            found[motion] = Speed.read(f"{motion}_speed", texts)
    return found


def compare_printed(
    layout: Sheet, travels: Sequence[Travel], motions: Sequence
) -> list[PrintedComparison]:
    """Compare the results that a text states with what is measured of every ``InspectedMotion``."""
    speeds, columns = stated_speeds(layout.stated), _columns(layout, travels)
    measured: dict[tuple, dict] = {}
    found = []
    for printed in layout.stated.results:
        if not printed.value:
            continue  # a zero stands for what the analyser has not seen
        own = _own_motions(printed, columns, motions)
        meant = meant_motions(printed, (m.motion for m in own))
        own = [m for m in own if m.motion in meant]
        if not own:
            lost = "its channel is not stated" if not printed.channel else ""
            why = lost or "no motion of it is read" if motions else "a setting is to be filled in"
            found.append(PrintedComparison("", printed.motion, printed, reason=why))
            continue
        motion = next((m for m in own if m.record), own[0])
        speed, record = printed.speed(motion.motion, speeds), motion.record
        key = id(motion), speed
        if record and key not in measured:
            measured[key] = record.measured((speed,) if speed else SPEEDS)
        values = measured.get(key, {})
        name, reason = _counterpart(printed, motion, values)
        if printed.quantity == "speed" and speed is None:
            reason = "between which points is not stated"
        if record is None:
            reason = "the motion is not read"
        about = (motion.column, motion.motion, printed, name, speed.words if speed else "")
        value, sd, why = (math.nan, 0.0, reason) if reason else values[name]
        found.append(PrintedComparison(*about, value / printed.size, why, sd / printed.size))
    return found


def _own_motions(printed: Printed, columns: Mapping[str, str | int], motions: Sequence) -> list:
    """Return the motions of the channel of a result; of a coil those that it starts."""
    own = [m for m in motions if m.column == columns.get(printed.channel.casefold())]
    if own or printed.quantity != "coil_current":
        return own
    fit = [m for m in motions if printed.motion in ("", m.motion)]
    coils = {str(m.beside.settings.get("trigger_column", "")): m for m in fit}
    if number := _COIL.search(printed.channel):
        return [m for coil, m in coils.items() if number[1] in _COIL.findall(coil)]
    return [*coils.values()] if len(coils) == 1 and not printed.channel else []


def _counterpart(printed: Printed, motion, values: Mapping) -> tuple[str, str]:
    """Return the name of the measured quantity of a result, and why it is not compared."""
    name, part = measured_name(printed, motion.motion), printed.part
    if not name:
        return "", WORDS["not measured"].get(printed.quantity, "not measured here")
    apart = any(n.startswith("main_") and not v.reason for n, v in values.items())
    if not name.endswith("ing_time") or not part or (part == "main" and apart):
        return name, "" if name in values else "not measured here"
    contact = str(motion.beside.settings.get("contact_column", ""))
    fits = {"main": not holds(contact, "arcing"), "arcing": apart or holds(contact, "arcing")}
    if fits.get(part, part == _part_in(contact)):
        return name.removeprefix("main_"), ""
    return name, f"it is of another contact than {contact!r}"


def _columns(layout: Sheet, travels: Sequence[Travel]) -> dict[str, str | int]:
    """Return the column of travel of each channel that results name."""
    labels = list(dict.fromkeys(each.channel.casefold() for each in layout.stated.results))
    columns = [layout.column(each.place) for each in travels]
    numbers = [channel_of(layout.names[each.place]) for each in travels]
    by_number = {
        n or order: c for order, (n, c) in enumerate(zip(numbers, columns, strict=True), 1)
    }
    by_phase = {e.phase.casefold(): c for e, c in reversed([*zip(travels, columns, strict=True)])}
    phases = {label: _phase_of(label) for label in labels if label}
    system = any([*phases.values()] == each.lower().split() for each in WORDS["systems"])
    if system and len(phases) == len(columns) and set(by_phase) == {""}:
        by_phase = dict(zip(phases.values(), columns, strict=True))  # all phases, in their order
    alone = {"": columns[0]} if len(columns) == 1 else {}
    found = {
        e: by_number.get(channel_of(e), by_phase.get(p) if p else None) for e, p in phases.items()
    }
    return alone | {label: column for label, column in found.items() if column is not None}


def _phase_of(label: str) -> str:
    found = _PHASE.match(label)
    return (found[1] if found else phase_in(label)).casefold()


def stated_remarks(stated: Header, unit: str, compared: Sequence[PrintedComparison]) -> list[str]:
    """Return what is doubtful about a text, and what to do with a ratio that it states."""
    ratio = stated.ratio
    if math.isnan(ratio) or ratio == 1.0 or unit not in TO_MM:
        return [*stated.doubts]
    size = in_digits(ratio, 6)
    said = f"the text states a linkage ratio of {size}, which is not applied, as samples are {unit}"
    strokes = [1.0 + c.difference for c in compared if c.quantity == "stroke" and not c.reason]
    share = median(strokes) if strokes else math.nan
    why = "compare the stroke with the drive's; if it lacks the ratio, set endurance.format.ratio"
    if abs(share - 1.0) <= _CLOSE:
        why = "and have the printed stroke already"
    elif abs(share * ratio - 1.0) <= _CLOSE:
        why = f"times {size} they have the printed stroke: set endurance.format.ratio to it"
    return [*stated.doubts, f"{said}: {why}"]
