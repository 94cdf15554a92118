"""Results that an analyser printed, and the same quantities measured in the same record.

The words around a number define it: the name in its line, the head of its column, and the titles
above. A result is compared where these words state the quantity and the channel, for a speed the
points, and for a time the contact, if the pole has several. All other results have a reason.
"""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

from breaker.common.numerals import in_digits
from breaker.model.quantities import EVENTS, SPEEDS, Speed
from breaker.records.header_pairs import Line, Token, name_of, number_of, pairs_of
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
_stated_in = by_words(
    {key: WORDS["stated"][key] for key in ("operation", "phases", "width of speed")}
)
_LABELS = {key: any_of(words) for key, words in WORDS["labels"].items()}
_BREAK = re.compile(rf"{_LABELS['break']}[\W_]*(\d)", re.I)
_PHASE = re.compile(rf"({COLUMN_PHASE})[\W_]*{_LABELS['phase behind its letter']}\b", re.I)
_SHARES = re.compile(
    r"(?:from |between )?([\d.]+)\s*%?\s*(?:-|–|\.\.+|to|bis)\s*([\d.]+)\s*%(?: of \w+)?", re.I
)
_NEAR = re.compile(rf"([\d.]+) ?(ms|mm) (before|after) (?:the )?{WORDS['contact_event']}\w*", re.I)
_REMARK = re.compile(r"(?<=\S)\s*[(\[]([^()\[\]]*\d[^()\[\]]*)[)\]]\s*$")  # such as (max 60 ms)

# Shares by which a printed value may differ from the measured value, beyond the error of that:
# printed strokes are rounded to 1 mm of 100, and zones of speeds to a sample at each end.
_DIFFERS = {"stroke": 0.01, "speed": 0.03}


