"""A closing and an opening of a simulated drive, with every measured quantity marked."""

from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from breaker.common.randomness import generator
from breaker.configuration.data_files import simulated_test
from breaker.configuration.loading import defaults
from breaker.family.endurance import EnduranceTest
from breaker.figures import style
from breaker.model.parameters import MOTIONS
from breaker.records.contacts import ContactTimes
from breaker.records.measurements import measure_curve

_TIMES, _RELEASE = np.arange(0.0, 85.0, 0.1), 22.0  # ms
_NOISE, _REACTION = 0.03, 6.0  # mm; ms from the start of motion back to the trigger
_SHOWN = {"closing": (12.0, 66.0), "opening": (12.0, 74.0)}  # ms
# Weaker dampers, so that over-travel is visible.
_WEAKER = {"opening_stop.damping": 0.3, "closing_stop.damping": 0.1, "closing_stop.stiffness": 0.2}


def of_drive() -> dict:
    """Return a record of each motion with its measured values."""
    settings = defaults()
    drive = EnduranceTest.from_settings(simulated_test(settings), settings["seed"]).new
    drive = drive.changed(**{n: by * drive.value(n) for n, by in _WEAKER.items()})
    rng, result = generator(settings["seed"], "pictures", "motions"), {}
    for motion in MOTIONS:
        travel, switching = drive.operate(motion, _TIMES - _RELEASE)
        travel = travel + _NOISE * rng.standard_normal(travel.size)
        trigger = _RELEASE - _REACTION
        contact = ContactTimes(switching + _RELEASE, 0.05, trigger=trigger)
        values = measure_curve(_TIMES, travel, motion, contact=contact)
        result[motion] = {
            "travel": travel.round(3).tolist(),
            "trigger": trigger,
            "event": round(contact.time, 3),
            "values": {
                n: round(float(v.value), 4) for n, v in values.items() if np.isfinite(v.value)
            },
        }
    return result


@style.styled
def marked_motions(data: Mapping[str, Mapping]) -> Figure:
    """Draw both motions, one below the other."""
    figure = style.new_figure(9.6, 10.8)
    axes = figure.subplots(2, 1)
    for axis, (motion, record) in zip(axes, data.items(), strict=True):
        _motion(axis, motion, record)
    style.title(figure, "What is measured on a travel curve")
    return figure


def _motion(axis: Axes, motion: str, record: Mapping) -> None:
    """Draw a curve, its events as vertical lines, and its quantities as arrows."""
    travel, values = np.array(record["travel"]), record["values"]
    closes, trigger, event = motion == "closing", record["trigger"], record["event"]
    moves = trigger + values["reaction_time"]
    start, end = np.median(travel[:150]), np.median(travel[-100:])
    low, high = min(start, end), max(start, end)
    left, right = _SHOWN[motion]
    seen = (left <= _TIMES) & (right >= _TIMES)
    axis.plot(
        _TIMES[seen], travel[seen], color=style.CORRECTED if closes else style.AMORTISED, lw=2
    )
    for level, name in ((low, "open rest position"), (high, "closed rest position")):
        axis.axhline(level, color=style.REFERENCE, ls="--", lw=0.8)
        axis.annotate(name, (left + 0.4, level), (0, 3), textcoords="offset points", fontsize=9)
    name = "touch" if closes else "separation"
    at = float(np.interp(event, _TIMES, travel))
    look = {"transform": axis.get_xaxis_transform(), "fontsize": 9}
    names = "trigger", "first detected\nmotion", f"contact\n{name}"
    for time, word, side in zip(
        (trigger, moves, event), names, ("right", "right", "left"), strict=True
    ):
        axis.axvline(time, color=style.PRIOR, lw=0.9, ls=":")
        axis.text(time, 1.01, word, ha=side, **look)
    starts = np.interp(moves, _TIMES, travel)
    axis.plot([event, moves], [at, starts], "o", color=style.MEASURED, ms=5)
    _ways(axis, motion, values, (low, high, at, event, right))
    _times(axis, motion, values, (trigger, moves, event, low))
    _zone(axis, motion, travel, values, (at, event))
    axis.set(xlim=(left, right + 4), ylim=(low - 7.4, high + (1.6 if closes else 1.2)))
    axis.set(xlabel="time of the record (ms)", ylabel=f"{motion}: travel (mm)")
    axis.grid(visible=False)


