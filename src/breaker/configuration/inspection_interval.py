"""How far inspections of a drive are apart: the words of ``planning.inspection``."""

from contextlib import suppress

EVERY = "every operation"
OPERATIONS, YEARS = "operation", "year"


def interval_of(text: str) -> tuple[float, str]:
    """Read how far inspections are apart: a number, of ``OPERATIONS`` or of ``YEARS``.

    Raises:
        ValueError: If it is none.

    >>> interval_of("2 years"), interval_of("100 operations"), interval_of(EVERY)
    ((2.0, 'year'), (100.0, 'operation'), (1.0, 'operation'))
    """
    if text.strip() == EVERY:
        return 1.0, OPERATIONS
    number, _, unit = text.strip().partition(" ")
    unit, often = unit.strip().removesuffix("s"), 0.0
    with suppress(ValueError):
        often = float(number)
    if unit not in (OPERATIONS, YEARS) or not 0.0 < often < 1e9:
        raise ValueError(
            f'"{text}" is no interval of inspection. Write a number of years or '
            f'operations, such as "1 year" or "100 operations", or "{EVERY}".'
        )
    return often, unit
