"""Kinds about the samples of one record: what was cut, saturated, lost, dead, or never a travel."""

import numpy as np

from studies.wrong_inputs.ask import Kind, Question, answered, off
from studies.wrong_inputs.desk import Desk
from studies.wrong_inputs.drives import Drive

OPENING_OR_CLOSING = ("closing", "opening")


def _one(file, false, *, extra=(), **options) -> Question:
    """Return the question about one file, read as `breaker inspect` proposes."""
    command = ["infer", file, "--json", *extra]
    return Question([command], false, layout=file, look=True, **options)


def _any_drive(desk: Desk) -> Drive:
    return Drive.high(desk.rng) if desk.rng.random() < 0.4 else desk.drive


def _cut(desk: Desk, wrong: bool, motion: str) -> Question:
    record = desk.record(motion, _any_drive(desk))
    share = desk.rng.uniform(0.5, 1.1)
    end = record.first + share * (record.reached(0.97) - record.first)
    file = desk.write("a.csv", record.cut(0.0, end) if wrong else record)
    return _one(file, off(motion, record.truth))


def cut_closing(desk: Desk, wrong: bool) -> Question:
    """A closing that ends after 50 to 110 % of its way's time, so before any rest."""
    return _cut(desk, wrong, "closing")


def cut_opening(desk: Desk, wrong: bool) -> Question:
    """An opening that ends so."""
    return _cut(desk, wrong, "opening")


def begins_in_motion(desk: Desk, wrong: bool) -> Question:
    """A record that begins after 0 to 60 % of the way."""
    motion = desk.pick(OPENING_OR_CLOSING)
    record = desk.record(motion, _any_drive(desk))
    share = desk.pick([0.0, 0.05, 0.1, 0.2, 0.3, 0.5, 0.6])
    begin = record.reached(share) if share else record.first
    file = desk.write("a.csv", record.cut(begin, np.inf) if wrong else record)
    return _one(file, off(motion, record.truth))


def saturated(desk: Desk, wrong: bool) -> Question:
    """A transducer whose range ends at 70 to 95 % of the stroke, with or without noise there."""
    motion = desk.pick(OPENING_OR_CLOSING)
    record = desk.record(motion, _any_drive(desk))
    way, stroke = record.travel, record.truth["stroke"]
    low = way.min() if motion == "closing" else np.median(way[-20:])
    share, noisy = desk.rng.uniform(0.7, 0.95), desk.rng.random() < 0.5
    clipped = np.minimum(way, low + share * stroke)
    if noisy:
        clipped = clipped + 0.001 * stroke * desk.rng.standard_normal(way.size)
    file = desk.write("a.csv", record.changed(travel=clipped) if wrong else record)
    found = off(motion, record.truth)
    how = f"with{'' if noisy else 'out'} noise at {share:.0%}: "
    return _one(file, lambda said: found(said) and how + found(said))


def _in_the_motion(desk: Desk, record, first: float, most: float):
    """Draw samples in a row, from a share of the way on, that last up to a share of the motion."""
    span = record.truth["travel_time"]
    begin = record.reached(first) + desk.rng.uniform(0.0, most) * span
    return (record.time > begin) & (record.time < begin + desk.rng.uniform(0.1, most) * span)


def lost_samples(desk: Desk, wrong: bool) -> Question:
    """Samples of 10 to 50 % of the motion lost where no time tells it; the header has the rate."""
    motion = desk.pick(OPENING_OR_CLOSING)
    record = desk.record(motion, _any_drive(desk))
    lost = _in_the_motion(desk, record, 0.1, 0.5)
    travel = record.travel[~lost] if wrong else record.travel
    column = f"{desk.style.words['travel']} [mm]"
    header = desk.header(rate=f"{desk.bench.rate:g}")
    file = desk.write_columns("a.csv", {column: travel, "I [A]": 0.0 * travel}, header)
    return _one(file, off(motion, record.truth))


def gap_in_times(desk: Desk, wrong: bool) -> Question:
    """Lines of 10 to 60 % of the motion missing, which the times tell."""
    motion = desk.pick(OPENING_OR_CLOSING)
    record = desk.record(motion, _any_drive(desk))
    lost = _in_the_motion(desk, record, 0.05, 0.6)
    kept = record.changed(time=record.time[~lost], travel=record.travel[~lost])
    file = desk.write("a.csv", kept if wrong else record)
    return _one(file, off(motion, record.truth))


