"""Results that an analyser printed, and the same quantities measured in the same record.

The words around a number define it: the name in its line, the head of its column, and the titles
above. A result is compared where these words state the quantity, the channel and the motion, and a
speed where its name, a remark behind it, or the text for all speeds states its points. Results of
one contact of several, and those with anything else in their words, are left out.
"""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple

from breaker.model.quantities import EVENTS, SPEEDS, Speed
from breaker.records import words
from breaker.records.header_pairs import Line, Token, name_of, number_of, pairs_of
from breaker.records.settings import TO_MM, TO_MS
from breaker.records.words import WORDS

if TYPE_CHECKING:
    from breaker.records.channels import Travel
    from breaker.records.description import InspectedMotion
    from breaker.records.header import Header
    from breaker.records.sheet import Sheet

_meanings = words.by_words(WORDS["results"])
_heads_in = words.by_words({each: WORDS[each] for each in ("result_heads", "barred_heads")})
_stated_in = words.by_words({key: WORDS["stated"][key] for key in ("operation", "phases")})
_BEHIND, _BREAK = (words.any_of(WORDS["labels"][e]) for e in ("phase behind its letter", "break"))
_PHASE = re.compile(rf"({words.COLUMN_PHASE})[\W_]*{_BEHIND}\b", re.I)
_PART = re.compile(
    "|".join([rf"{_BREAK}[\W_]*\d", *map(words.any_of, WORDS["contact parts"].values())]), re.I
)
_SHARES = re.compile(
    r"(?:from |between )?([\d.]+)\s*%?\s*(?:-|–|\.\.+|to|bis)\s*([\d.]+)\s*%(?: of \w+)?", re.I
)
_NEAR = re.compile(rf"([\d.]+ ?m[ms]) (before|after) (?:the )?{WORDS['contact_event']}\w*", re.I)
_REMARK = re.compile(r"(?<=\S)\s*[(\[]([^()\[\]]*\d[^()\[\]]*)[)\]]\s*$")  # such as (max 60 ms)

# Shares by which a printed value may differ from the measured value, beyond the error of that:
# printed strokes are rounded to 1 mm of 100, and zones of speeds to a sample at each end.
_DIFFERS = {"stroke": 0.01, "speed": 0.03}


class Printed(NamedTuple):
    """A result of an analyser; motion, channel and points are empty where none is stated.

    Attributes:
        quantity: Key of ``results`` in the lexicon, such as "stroke" or "closing_time".
        motion: "closing" or "opening".
        channel, unit, name: As in the text.
        value: Number in its unit.
        points: Points of a speed, as ``Speed.read`` takes them, with {event} for the contact event.
    """

    quantity: str
    motion: str
    channel: str
    value: float
    unit: str
    name: str
    points: tuple[str, ...] = ()

    @property
    def size(self) -> float | None:
        """Size of the unit in mm, ms, A or mm/ms; NaN for an angle, None without a fit unit."""
        kind = self.quantity.rpartition("_")[2]
        sizes = {"speed": WORDS["speeds"], "current": WORDS["amperes"], "time": TO_MS}
        known = sizes.get(kind, TO_MM | {"deg": math.nan})
        return known.get(words.unit_of(self.unit) or self.unit.lower())

    def speed(self, motion: str, stated: Mapping[str, Speed]) -> Speed | None:
        """Return the definition of a printed speed; None where no two points are stated."""
        if self.quantity != "speed" or not self.points:
            return stated.get(motion) if self.quantity == "speed" else None
        with suppress(ValueError):  # such as from 90 to 10 %
            points = [point.format(event=EVENTS[motion]) for point in self.points]
            return Speed.read(f"{motion}_speed", points)
        return None


def printed_in(lines: Iterable[Line], decimal: str = ".") -> tuple[Printed, ...]:
    """Return the results in the lines above the samples; none of several with the same words."""
    reader = _Reader(decimal)
    for line in lines:
        reader.read(line)
    found = [each for each in dict.fromkeys(reader.found) if each.size is not None]
    counts = Counter((*each[:3], each.points) for each in found)
    return tuple(each for each in found if counts[*each[:3], each.points] == 1)