def _ways(axis: Axes, motion: str, values: Mapping, about: tuple) -> None:
    """Mark stroke, over-travel and contact wipe by vertical arrows."""
    low, high, at, event, right = about
    closes = motion == "closing"
    beyond = values["over_travel" if closes else "opening_over_travel"]
    wipe = f"{motion}_wipe"
    _arrow(axis, (right - 1, low), (right - 1, high), f"stroke\n{values['stroke']:.1f} mm")
    peak = high + beyond if closes else low - beyond
    word = "over-travel" if closes else "opening over-travel"
    place, rest = (event + 6, high) if closes else (event + 17, low)
    _arrow(axis, (place, rest), (place, peak), "")
    look = {"textcoords": "offset points", "fontsize": 9, "va": "center"}
    axis.annotate(f"{word} {beyond:.1f} mm", (place, peak), (8, 6 if closes else -4), **look)
    words = f"{wipe.replace('_', ' ')}\n{values[wipe]:.1f} mm"
    _arrow(axis, (event + 14, at), (event + 14, high), words)
    axis.hlines(at, event, event + 15, color=style.PRIOR, lw=0.8, ls=":")


def _times(axis: Axes, motion: str, values: Mapping, about: tuple) -> None:
    """Mark times by horizontal arrows below the curve."""
    trigger, moves, event, low = about
    name = "touch_time" if motion == "closing" else "separation_time"
    rows = [("reaction_time", trigger, moves), (name, moves, event)]
    rows += [(f"{motion}_time", trigger, event)]
    for row, (name, begin, end) in enumerate(rows):
        y = low - 2.1 - 1.5 * row
        _arrow(axis, (begin, y), (end, y), f"{name.replace('_', ' ')} {values[name]:.1f} ms", end)
    begin, end = (values["time_to_10"], values["time_to_90"])
    y = low - 2.1 - 1.5 * len(rows)
    words = f"travel time (10 to 90 % of the stroke) {values['travel_time']:.1f} ms"
    _arrow(axis, (trigger + begin, y), (trigger + end, y), words, trigger + end)


def _zone(axis: Axes, motion: str, travel: np.ndarray, values: Mapping, about: tuple) -> None:
    """Mark the points between which the speed is measured."""
    at, event = about
    other = at - 6.0
    inside = np.flatnonzero((travel <= other) if motion == "opening" else (travel >= other))[0]
    axis.plot([event, _TIMES[inside]], [at, other], color=style.CHANGED, lw=3, alpha=0.5)
    axis.plot(_TIMES[inside], other, "s", color=style.CHANGED, ms=5)
    speed = f"{motion}_speed"
    zone = "before touch" if motion == "closing" else "after separation"
    words = f"{motion} speed {values[speed]:.2f} m/s\nover 6 mm {zone}"
    place = (-14, 10) if motion == "closing" else (10, 12)
    align = "right" if motion == "closing" else "left"
    middle = 0.5 * (event + _TIMES[inside]), 0.5 * (at + other)
    look = {"textcoords": "offset points", "fontsize": 9, "color": style.CHANGED, "ha": align}
    axis.annotate(words, middle, place, **look)


def _arrow(axis: Axes, begin: tuple, end: tuple, words: str, right: float | None = None) -> None:
    """Draw an arrow with two heads, and words at its right."""
    look = {"arrowstyle": "<->", "shrinkA": 0, "shrinkB": 0, "color": style.MEASURED, "lw": 1.1}
    axis.annotate("", begin, end, arrowprops=look)
    middle = right if right is not None else end[0], 0.5 * (begin[1] + end[1])
    place = {"textcoords": "offset points", "va": "center", "fontsize": 9}
    axis.annotate(words, middle, (6, 0), **place)
