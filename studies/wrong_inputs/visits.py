"""Kinds about two visits: scales, dates, and whether they are of the same breaker at all."""

import numpy as np

from studies.wrong_inputs.ask import Kind, Question, compared, told
from studies.wrong_inputs.desk import Desk

TIMES = [10.0, 5.0, 2.0, 1.5, 1.2, 0.5, 0.1]
LENGTHS = [1.05, 1.08, 1.1, 1.2, 1.33, 1.5, 2.0, 2.54, 10.0, 25.4]


def _compare(before, after, false, **options) -> Question:
    command = ["compare", *before, "--today", *after, "--json"]
    return Question([command], false, **{"layout": before[0]} | options)


def _motions(desk: Desk) -> tuple[str, ...]:
    return desk.pick([("closing", "opening"), ("closing",), ("opening",)])


def time_scale(desk: Desk, wrong: bool) -> Question:
    """Times of today 0.1 to 10 times as long; the twin is a drive that is really slower."""
    motions, repeats, strip = _motions(desk), desk.pick([1, 2, 3]), desk.rng.random() < 0.5
    factor, worn = desk.pick(TIMES), desk.worn()
    before = desk.visit("before", motions=motions, repeats=repeats)
    scale = {"time_scale": factor} if wrong else {}
    drive = desk.drive if wrong else worn
    today = desk.visit("today", drive, motions=motions, repeats=repeats, **scale)
    return _compare(before, today, told if wrong else lambda _: "", strip=strip)


def length_scale(desk: Desk, wrong: bool) -> Question:
    """Ways of today 1.05 to 25.4 times as long, or as short; the twin has more friction."""
    motions, repeats = _motions(desk), desk.pick([1, 2, 3])
    factor = desk.pick(LENGTHS) ** desk.pick([1, -1])
    before = desk.visit("before", motions=motions, repeats=repeats)
    scale = {"scale": factor} if wrong else {}
    drive = desk.drive if wrong else desk.drive.worn(gamma_a=1.3)
    today = desk.visit("today", drive, motions=motions, repeats=repeats, **scale)
    return _compare(before, today, told if wrong else lambda _: "", strip=True)


def _days(desk: Desk) -> list[str]:
    """Return two days, years apart, as a style writes them."""
    first = np.datetime64("2014-01-01") + int(desk.rng.integers(900))
    days = [first, first + int(desk.rng.integers(200, 3000))]
    form = desk.pick(["%Y-%m-%d", "%d.%m.%Y", "%d %b %Y", "%Y-%m-%d 10:04:05"])
    return [day.astype(object).strftime(form) for day in days]


def visits_swapped(desk: Desk, wrong: bool) -> Question:
    """The visit of a later date named as the one before."""
    early, late = _days(desk)
    old = desk.visit("old", header=desk.header(date=early))
    new = desk.visit("new", desk.worn(), header=desk.header(date=late))
    return _compare(*((new, old) if wrong else (old, new)), told if wrong else lambda _: "")


def report_before_later(desk: Desk, wrong: bool) -> Question:
    """A report whose visit before is of a later date."""
    early, late = _days(desk)
    old = desk.visit("old", header=desk.header(date=early))
    new = desk.visit("new", desk.worn(), header=desk.header(date=late))
    today, before = (old, new) if wrong else (new, old)
    command = ["report", *today, "--before", *before, "--output", desk.folder / "r.html"]

    def false(said):
        return "report written" if wrong and said[-1].page else ""

    return Question([command], false, layout=today[0])


def _other(desk: Desk, wrong: bool, key: str, values: tuple[str, str]) -> Question:
    """Two visits whose headers state different values of a key, or the same."""
    first, second = values
    before = desk.visit("before", header=desk.header(**{key: first}))
    worn, header = desk.worn(), desk.header(**{key: second if wrong else first})
    return _compare(before, desk.visit("today", worn, header=header), told if wrong else _none)


def _none(_) -> str:
    return ""


def other_serial(desk: Desk, wrong: bool) -> Question:
    """Another serial number today."""
    one, two = (f"{n}/{desk.rng.integers(1, 30)}" for n in desk.rng.integers(10**3, 10**6, 2))
    return _other(desk, wrong, "serial", (one, two))


def other_phase(desk: Desk, wrong: bool) -> Question:
    """Another phase today."""
    return _other(desk, wrong, "phase", desk.pick([("R", "Y"), ("A", "C"), ("L1", "L3")]))


def other_channel(desk: Desk, wrong: bool) -> Question:
    """Another channel of travel today, which its column names."""
    one, two = desk.pick([("R", "Y"), ("A", "C"), ("L1", "L3"), ("T1", "T2")])
    name = f"{desk.style.words['travel']} {{}} [mm]"
    before = desk.visit("before", travel=name.format(one))
    after = name.format(two if wrong else one)
    today = desk.visit("today", desk.worn(), travel=after)
    return _compare(before, today, told if wrong else _none, today=today[0])


def own_copy(desk: Desk, wrong: bool) -> Question:
    """Today is a copy of the record before; the twin is a new record."""
    record = desk.record("closing")
    before = desk.write("before.csv", record)
    today = desk.write("today.csv", record if wrong else desk.record("closing"))
    return _compare([before], [today], compared if wrong else _none)


SAME = r"\bsame\b|cop(y|ies)|identical|duplicate|twice"
VISITS = {
    "time scale, two visits": Kind(time_scale, r"\brate\b|time scale|time[ _]unit|all times|sampl"),
    "length scale, two visits": Kind(length_scale, r"ratio|scale|alike|transducer|unit|stroke"),
    "visits swapped": Kind(visits_swapped, r"\bdates?\b|\bdated\b|older|newer|later|earlier"),
    "report before later": Kind(
        report_before_later,
        r"older than|newer|is later|earlier than|after the visit|before the visit|later than",
    ),
    "other serial": Kind(other_serial, r"serial|number (was|of)|breaker was"),
    "other phase": Kind(other_phase, r"(phase|pole)s? (was|is|of)\b|(an)?other (phase|pole)\b"),
    "other channel": Kind(
        other_channel, r"(phase|channel|column) (was|is|of)\b|other (phase|channel)\b"
    ),
    "own copy": Kind(own_copy, SAME),
}
