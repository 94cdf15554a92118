"""Between which points a speed is the mean, as a text that other languages have, too."""

from breaker.documents.parts import Number, Text
from breaker.quantities.speeds import EVENTS, Point, Speed


def zone_of(speed: Speed) -> Text:
    """Return the words of a speed, which are ``speed.words``.

    >>> zone_of(Speed.read("closing_speed", ["10 ms before touch", "touch"]))
    'from 10 ms before touch to touch'
    """
    start, end = (_point(each, speed.motion) for each in (speed.start, speed.end))
    shares = (speed.start.unit, speed.end.unit) == ("%", "%")
    if shares and not (speed.start.later or speed.end.later):
        start = _number(speed.start.amount)
    return Text("from {start} to {end}", start=start, end=end)


def _point(point: Point, motion: str) -> Text:
    """A point of a motion, as ``Point.text`` writes it."""
    amount, place = _number(point.amount), Text(EVENTS[motion])
    if point.unit == "%":
        place = Text("{amount} % of stroke", amount=amount)
    elif point.rest == "open":
        place = Text("{amount} mm from open", amount=amount)
    elif point.rest:
        place = Text("{amount} mm from closed", amount=amount)
    elif point.amount:
        place = _beside(point.amount, point.unit, place)
    return _beside(point.later, "ms", place) if point.later else place


def _beside(amount: float, unit: str, place: Text) -> Text:
    """A place so far before or after another."""
    about = {"amount": _number(amount), "unit": unit, "place": place}
    if amount < 0:
        return Text("{amount} {unit} before {place}", **about)
    return Text("{amount} {unit} after {place}", **about)


def _number(value: float) -> Number:
    return Number(f"{abs(value):g}")