def never_moves(desk: Desk, wrong: bool) -> Question:
    """A dead channel, a drift, hum, or a twitch of 0.3 to 2 mm, where a drive should move."""
    record, which = desk.record("closing"), desk.pick(["dead", "drift", "hum", "twitch"])
    time = record.time
    travel = desk.bench.noise * 13.0 * desk.rng.standard_normal(time.size)
    if which == "drift":
        travel = travel + desk.rng.uniform(2.0, 5.0) * time / time[-1]
    if which == "hum":
        travel = travel + desk.rng.uniform(0.5, 3.0) * np.sin(2 * np.pi * time / 20.0)
    if which == "twitch":
        since = np.maximum(time - record.first, 0.0)
        travel = travel + desk.rng.uniform(0.3, 2.0) * since * np.exp(1 - since / 3.0) / 3.0
    file = desk.write("a.csv", record.changed(travel=travel) if wrong else record)

    def false(said):
        own = [r for each in said for r in each.records]
        return f"{which}: {len(own)} records accepted" if own and wrong else ""

    return _one(file, false)


def wrong_column(desk: Desk, wrong: bool) -> Question:
    """The current of the coil or of the motor taken as the travel, by its column's name."""
    record, which = desk.record("closing"), desk.pick(["I close", "Motor current", "Strom EIN"])
    since = np.maximum(record.time - record.coil, 0.0)
    rise, length = desk.rng.uniform(2.0, 6.0), desk.rng.uniform(30.0, 60.0)
    current = desk.rng.uniform(3.0, 12.0) * (1 - np.exp(-since / rise))
    if desk.rng.random() < 0.5:
        current = current * (since < length)
    current = current + 0.02 * desk.rng.standard_normal(since.size)
    unit, travel = desk.pick(["", " [A]"]), f"{desk.style.words['travel']} [mm]"
    file = desk.write("a.csv", record, more={which + unit: current})
    column = which if wrong else travel.removesuffix(" [mm]")
    false = answered if wrong else off("closing", record.truth)
    return _one(file, false, extra=["--channel", column])


def coil_in_noise(desk: Desk, wrong: bool) -> Question:
    """A coil's current with noise of 1 to 10 % of its plateau: when was it energised?"""
    motion = desk.pick(OPENING_OR_CLOSING)
    record = desk.record(motion)
    since = np.maximum(record.time - record.coil, 0.0)
    plateau, rise = desk.rng.uniform(1.0, 6.0), desk.rng.uniform(1.0, 8.0)
    share = np.exp(desk.rng.uniform(np.log(0.01), np.log(0.1)))
    current = plateau * (1 - np.exp(-since / rise))
    noise = plateau * (share if wrong else 0.001)
    current = current + noise * desk.rng.standard_normal(since.size)
    touched = (record.time > record.contact) == (motion == "closing")
    more = {"I coil [A]": current, "Contact [V]": 5.0 * touched}
    own = 'endurance:\n  format: {contact_column: "Contact [V]", trigger_column: "I coil [A]"}\n'
    file = desk.write("a.csv", record, more=more)
    false = off(motion, record.truth, 0.1 / record.truth[f"{motion}_time"], [f"{motion}_time"])
    return _one(file, false, own=own)


RECORDS = {
    "cut closing": Kind(cut_closing, r"\bends?\b|early|\bcut\b|too short|rest\b|slow down|later"),
    "cut opening": Kind(cut_opening, r"\bends?\b|early|\bcut\b|too short|rest\b|slow down|later"),
    "begins in motion": Kind(begins_in_motion, r"\brest\b|begins? (?!with)|first motion is|before"),
    "saturated": Kind(saturated, r"clip|satur|\bflat|stuck|range of"),
    "lost samples": Kind(lost_samples, r"\bjump|slip|missing|lost|gap"),
    "gap in times": Kind(gap_in_times, r"missing|\bgap\b|even steps|lost"),
    "never moves": Kind(
        never_moves, r"no motion|none of|REJECT|stroke|swing|drift|too (small|little)"
    ),
    "wrong column": Kind(wrong_column, r"current|column|unit|coil|REJECT|stroke|no closing"),
    "coil in noise": Kind(coil_in_noise, r"nois|trigger|coil|energised"),
}
