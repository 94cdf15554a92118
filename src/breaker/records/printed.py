"""Results that an analyser printed, and the same quantities measured in the same record.

The words around a number define it: the name in its line, the head of its column, and the titles
above. A result is compared where these words state the quantity and the channel, for a speed the
points, and for a time the contact, if the breaker has several. All other results have a reason.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from statistics import median
from typing import TYPE_CHECKING, NamedTuple

from breaker.common.numerals import in_digits
from breaker.model.quantities import EVENTS, SPEEDS, Speed
from breaker.records.header_pairs import Token, name_of, numbers_of, respelling, tokens_of
from breaker.records.lexicon import WORDS
from breaker.records.settings import TO_MM, TO_MS
from breaker.records.words import (
    COLUMN_PHASE,
    any_of,
    by_words,
    channel_in,
    channel_of,
    holds,
    motion_of,
    motions_in,
    phase_in,
    unit_of,
)

if TYPE_CHECKING:
    from breaker.records.channels import Travel
    from breaker.records.header import Header
    from breaker.records.layout import Layout

_results_in = by_words(WORDS["results"])
_parts_in = by_words(WORDS["contact parts"])
_heads_in = by_words({"head": WORDS["result_heads"]})
_bars = by_words({"bars": WORDS["barred_heads"]})
_BREAK = re.compile(rf"{any_of(WORDS['labels']['break'])}[\W_]*(\d)", re.I)
_PHASE_FIRST = re.compile(
    rf"({COLUMN_PHASE})[\W_]*{any_of(WORDS['labels']['phase behind its letter'])}\b", re.I
)
_COIL = re.compile(r"\bc(?:oil)?[\W_]*(\d)", re.I)
_TRANSDUCER = re.compile(rf"{any_of(WORDS['labels']['transducer'])}\W{{0,2}}(\d+)", re.I)
_SHARES = re.compile(r"([\d.]+)\s*%?\s*(?:-|–|\.\.+|to|bis)\s*([\d.]+)\s*%(?: of \w+)?")
_EVENT = re.compile(rf"([\d.]+) ?(ms|mm) (before|after) (?:the )?(?:{WORDS['contact_event']})\w*")
_REMARK = re.compile(r"(?<=\S)\s*[(\[][^()\[\]]*\d[^()\[\]]*[)\]]\s*$")  # such as (max 60 ms)
_LABELLED = re.compile(r"(.*[^\s:=])\s*[:=\s]\s*(?=[-+]?\d)")

_UNIT_SIZES = {  # mm/ms, A, ms and mm, by the end of a quantity's name
    "speed": {"m/s": 1.0, "mm/ms": 1.0, "cm/s": 1e-2, "mm/s": 1e-3, "ft/s": 0.3048, "in/s": 0.0254}
    | {"rad/s": math.nan, "deg/s": math.nan},
    "current": WORDS["amperes"],
    "time": TO_MS,
    "": TO_MM | {"deg": math.nan},
}
_MEASURED = {
    ("stroke", "closing"): "stroke",
    ("stroke", "opening"): "stroke",
    ("over_travel", "closing"): "over_travel",
    ("over_travel", "opening"): "rebound",
    ("wipe", "closing"): "wipe_at_touch",
    ("wipe", "opening"): "wipe_at_parting",
    ("speed", "closing"): "closing_speed",
    ("speed", "opening"): "opening_speed",
    ("closing_time", "closing"): "closing_time",
    ("opening_time", "opening"): "opening_time",
    ("contact_time", "closing"): "closing_time",
    ("contact_time", "opening"): "opening_time",
    ("bounce_time", "closing"): "bounce_time",
    ("coil_current", "closing"): "coil_current",
    ("coil_current", "opening"): "coil_current",
}
_NOT_MEASURED = {
    "rebound": "makers mean different things by it",
    "mechanism_travel": "the way of the drive before its linkage, which no column shows",
    "datum_speed": "at a point of the maker's, which is not stated",
    "other_speed": "not the mean speed between two stated points",
    "maximum_travel": "not measured here: see the stroke and the over-travel",
    "travel_time": "makers count it between different points",
}
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
        channel: Channel or phase as in the text, such as "CH1", "R" or "2"; empty where the text
            names none.
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
        sizes = next(each for end, each in _UNIT_SIZES.items() if self.quantity.endswith(end))
        return sizes.get(unit_of(self.unit) or self.unit.lower()) if self.unit else 1.0

    def speed(self, motion: str, stated: Mapping[str, Speed]) -> Speed | None:
        """Return the definition of a printed speed; None where its points are not stated."""
        if self.points:
            return Speed.read(f"{motion}_speed", self.points)
        return stated.get(motion)


# ---- reading -------------------------------------------------------------------------------------


def printed_in(
    rows: Sequence[Sequence[str]],
    decimal: str = ".",
    widths: Mapping[str, tuple[str, ...]] | None = None,
) -> tuple[Printed, ...]:
    """Return the results in the lines above the samples.

    Args:
        rows: Cells of each line.
        decimal: Decimal sign.
        widths: Points between which speeds above the columns of contacts are means, by motion.

    >>> rows = [["Parameter", "CH1", "CH2"], ["Stroke (mm)", "178.1", "178.4"]]
    >>> [each[:5] for each in printed_in(rows)]
    [('stroke', '', 'CH1', 178.1, 'mm'), ('stroke', '', 'CH2', 178.4, 'mm')]
    """
    lines = [tokens_of(row) for row in rows]
    right = respelling(
        [name_of(t.text)[0] for tokens, signed in lines if signed for t in tokens if t.named]
    )
    reader = _Lines(decimal, right, widths or {}, _transducers(rows))
    for row, (tokens, signed) in zip(rows, lines, strict=True):
        reader.read(row, [t for t in tokens if t.text], signed)
    fit = (each for each in reader.found if math.isfinite(each.value) and each.size is not None)
    return tuple(dict.fromkeys(fit))


def _transducers(rows: Iterable[Sequence[str]]) -> dict[int, str]:
    """Return the transducers of contacts by the place of their cell in the row that states them."""
    for row in rows:
        cells = {
            i: _TRANSDUCER.fullmatch(cell.strip()) for i, cell in enumerate(row) if cell.strip()
        }
        if cells and all(cells.values()):
            return {i: match[0] for i, match in cells.items()}
    return {}


@dataclass
class _Lines:
    """A reader of lines, with the titles and heads of columns that hold for the next line."""

    decimal: str
    right: Mapping[str, str]
    widths: Mapping[str, tuple[str, ...]]
    transducers: Mapping[int, str]

    def __post_init__(self) -> None:
        self.found: list[Printed] = []
        self.title = self.pole = ""  # words of the motion, and of the channel
        self.barred = self.filled = self.apart = False
        self.heads: list[str] = []

    def read(self, row: Sequence[str], tokens: Sequence[Token], signed: bool) -> None:
        """Read the next line."""
        cells = [
            re.sub(r"^[\W_]+", "", cell.strip()) if i == 0 else cell.strip()
            for i, cell in enumerate(row)
        ]
        if sum(map(bool, cells)) == 1 and len(tokens) > 1:
            cells = [token.text for token in tokens]  # a line that has not been split
        while cells and not cells[-1]:
            cells.pop()
        numbers = [math.isfinite(n) for n in numbers_of(cells, self.decimal)[0]]
        if not tokens:
            self.heads, self.apart = [], True
        elif len(tokens) == 1 and not any(numbers):
            self._entitle(tokens[0].text)
        elif signed:
            self.heads = []
            self._pairs(tokens, signed)
        elif not any(numbers):
            below = self._heads_of(cells)
            above = _spread(self.heads, len(below)) if below else []
            self.heads = (
                [f"{a} {b}".strip() for a, b in zip(above, below, strict=True)]
                if self.heads and below
                else below
            )
            if not below:
                self._pairs(tokens, signed)
        elif self.heads:
            self._table(cells)
        else:
            self._pairs(tokens, signed)

    def _entitle(self, text: str) -> None:
        """Take a title; a title of a section ends the motion and the channel of the one before."""
        self.heads = []
        motion, channel = motion_of(text), _channel_in(text)
        if motion or channel:
            self.title, self.pole = (
                (text, text if channel else "") if motion else (self.title, text)
            )
            self.filled = False
        elif (barred := _bars(text)) or _heads_in(text) or (self.filled and self.apart):
            self.title, self.pole, self.barred = "", "", bool(barred)
        self.apart = False

    def _heads_of(self, cells: Sequence[str]) -> list[str]:
        """Return the heads of columns; none where a line has neither channels nor quantities."""
        texts = [*filter(None, cells)]
        channels = [bool(_channel_in(cell) or _BREAK.search(cell)) for cell in texts]
        named = [
            bool(motions_in(cell)) or bool(_quantity(cell)) or channel
            for cell, channel in zip(texts, channels, strict=True)
        ]
        several = sum(named) > 1 or (
            bool(_heads_in(cells[0])) and any([*named, *map(_heads_in, texts[1:])])
        )
        return (
            list(cells) if several and (not cells[0] or all(named) or _heads_in(cells[0])) else []
        )

    def _table(self, cells: list[str]) -> None:
        """Read a line below heads of columns."""
        heads = self.heads
        if _channel_in(heads[0]) and _quantity(cells[0]):
            heads = ["", *heads]  # names of channels alone, without one of the column of quantities
        heads = [*heads, *[""] * len(cells)][: len(cells)]
        numbers = numbers_of(cells, self.decimal)[0]
        words, unit, values = [], "", []
        for head, cell, number in zip(heads, cells, numbers, strict=True):
            if head.lower().startswith("unit"):
                unit = cell
            elif math.isnan(number) and not values:
                words.append(cell)
            elif math.isfinite(number) and not _quantity(head) and _is_label(head):
                words.append(f"{head} {cell}")
            elif math.isfinite(number):
                values.append((head, number))
        name = next(filter(_quantity, words), "")
        for head, number in values:
            more = [w for w in words if w != name]
            self._add(name or head, [head, *more] if name else more, number, unit)

    def _pairs(self, tokens: Sequence[Token], signed: bool) -> None:
        """Read names with their values."""
        name, words, values = Token("", False, 0), [], []
        for token in [*tokens, Token("", True, 0)]:
            number = numbers_of([_REMARK.sub("", token.text)], self.decimal)[0][0]
            label = _channel_in(token.text) if len(token.text) < 10 else ""
            begins = token.named if signed else False
            begins = (
                begins or not token.text or (math.isnan(number) and bool(_quantity(token.text)))
            )
            if begins and label and name.text and not _quantity(token.text):
                words = [token.text]  # a channel behind the name of a quantity
            elif begins:
                self._pair(name, values)
                text = token.text if values or signed else " ".join([*words, token.text])
                name, words, values = token._replace(text=text), [], []
            else:
                values.append((" ".join(words), token))
                words = [token.text] if math.isnan(number) else []

    def _pair(self, name: Token, values: Sequence[tuple[str, Token]]) -> None:
        """Read the values of a name."""
        bare, unit = name_of(name.text)
        text = self.right.get(bare, bare)
        several = (
            [
                each[0]
                for each in re.findall(
                    rf"\b({COLUMN_PHASE})(?=\s*[/,])|(?<=[/,])\s*({COLUMN_PHASE})\b", text, re.I
                )
            ]
            if "/" in text
            else []
        )
        several = (
            re.findall(rf"(?<![^\W_])({COLUMN_PHASE})(?![^\W_])", text, re.I) if several else []
        )
        found: list[tuple[str, float, str]] = []
        behind = ""
        for label, token in values:
            for part in (
                re.split(r"\s+/\s+|(?<=\d)/(?=\d)", token.text) if several else [token.text]
            ):
                part = _REMARK.sub("", part)
                (number,), own = numbers_of([part], self.decimal)
                if (
                    math.isnan(number)
                    and (match := _LABELLED.match(part))
                    and _channel_in(match[1])
                ):
                    (number,), own = numbers_of([part[match.end() :]], self.decimal)
                    label = match[1]
                if math.isfinite(number):
                    found.append((label, number, own))
                elif len(found) and not behind and unit_of(part):
                    behind = part
        unit = unit or next((own for *_, own in found if own), "") or behind
        if len(several) == len(found) > 1:
            found = [(s, number, own) for s, (_, number, own) in zip(several, found, strict=True)]
            text = re.sub(r"\s*\S*/\S*", "", text)
        if len({label for label, *_ in found}) < len(found):
            found = (
                found[:1]
                if len(found) > 1 and not several and _channel_in(text)
                else []
                if len(found) > 1
                else found
            )
        for label, number, _ in found:
            self._add(text, [label], number, unit, name.place)

    def _add(self, name: str, labels: Sequence[str], value: float, unit: str, at: int = -1) -> None:
        """Add a result, if its words state what it is and nothing else."""
        points, left = _points_in(name)
        for label in labels:
            points = points or _points_in(label)[0]
        quantity, *_ = [*_results_in(left), ""]
        others = [_quantity(label) for label in labels if not channel_of(label)]
        barred = self.barred or any("" in _results_in(_points_in(each)[1]) for each in labels)
        if barred or not quantity or {*others} - {"", quantity}:
            return
        self.filled = True
        bare, own = name_of(name)
        own = next(filter(None, (own, *(name_of(label)[1] for label in labels))), unit)
        texts = (quantity.replace("_", " "), name, *labels, self.title)
        motion = next(filter(None, map(motion_of, texts)), "")
        channel = next(filter(None, map(_channel_in, (*labels, bare, self.pole))), "")
        part = next(filter(None, map(_part_in, (*labels, name, self.pole, self.title))), "")
        if quantity == "coil_current" and not (channel or motion):
            channel = found[0] if (found := _COIL.search(bare)) else ""
        elif quantity == "speed" and not (points or channel) and at in self.transducers:
            points, channel = self.widths.get(motion, ()), self.transducers[at]
        if points and points[-1] in ("before", "after"):
            points = near_event(motion, *points)
        if all(len(motions_in(text)) < 2 for text in (name, *labels)):
            self.found.append(Printed(quantity, motion, channel, value, own, bare, part, points))


def _spread(heads: Sequence[str], width: int) -> list[str]:
    """Return heads of a width, each up to the next one, as a merged cell is."""
    found, last = [], ""
    for i in range(width):
        last = (heads[i] if i < len(heads) else "") or last
        found.append(last)
    return found


def _quantity(text: str) -> str:
    """Return the quantity of a name; empty where it has none, or not one of an operation."""
    return next(iter(_results_in(_points_in(text)[1])), "")


def _is_label(head: str) -> bool:
    """Return whether a column below a head has names of channels, contacts or quantities."""
    return not _channel_in(head) and bool(_heads_in(head))


def _channel_in(text: str) -> str:
    """Return the channel or phase in a text; a number in words of its own is a channel."""
    bare = text.strip()
    found = channel_in(bare) or re.fullmatch(r"\d{1,2}", bare) or _PHASE_FIRST.match(bare)
    return found[0] if found else phase_in(bare)


def _part_in(text: str) -> str:
    """Return the contact of a pole that a text names, empty where it names none."""
    found = _BREAK.search(text)
    return f"break {found[1]}" if found else next(iter(_parts_in(text)), "")


def _points_in(name: str) -> tuple[tuple[str, ...], str]:
    """Return the points of a speed in a name, and the name without them."""
    low = name.lower()
    if found := _SHARES.search(low):
        points = tuple(f"{share} % of stroke" for share in found.groups())
        return points, name[: found.start()] + name[found.end() :]
    if found := _EVENT.search(low):
        return found.groups(), name[: found.start()] + name[found.end() :]
    return (), name


def near_event(motion: str, amount: str, unit: str, side: str = "") -> tuple[str, ...]:
    """Return the points between a contact event and an amount before or after it, which is before
    the touch and after the parting unless stated.
    """
    if not motion:
        return ("", "")
    event = EVENTS[motion]
    side = side or ("before" if motion == "closing" else "after")
    points = (f"{amount} {unit} {side} {event}", event)
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
    most = _DIFFERS.get(quantity, math.inf)
    value = abs(printed)
    return bool(value and abs(measured - printed) > most * value + 2.0 * sd)


def measured_name(printed: Printed, motion: str) -> str:
    """Return the name of the measured quantity of a result; empty where there is none.

    An over-travel is the way beyond the rest after the motion, in an opening called rebound. What
    an analyser calls rebound is another: the way back behind that rest.
    """
    found = _MEASURED.get((printed.quantity, motion), "")
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
    units = {
        each.strip().lower() for pair in stated.speed_points for each in (pair.text, pair.unit)
    }
    usual = "%" if units & {*WORDS["share_of_stroke"]} else ""  # a unit of all, by itself
    for motion in EVENTS:
        amounts = [
            amount
            for name, amount, unit in points
            if motion_of(name) in (motion, "") and (unit or usual) == "%" and math.isfinite(amount)
        ]
        if len(amounts) == 2 and 0 < amounts[0] < amounts[1] < 100:
            found[motion] = Speed.read(
                f"{motion}_speed", [f"{each:g} % of stroke" for each in amounts]
            )
    return found


def compare_printed(
    layout: Layout, travels: Sequence[Travel], motions: Sequence
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
            why = "no motion of it is read" if motions else "a setting is to be filled in"
            if motions and not printed.channel and len(travels) > 1:
                why = "its channel is not stated"
            found.append(PrintedComparison("", printed.motion, printed, reason=why))
            continue
        motion = next((m for m in own if m.record), own[0])
        speed = printed.speed(motion.motion, speeds) if printed.quantity == "speed" else None
        if motion.record and (key := (id(motion), speed)) not in measured:
            measured[key] = motion.record.measured((speed,) if speed else SPEEDS)
        values = measured.get((id(motion), speed), {})
        name, reason = _counterpart(printed, motion, values)
        if printed.quantity == "speed" and speed is None:
            reason = "between which points is not stated"
        if motion.record is None:
            reason = "the motion is not read"
        about = (motion.column, motion.motion, printed, name, speed.words if speed else "")
        value, sd, why = (math.nan, 0.0, reason) if reason else values[name]
        found.append(PrintedComparison(*about, value / printed.size, why, sd / printed.size))
    return found


def _own_motions(printed: Printed, columns: Mapping[str, str | int], motions: Sequence) -> list:
    """Return the motions of the channel of a result; those of a coil by its number."""
    column = columns.get(printed.channel.casefold(), "")
    own = [m for m in motions if m.column == column]
    if printed.quantity != "coil_current" or own:
        return own
    coils = {
        str(m.beside.settings.get("trigger_column", "")): m
        for m in motions
        if not printed.motion or m.motion == printed.motion
    }
    number = _COIL.search(printed.channel)
    if number:
        return [m for coil, m in coils.items() if (n := _COIL.search(coil)) and n[1] == number[1]]
    return [*coils.values()] if len(coils) == 1 and not printed.channel else []


def _counterpart(printed: Printed, motion, values: Mapping) -> tuple[str, str]:
    """Return the name of the measured quantity of a result, or why there is none."""
    name = measured_name(printed, motion.motion)
    why = "" if name in values or not values else "not measured here"
    contact = str(motion.beside.settings.get("contact_column", ""))
    if not name:
        return "", _NOT_MEASURED.get(printed.quantity, "not measured here")
    if not name.endswith("ing_time") or not printed.part:
        return name, why
    apart = any(n.startswith("main_") and not v.reason for n, v in values.items())
    plain = name.removeprefix("main_")
    if printed.part.startswith("break"):
        of = _BREAK.search(contact)
        fits = of is not None and f"break {of[1]}" == printed.part
    elif printed.part == "arcing":
        fits = apart or holds(contact, "arcing")
    elif apart:
        return name, why
    else:
        fits = not holds(contact, "arcing")
    return (plain, "") if fits else ("", f"it is of another contact than {contact!r}")


def _columns(layout: Layout, travels: Sequence[Travel]) -> dict[str, str | int]:
    """Return the column of travel of each channel that results name."""
    labels = list(dict.fromkeys(each.channel.casefold() for each in layout.stated.results))
    columns = [layout.column(each.place) for each in travels]
    by_number, by_phase = {}, {}
    for order, (each, column) in enumerate(zip(travels, columns, strict=True), start=1):
        by_number[channel_of(layout.names[each.place]) or order] = column
        by_phase.setdefault(each.phase.casefold() or None, column)
    meant = {
        label: by_number.get(channel_of(label), by_phase.get(_bare_phase(label)))
        for label in labels
    }
    found = {label: column for label, column in meant.items() if column is not None}
    if len(columns) == 1 and "" in labels:
        found[""] = columns[0]
    phases = [label for label in labels if label]
    system = any([*map(_bare_phase, phases)] == each.lower().split() for each in WORDS["systems"])
    # All phases of a system, as many as travels of which none has a phase, stand in their order.
    return found or (
        dict(zip(phases, columns, strict=True))
        if system and len(phases) == len(columns) and not any(by_phase)
        else {}
    )


def _bare_phase(label: str) -> str | None:
    found = _PHASE_FIRST.match(label.strip())
    return (found[1] if found else phase_in(label)).casefold() or None


def stated_remarks(stated: Header, unit: str, compared: Sequence[PrintedComparison]) -> list[str]:
    """Return what is doubtful about a text, and what to do with a ratio that it states."""
    ratio = stated.ratio
    if math.isnan(ratio) or ratio == 1.0 or unit not in TO_MM:
        return [*stated.doubts]
    size = in_digits(ratio, 6)
    said = f"the text states a linkage ratio of {size}, which is not applied, as samples are {unit}"
    strokes = [
        1.0 + c.difference
        for c in compared
        if c.printed.quantity == "stroke" and math.isfinite(c.measured)
    ]
    share = median(strokes) if strokes else math.nan
    why = "compare the stroke with the drive's; if it lacks the ratio, set endurance.format.ratio"
    if abs(share - 1.0) <= _CLOSE:
        why = "and have the printed stroke already"
    elif abs(share * ratio - 1.0) <= _CLOSE:
        why = f"times {size} they have the printed stroke: set endurance.format.ratio to it"
    return [*stated.doubts, f"{said}: {why}"]
