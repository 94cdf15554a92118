"""What the quantities of limits are read from: the model, a record, or the change of a drive.

Whoever tells quantities, of a record, two visits, a life or a simulated truth, has a method for
each source: ``of_model``, ``of_record`` and ``of_change``.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

from breaker.common.numerals import in_digits
from breaker.quantities.catalogue import check_quantity, quantities
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


@dataclass(frozen=True)
class Source:
    """Where quantities of limits are read.

    Attributes:
        name: Its name in the configuration.
        word: Word in front of a quantity of a limit; ``title`` that in a table of limits.
        inferred: Whether networks infer its quantities, which err alike all along a life.
        single: Whether a single record has them; if not, they are changes in percent.
        least: Value below which none of them is.
    """

    name: str
    word: str = ""
    title: str = ""
    inferred: bool = True
    single: bool = True
    least: float = -math.inf

    def complaint(self, quantity: str, motion: str, speeds: Sequence[Speed]) -> str | None:
        """Return why a motion has no such quantity, with a remedy; None if it has it."""
        if self.single:
            return check_quantity(quantity, motion, speeds, self.name)
        if quantity in NAMES:
            return None
        return f"{quantity} has no change: parameters alone have, {', '.join(NAMES)}."

    def units(self, names: Sequence[str], speeds: Sequence[Speed]) -> tuple[str, ...]:
        """Return the units of quantities."""
        if not self.single:
            return ("%",) * len(names)
        every = quantities(speeds)
        return tuple(every[name].unit for name in names)

    def digits(self, value: float) -> str:
        """Return a bound in words."""
        return in_digits(value, _DIGITS, sign=not self.single)

    def amount(self, limit: str, value: float | str) -> float:
        """Return a bound as it is written in a limit of a name.

        Raises:
            ValueError: If it is in percent of what is no change.
        """
        text = str(value)
        if self.single and text.endswith("%"):
            raise ValueError(
                f"{limit}: {text} is of no change. Write the value in its unit, or reference and "
                "tolerance."
            )
        return float(text.removesuffix("%"))

    def tolerance(self, text: str, middle: float) -> float:
        """Return how far a tolerance goes to either side of a reference."""
        share = abs(middle) / 100.0 if self.single and text.endswith("%") else 1.0
        return share * float(text.removesuffix("%"))


# No record shows a way or a time below 0.
RECORD = Source("record", "measured ", inferred=False, least=0.0)
"""The source of what instruments print."""

_CHANGE = Source("change", "change of ", "change of ", single=False)
SOURCES = {each.name: each for each in (Source("model"), RECORD, _CHANGE)}
"""The sources by their names."""