@dataclass
class _Reader:
    """A reader of lines, with what titles and heads of columns state for the next line."""

    decimal: str
    found: list[Printed] = field(default_factory=list)
    heads: Mapping[int, str] = field(default_factory=dict)  # by the place of their column
    motion: str = ""
    channel: str = ""
    barred: bool = False  # whether the title is of limits, or of one contact of several

    def read(self, line: Line) -> None:
        """Read the next line."""
        tokens = [token for token in line.tokens if token.text]
        numbers = any(math.isfinite(self._number(token.text)[0]) for token in tokens)
        several = sum(bool(_meaning(token.text)) for token in tokens) > 1
        if line.signed or several or not numbers:
            self.heads = {} if line.signed else _heads_of(tokens, self.heads)
        if numbers:
            self._values(tokens, line.signed)
        elif len(tokens) == 1:
            self._entitle(tokens[0].text, line.signed)
        for pair in pairs_of([line]):
            kinds = _stated_in(pair.name)
            if "operation" in kinds:
                self.motion = words.MOTION_OF.get(words.sequence_of(pair.text), "")
            elif "phases" in kinds:
                self.channel = _channel_in(pair.text) or self.channel

    def _number(self, text: str) -> tuple[float, str]:
        """Return a cell as a number without a remark in brackets, and its unit."""
        return number_of(_REMARK.sub("", text), self.decimal)

    def _entitle(self, text: str, signed: bool) -> None:
        """Take a title: of a motion or a channel, or of a section, which ends both."""
        motion, channel = words.motion_of(text), _channel_in(text)
        if _meaning(text) is not None:  # such as a name whose value is blank
            motion = channel = ""
        if not (motion or channel):
            barred = "barred_heads" in _heads_in(text) and not name_of(text)[1]
            self.barred = barred or bool(_PART.search(text)) or (self.barred and signed)
        self.motion, self.channel = motion or (self.motion if channel else ""), channel

    def _values(self, tokens: Sequence[Token], signed: bool) -> None:
        """Read names with their values, or those of columns."""
        name, unit, labels, filled = "", "", [], False
        for token, after in zip(tokens, [*tokens[1:], Token("", False, 0)], strict=True):
            text = token.text
            number, own = self._number(text)
            if math.isfinite(number):
                zones = [remark for remark in _REMARK.findall(text) if _points_in(remark)[0]]
                around = [name, *labels, *zones, self.heads.get(token.place, "")]
                behind = after.text if words.unit_of(after.text) else ""
                if all(map(_is_known, labels)):
                    self._add([*filter(None, around)], number, own or unit or behind)
                filled = True
            elif _meaning(text) or (token.named and signed and not _channel_in(text)):
                labels = [] if filled or signed else labels
                name, unit, filled = text, "", False
            elif _channel_in(text):
                labels = [*(label for label in labels if not _channel_in(label)), text]
            elif words.unit_of(text):
                unit = unit if filled else text
            else:
                labels.append(text)

    def _add(self, texts: Sequence[str], value: float, unit: str) -> None:
        """Add a result, if the words around it state what it is and nothing else."""
        subject = next(filter(_meaning, texts), "")
        quantity, others = _meaning(subject), [text for text in texts if text != subject]
        meanings = ((_meaning(text), words.channel_of(text)) for text in others)
        kinds = {kind for kind, channel in meanings if not (kind and channel)}
        if self.barred or not quantity or kinds - {None, quantity, "contact_time"}:
            return
        around = " ".join([quantity.replace("_", " "), *texts])
        motions = words.motions_in(around)
        if len(motions) > 1 or _PART.search(around):
            return
        motion = motions[0] if motions else self.motion
        bare, first = name_of(subject)
        unit = next(filter(None, (first, *(name_of(text)[1] for text in others))), unit)
        channel = next(filter(None, map(_channel_in, (*others, bare))), self.channel)
        points = next(filter(None, (_points_in(text)[0] for text in texts)), ())
        misplaced = points and quantity != "speed"  # such as a time between two points
        if not misplaced and (quantity != "contact_time" or (motion and unit)):
            self.found.append(Printed(quantity, motion, channel, value, unit, bare, points))