class Printed(NamedTuple):
    """A result of an analyser; motion, channel, part and points are empty where none is stated.

    Attributes:
        quantity: Key of ``results`` in the lexicon, such as "stroke" or "closing_time".
        motion: "closing" or "opening".
        channel, unit, name: As in the text.
        value: Number in its unit.
        part: Contact of the pole: "main", "arcing" or "break 1".
        points: Points of a speed, as ``Point.read`` takes them, with {event} for touch or parting.
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
        """Size of the unit in mm, ms, A or mm/ms; NaN for an angle, None without a fit unit."""
        kind = self.quantity.rpartition("_")[2]
        sizes = {"speed": WORDS["speeds"], "current": WORDS["amperes"], "time": TO_MS}
        known = sizes.get(kind, TO_MM | {"deg": math.nan})
        return known.get(unit_of(self.unit) or self.unit.lower())

    def speed(self, motion: str, stated: Mapping[str, Speed]) -> Speed | None:
        """Return the definition of a printed speed; None where no two points are stated."""
        if self.quantity != "speed" or not self.points:
            return stated.get(motion) if self.quantity == "speed" else None
        with suppress(ValueError):  # such as from 90 to 10 %
            return _speed(motion, self.points)
        return None


def printed_in(lines: Sequence[Line], decimal: str = ".") -> tuple[Printed, ...]:
    """Return the results in the lines above the samples; none of several with the same words.

    >>> from breaker.records.header_pairs import lines_of
    >>> lines = lines_of([["Parameter", "CH1", "CH2"], ["Stroke (mm)", "178.1", "178.4"]])
    >>> [each[:5] for each in printed_in(lines)]
    [('stroke', '', 'CH1', 178.1, 'mm'), ('stroke', '', 'CH2', 178.4, 'mm')]
    """
    reader = _Reader(decimal)
    for line in lines:
        reader.read(line)
    found = [each for each in dict.fromkeys(reader.found) if each.size is not None]
    keys = [(*each[:3], *each[6:]) for each in found]
    counts = Counter(keys)
    return tuple(each for each, key in zip(found, keys, strict=True) if counts[key] == 1)


class _Reader:
    """A reader of lines, with the titles and heads of columns that hold for the next line."""

    def __init__(self, decimal: str) -> None:
        self.decimal = decimal
        self.found: list[Printed] = []
        self.title = self.pole = ""  # words of the motion, and of the channel
        self.barred = False  # whether the title is of limits
        self.heads: dict[int, str] = {}  # by the place of their column

    def read(self, line: Line) -> None:
        """Read the next line."""
        tokens = [token for token in line.tokens if token.text]
        numbers = any(math.isfinite(self._number(token.text)[0]) for token in tokens)
        if len(tokens) == 1 and not numbers:
            self._entitle(tokens[0].text)
        heads = {} if numbers or line.signed else self._heads_of(tokens)
        names = sum(bool(_quantity(token.text)) for token in tokens)
        if heads or not numbers or line.signed or names > 1:
            self.heads = heads
        if not heads:
            self._values(tokens, line.signed)
        for pair in pairs_of([line]):
            kinds = _stated_in(pair.name)
            if "operation" in kinds:
                self.title = MOTION_OF.get(sequence_of(pair.text), "")
            elif "phases" in kinds and _channel_in(pair.text):
                self.pole = f"{pair.name} {pair.text}"

    def _number(self, text: str) -> tuple[float, str]:
        """Return a cell as a number without a remark in brackets, and its unit."""
        return number_of(_REMARK.sub("", text), self.decimal)

    def _entitle(self, text: str) -> None:
        """Take a title: of a motion or a channel, or of a section, which ends both."""
        motion, channel = motion_of(text), _channel_in(text)
        if motion:
            self.title, self.pole = text, text if channel else ""
        elif channel:
            self.pole = text
        else:
            self.title, self.pole, self.barred = "", "", "barred_heads" in _heads_in(text)

    def _heads_of(self, tokens: Sequence[Token]) -> dict[int, str]:
        """Return heads of columns with those above; none if cells are something else."""
        if self.heads and tokens and all(unit_of(token.text) for token in tokens):
            units = {token.place: f"({token.text})" for token in tokens}
            return {place: f"{head} {units.get(place, '')}" for place, head in self.heads.items()}
        known = [any((_channel_in(t), motion_of(t), _quantity(t))) for t, *_ in tokens]
        first = tokens[0] if tokens else Token("", False, 0)
        corner = bool(_heads_in(first.text)) or (first.place > 0 and any(known))
        if len(tokens) < 2 or not (corner or all(known)):
            return {}
        shift = int(not corner)  # heads of the channels alone
        heads = dict(self.heads)
        for text, _, place in tokens:
            above = [head for at, head in self.heads.items() if at <= place][-1:]
            heads[place + shift] = " ".join([*above, text])
        return heads

    def _values(self, tokens: Sequence[Token], signed: bool) -> None:
        """Read names with their values, or those of columns."""
        name, words, unit, filled = "", [], "", False
        behind = [*(token.text for token in tokens[1:]), ""]
        for (text, named, place), after in zip(tokens, behind, strict=False):
            head, (number, own) = self.heads.get(place, ""), self._number(text)
            label = f"{head} {text}" if _heads_in(head) and not _channel_in(head) else ""
            if math.isnan(number) or not head or _quantity(head):
                label = ""  # such as that of a column of poles
            if _channel_in(label) or _BREAK.search(label):
                words.append(label)
            elif math.isfinite(number):
                own = own or unit or (after if unit_of(after) else "")
                zones = [each for each in _REMARK.findall(text) if _points_in(each)[0]]
                if all(_channel_in(w) or _part_in(w) or _heads_in(w) for w in words):
                    self._add(name or head, [*words, *zones, head if name else ""], number, own)
                filled = True
            elif head.lower().startswith("unit"):
                unit = text
            elif _quantity(text) or (named and signed and not _channel_in(text)):
                name = " ".join([*([] if filled or signed else words), text])
                words, filled = [], False
            elif named or not (filled and unit_of(text)):
                words = [word for word in words if not _channel_in(word)] + [text]

    def _add(self, name: str, labels: Sequence[str], value: float, unit: str) -> None:
        """Add a result, if its words state what it is and nothing else."""
        texts, quantity = (name, *labels), _quantity(name)
        kinds = {
            kind for t in labels for kind in _results_of(t)[:1] if not (kind and channel_of(t))
        }
        motions = {each for t in (quantity.replace("_", " "), *texts) for each in motions_in(t)}
        motions |= {motion_of(text) for text in texts} - {""}
        if self.barred or not quantity or kinds - {quantity, "contact_time"} or len(motions) > 1:
            return
        (bare, own), *more = map(name_of, texts)
        unit = next(filter(None, (own, *(each[1] for each in more))), unit)
        motion = motions.pop() if motions else motion_of(self.title)
        if quantity == "contact_time" and not (motion and unit):
            return
        channel = next(filter(None, map(_channel_in, (*labels, bare, self.pole))), "")
        part = next(filter(None, map(_part_in, (*labels, name, self.pole, self.title))), "")
        points = next(filter(None, (_points_in(text)[0] for text in texts)), ())
        self.found.append(Printed(quantity, motion, channel, value, unit, bare, part, points))


def _quantity(text: str) -> str:
    """Return the quantity of a name; empty where it has none, or not one of an operation."""
    return next(iter(_results_of(text)), "")


def _results_of(text: str) -> tuple[str, ...]:
    """Return the meanings of a name as one of results, of which the first counts."""
    bare, unit = name_of(_points_in(text)[1])
    return _results_in(bare) or _results_in(f"{bare} in {unit}")


def _channel_in(text: str) -> str:
    """Return the channel or phase in a text; a number of its own is a channel."""
    found = channel_in(text) or re.fullmatch(r"\d{1,2}", text.strip()) or _PHASE.match(text)
    return found[0] if found else phase_in(text)


def _part_in(text: str) -> str:
    """Return the contact of a pole that a text names, empty where it names none."""
    found = _BREAK.search(text)
    return f"break {found[1]}" if found else next(iter(_parts_in(text)), "")


def _points_in(name: str) -> tuple[tuple[str, ...], str]:
    """Return the points of a speed in a name, and the name without them."""
    if found := _SHARES.search(name):
        return tuple(f"{share} % of stroke" for share in found.groups()), name.replace(found[0], "")
    if found := _NEAR.search(name):
        amount, unit, side = (each.lower() for each in found.groups())
        points = _near_event(f"{amount} {unit} {side}")
        return points, name.replace(found[0], "")
    return (), name


def _near_event(place: str) -> tuple[str, ...]:
    """Return the points between a contact event and a place before or after it."""
    points = (f"{place} {{event}}", "{event}")
    return points if place.endswith("before") else points[::-1]


# ---- comparing -----------------------------------------------------------------------------------


@dataclass(frozen=True)
class PrintedComparison:
    """A result of the analyser, and the same quantity measured, in the unit of the result.

    Column and quantity are empty where it has none, and the value is NaN where a reason is given.
    """

    column: str | int
    motion: str
    printed: Printed
    quantity: str = ""
    zone: str = ""
    measured: float = math.nan
    reason: str = ""
    sd: float = math.nan

    @property
    def difference(self) -> float:
        """Share of the printed value by which the measured one differs."""
        return self.measured / self.printed.value - 1.0

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


def measured_name(printed: Printed, motion: str, contact: str | int | None = None) -> str:
    """Return the name of the measured quantity of a result; empty where there is none.

    A time of one contact of several is that of the column of that contact, or of a resistance,
    which shows main and arcing contact apart.
    """
    name = WORDS["measured"].get(printed.quantity, {}).get(motion, "")
    contact = str(contact or "")
    if not name.endswith("ing_time") or printed.part in ("", _part_in(contact)):
        return name
    if printed.part == "main":
        return f"main_{name}"
    return name if printed.part == "arcing" and holds(contact, "resistance") else ""


def meant_motions(printed: Printed, motions: Iterable[str]) -> list[str]:
    """Return the motions of a record that a result belongs to: all where it names none, but for an
    over-travel, a wipe and a bounce the closing, where there is one.
    """
    there = list(dict.fromkeys(motions))
    of_closing = printed.quantity in ("over_travel", "wipe", "bounce_time") and "closing" in there
    return [printed.motion] if printed.motion else ["closing"] if of_closing else there


def stated_speeds(stated: Header) -> dict[str, Speed]:
    """Return the speeds by motion, between two points that a text states in % of the stroke, or
    else between the contact event and an amount with a unit.
    """
    found, shares_of = {}, {*WORDS["share_of_stroke"]}
    usual = "%" if any({p.text.strip(), p.unit} & shares_of for p in stated.speed_points) else ""
    for motion in EVENTS:
        shares, widths = [], []
        for pair in stated.speed_points:
            number, unit = pair.number()
            if "width of speed" in _stated_in(pair.name):
                own = motion[:4] in pair.name.lower() and unit in ("ms", "mm") and number > 0
                widths += [f"{number:g} {unit}"] if own else []
            elif motion_of(pair.name) in (motion, "") and (unit or usual) == "%":
                shares += [number] if math.isfinite(number) else []
        if len(shares) == 2 and not widths and 0 < shares[0] < shares[1] < 100:
            found[motion] = _speed(motion, [f"{share:g} % of stroke" for share in shares])
        elif len(widths) == 1 and not shares:
            side = "before" if motion == "closing" else "after"
            found[motion] = _speed(motion, _near_event(f"{widths[0]} {side}"))
    return found


def _speed(motion: str, points: Sequence[str]) -> Speed:
    points = [point.format(event=EVENTS[motion]) for point in points]
    return Speed.read(f"{motion}_speed", points)


def compare_printed(
    layout: Sheet, travels: Sequence[Travel], motions: Sequence
) -> list[PrintedComparison]:
    """Compare the results that a text states with what is measured of every ``InspectedMotion``."""
    speeds, columns = stated_speeds(layout.stated), _columns(layout, travels)
    found = []
    for printed in layout.stated.results:
        if not printed.value:
            continue  # a zero stands for what the analyser has not seen
        column = columns.get(printed.channel.casefold())
        own = [m for m in motions if m.column == column]
        meant = meant_motions(printed, (m.motion for m in own))
        own = [m for m in own if m.motion in meant]
        if len(own) > 1 and len({m.motion for m in own}) == 1:
            why = f"of which of {len(own)} motions it is, is not stated"
        elif not own:
            why = "no motion of it is read" if column else "its channel is not stated"
            why = why if motions else "a setting is to be filled in"
        else:
            motion = next((m for m in own if m.record), own[0])
            found.append(_compared(printed, motion, speeds))
            continue
        found.append(PrintedComparison("", printed.motion, printed, reason=why))
    return found


def _compared(printed: Printed, motion, speeds: Mapping[str, Speed]) -> PrintedComparison:
    """Compare a result with what is measured of a motion."""
    speed, record = printed.speed(motion.motion, speeds), motion.record
    contact = str(motion.beside.get("contact_column", ""))
    name = measured_name(printed, motion.motion, contact)
    about = (motion.column, motion.motion, printed, name, speed.words if speed else "")
    if printed.quantity == "speed" and speed is None:
        return PrintedComparison(*about, reason="between which points is not stated")
    if not name:
        other = f"it is of another contact than {contact!r}" if printed.part else ""
        reason = WORDS["not measured"].get(printed.quantity, other or "not measured here")
        return PrintedComparison(*about, reason=reason)
    if record is None:
        return PrintedComparison(*about, reason="the motion is not read")
    values = record.measured((speed,) if speed else SPEEDS)
    if name not in values:
        return PrintedComparison(*about, reason="not measured here")
    value, sd, reason = values[name]
    return PrintedComparison(*about, value / printed.size, reason, sd / printed.size)


def _columns(layout: Sheet, travels: Sequence[Travel]) -> dict[str, str | int]:
    """Return the column of travel of each channel that results name, by its phase or number."""
    labels = {each.channel.casefold() for each in layout.stated.results}
    found = {}
    for label in labels - {""}:
        number, phase = channel_of(label), _phase_of(label)
        for travel in travels:
            of_name = channel_of(layout.names[travel.place])
            if (number and number == of_name) or (phase and phase == travel.phase.casefold()):
                found.setdefault(label, []).append(layout.column(travel.place))
    known = {label: columns[0] for label, columns in found.items() if len(columns) == 1}
    if len(travels) == 1 and len(labels) == 1:
        known |= dict.fromkeys(labels, layout.column(travels[0].place))
    return known


def _phase_of(label: str) -> str:
    found = _PHASE.match(label)
    return (found[1] if found else phase_in(label)).casefold()


def stated_remarks(stated: Header, unit: str) -> list[str]:
    """Return what is doubtful about a text, and what to do with a ratio that it states."""
    ratio = stated.ratio
    if math.isnan(ratio) or ratio == 1.0 or unit not in TO_MM:
        return [*stated.doubts]
    said = f"the text states a linkage ratio of {in_digits(ratio, 6)}, which is not applied, as "
    how = (
        "compare the stroke with the printed one; if it lacks the ratio, set endurance.format.ratio"
    )
    return [*stated.doubts, f"{said}samples are {unit}: {how}"]
