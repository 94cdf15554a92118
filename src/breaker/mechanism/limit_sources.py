"""What the quantities of limits are read from: the model, a record, or the change of a drive.

All that differs with the source of a limit is said here, and only ``Source.read`` asks which it is.
Whoever tells quantities, of a record, two visits, a life or a simulated truth, has a method for
each source: ``of_model``, ``of_record`` and ``of_change``.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Protocol

from breaker.common.lazy_numpy import np
from breaker.common.numerals import in_digits
from breaker.quantities.catalogue import Quantity, check_quantity, quantities
from breaker.quantities.parameters import NAMES
from breaker.quantities.speeds import Speed

if TYPE_CHECKING:
    from breaker.mechanism.limits import Limit

_DIGITS = 6  # of a bound in words


class Reader(Protocol):
    """What tells quantities of limits, by their source."""

    def of_model(self, limit: Limit, *about: Any) -> Any:
        """Tell quantities of the model at inferred parameters."""

    def of_record(self, limit: Limit, *about: Any) -> Any:
        """Tell quantities that records show."""

    def of_change(self, limit: Limit, *about: Any) -> Any:
        """Tell changes of parameters, in percent."""


class Source:
    """Where quantities of limits are read.

    Attributes:
        name: Its name in the configuration.
        word: Word in front of a quantity of a limit; ``title`` that in a table of limits.
        inferred: Whether networks infer its quantities, which err alike all along a life.
        single: Whether a single record has them.
        least: Value below which none of them is.
    """

    name = word = title = ""
    inferred = single = True
    least = -math.inf

    def complaint(self, quantity: str, motion: str, speeds: Sequence[Speed]) -> str | None:
        """Return why a motion has no such quantity, with a remedy; None if it has it."""
        return check_quantity(quantity, motion, speeds, self.name)

    def units(self, names: Sequence[str], speeds: Sequence[Speed]) -> tuple[str, ...]:
        """Return the units of quantities."""
        every = quantities(speeds)
        return tuple(every[name].unit for name in names)

    def digits(self, value: float) -> str:
        """Return a bound in words."""
        return in_digits(value, _DIGITS)

    def amount(self, limit: str, value: float | str) -> float:
        """Return a bound as it is written in a limit of a name.

        Raises:
            ValueError: If it is in percent of what is no change.
        """
        text = str(value)
        if text.endswith("%"):
            raise ValueError(
                f"{limit}: {text} is of no change. Write the value in its unit, or reference and "
                "tolerance."
            )
        return float(text)

    def tolerance(self, text: str, middle: float) -> float:
        """Return how far a tolerance goes to either side of a reference."""
        share = abs(middle) / 100.0 if text.endswith("%") else 1.0
        return share * float(text.removesuffix("%"))

    def evaluate(self, limit: Limit, theta: np.ndarray) -> np.ndarray:
        """Return the quantities of a limit at parameter sets, ``(n, p) -> (n, parts)``.

        Raises:
            ValueError: If they are those of records, which parameters do not give.
        """
        raise ValueError(f"{limit.name} is about what records show, not about parameters")

    def read(self, reader: Reader, limit: Limit, *about: Any) -> Any:
        """Return what a reader tells of a limit."""
        raise NotImplementedError


class _Model(Source):
    """The model at inferred parameters."""

    name = "model"

    def evaluate(self, limit: Limit, theta: np.ndarray) -> np.ndarray:
        from breaker.mechanism.evaluation import evaluate  # compiled code

        return evaluate(limit.quantities, theta, limit.motion, limit.speeds)

    def read(self, reader: Reader, limit: Limit, *about: Any) -> Any:
        return reader.of_model(limit, *about)


class _Record(Source):
    """A record itself."""

    name, word = "record", "measured "
    inferred = False
    least = 0.0  # no record shows a way or a time below

    def read(self, reader: Reader, limit: Limit, *about: Any) -> Any:
        return reader.of_record(limit, *about)


class _Change(Source):
    """Changes of parameters, in percent, between visits or along a life."""

    name, word, title = "change", "change of ", "change of "
    single = False

    def complaint(self, quantity: str, motion: str, speeds: Sequence[Speed]) -> str | None:
        known = ", ".join(NAMES)
        if quantity in NAMES:
            return None
        return f"{quantity} has no change: parameters alone have, {known}."

    def units(self, names: Sequence[str], speeds: Sequence[Speed]) -> tuple[str, ...]:
        return ("%",) * len(names)

    def digits(self, value: float) -> str:
        return in_digits(value, _DIGITS, sign=True)

    def amount(self, limit: str, value: float | str) -> float:
        return float(str(value).removesuffix("%"))

    def tolerance(self, text: str, middle: float) -> float:
        return float(text.removesuffix("%"))

    def read(self, reader: Reader, limit: Limit, *about: Any) -> Any:
        return reader.of_change(limit, *about)


RECORD = _Record()
"""The source of what instruments print."""

SOURCES: dict[str, Source] = {each.name: each for each in (_Model(), RECORD, _Change())}
"""The sources by their names."""


def usual_source(quantity: Quantity | None) -> str:
    """Return the name of the source that a tolerance is on where it names none."""
    return RECORD.name if quantity and RECORD.name in quantity.of else "model"