def _heads_of(tokens: Sequence[Token], above: Mapping[int, str]) -> dict[int, str]:
    """Return heads of columns with those above; none if cells are something else."""
    if above and len(tokens) > 1 and all(words.unit_of(token.text) for token in tokens):
        units = {token.place: f"({token.text})" for token in tokens}
        return {place: f"{head} {units.get(place, '')}" for place, head in above.items()}
    behind_blank = bool(tokens) and tokens[0].place > 0 and any(_is_known(t.text) for t in tokens)
    if len(tokens) < 2 or not (behind_blank or _heads_in(tokens[0].text)):
        return {}
    heads = dict(above)
    for text, _, place in tokens:
        over = [head for at, head in above.items() if at <= place][-1:]
        heads[place] = " ".join([*over, text])
    return heads


def _is_known(label: str) -> bool:
    """Return whether the words of a label are of a kind that a result may have."""
    kinds = _channel_in(label), _heads_in(label), words.motion_of(label)
    return any(kinds) or _meaning(label) is not None


def _meaning(text: str) -> str | None:
    """Return the quantity of a name; empty where it is not one of an operation, None without any
    meaning.
    """
    bare, unit = name_of(_points_in(text)[1])
    meanings = _meanings(bare) or _meanings(f"{bare} in {unit}")
    return meanings[0] if meanings else None


def _channel_in(text: str) -> str:
    """Return the channel or phase in a text."""
    found = words.CHANNEL.search(text) or _PHASE.match(text)
    return found[0].strip() if found else words.phase_in(text)


def _points_in(name: str) -> tuple[tuple[str, ...], str]:
    """Return the points of a speed in a name, and the name without them."""
    if found := _SHARES.search(name):
        return tuple(f"{share} % of stroke" for share in found.groups()), name.replace(found[0], "")
    if found := _NEAR.search(name):
        points = (f"{found[1]} {found[2]} {{event}}".lower(), "{event}")
        points = points if found[2].lower() == "before" else points[::-1]
        return points, name.replace(found[0], "")
    return (), name


@dataclass(frozen=True)
class PrintedComparison:
    """A result of the analyser, and the same quantity measured, in the unit of the result.

    Column and quantity are empty where it has none, and the value is NaN where a reason is given.
    """

    column: str | int
    motion: str
    printed: Printed
    quantity: str = ""
    measured: float = math.nan
    reason: str = ""
    differs: bool = False  # by more than such values do, and than its error is

    @property
    def difference(self) -> float:
        """Share of the printed value by which the measured one differs."""
        return self.measured / self.printed.value - 1.0


def differs(quantity: str, printed: float, measured: float, sd: float) -> bool:
    """Return whether a printed value differs from the measured one by more than such values do and
    more than its error, all in one unit. Makers count other quantities in different ways.
    """
    most = _DIFFERS.get(quantity, math.inf) * abs(printed)
    return bool(printed and abs(measured - printed) > most + 2.0 * sd)


def measured_name(printed: Printed, motion: str) -> str:
    """Return the name of the measured quantity of a result; empty where there is none."""
    return WORDS["measured"].get(printed.quantity, {}).get(motion, "")


def meant_motions(printed: Printed, motions: Iterable[str]) -> list[str]:
    """Return the motions of a record that a result is of. Where none is stated, a stroke is of all,
    an over-travel, a wipe and a bounce of the closing, and any other result of the only one.
    """
    there = list(dict.fromkeys(motions))
    if printed.motion:
        return [printed.motion]
    if printed.quantity in ("over_travel", "wipe", "bounce_time") and "closing" in there:
        return ["closing"]
    return there if printed.quantity == "stroke" or len(there) == 1 else []


def stated_speeds(stated: Header) -> dict[str, Speed]:
    """Return the speeds by motion, between two points that a text states in % of the stroke."""
    found, shares_of = {}, {*WORDS["share_of_stroke"]}
    usual = "%" if any({p.text.strip(), p.unit} & shares_of for p in stated.speed_points) else ""
    for motion in EVENTS:
        own = [p.number() for p in stated.speed_points if words.motion_of(p.name) in (motion, "")]
        shares = [number for number, unit in own if number > 0 and (unit or usual) == "%"]
        if len(shares) == 2 and shares[0] < shares[1] < 100:
            points = [f"{share:g} % of stroke" for share in shares]
            found[motion] = Speed.read(f"{motion}_speed", points)
    return found


def results_of(
    stated: Header, motions: Sequence[str], phases: Sequence[str], speeds: Sequence[Speed]
) -> dict[tuple[str, str, str], tuple[float, str]]:
    """Return the results that a text states, by motion, phase and name: value, and its quantity.

    Args:
        stated: The text.
        motions, phases: Of the records of the file; a channel that is no phase is one by its place.
        speeds: Definitions; a speed between other points is left out.
    """
    defined, zones, found = {speed.name: speed for speed in speeds}, stated_speeds(stated), {}
    for printed in stated.results:
        phase = words.phase_in(printed.channel) or printed.channel
        place = words.channel_of(printed.channel) - 1
        if phase not in phases and 0 <= place < len(phases):
            phase = phases[place]
        for motion in meant_motions(printed, motions):
            name, speed = measured_name(printed, motion), printed.speed(motion, zones)
            alike = printed.quantity != "speed" or speed == defined.get(name)
            if name and alike and not math.isnan(printed.size):
                value = printed.value * printed.size, printed.quantity
                found.setdefault((motion, phase, name), value)
    return found


def compare_printed(
    layout: Sheet, travels: Sequence[Travel], motions: Sequence[InspectedMotion]
) -> list[PrintedComparison]:
    """Compare the results that a text states with what is measured. A zero stands for what the
    analyser has not seen; a stroke is compared with the closest of the motions that it may be of.
    """
    speeds, results, found = stated_speeds(layout.stated), layout.stated.results, []
    alone = len(travels) == len({printed.channel for printed in results}) == 1
    for printed in filter(lambda each: each.value, results):
        own = [t for t in travels if alone or _is_of(printed.channel, t, layout)]
        column = layout.column(own[0].place) if len(own) == 1 else None
        own = [motion for motion in motions if motion.column == column]
        meant = meant_motions(printed, (motion.motion for motion in own))
        every = [_compared(printed, each, speeds) for each in own if each.motion in meant]
        if not every or (len(every) > 1 and printed.quantity != "stroke"):
            why = "of which channel or motion it is, is not stated"
            every = [PrintedComparison("", printed.motion, printed, reason=why)]
        found.append(min(every, key=lambda each: (bool(each.reason), abs(each.difference))))
    return found


def _is_of(label: str, travel: Travel, layout: Sheet) -> bool:
    """Return whether a result is of a channel, by its phase or number."""
    number, letter = words.channel_of(label), _PHASE.match(label)
    if number and number == words.channel_of(layout.names[travel.place]):
        return True
    phase = letter[1] if letter else words.phase_in(label)
    return bool(phase) and phase.casefold() == travel.phase.casefold()


def _compared(
    printed: Printed, motion: InspectedMotion, speeds: Mapping[str, Speed]
) -> PrintedComparison:
    """Compare a result with what is measured of a motion."""
    speed, name = printed.speed(motion.motion, speeds), measured_name(printed, motion.motion)
    values, reason = {}, WORDS["not measured"].get(printed.quantity, "not measured here")
    if printed.quantity == "speed" and speed is None:
        reason = "between which points is not stated"
    elif name and motion.record is None:
        reason = "the motion is not read"
    elif name:
        values = motion.record.measured((speed,) if speed else SPEEDS)
    value, sd, reason = values.get(name, (math.nan, math.nan, reason))
    value, sd = value / printed.size, sd / printed.size
    apart = differs(printed.quantity, printed.value, value, sd)
    return PrintedComparison(motion.column, motion.motion, printed, name, value, reason, apart)
