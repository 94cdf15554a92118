"""Which file, or which part of a file, is which operation: the table ``operations.csv``.

Light to import.
"""

from dataclasses import dataclass
from pathlib import Path

__all__ = ["ABOUT", "Operation"]

ABOUT = ("breaker", "phase", "date", "temperature", "event")
"""What is known of an operation and kept through to all results; empty where it is not."""


@dataclass(frozen=True)
class Operation:
    """One motion of one operation, and where its record is.

    Attributes:
        number: Counter of the operation.
        file: File of the record.
        channel: Column of the travel in the file; that of ``endurance.format`` if empty.
        begin, end: Part of the record in which the motion is, ms of the file's time; nan for its
            beginning and end.
        breaker, phase: Names, where a table gives them.
        date: Date and time as ISO 8601.
        temperature: Of the drive, °C.
        event: What was done before this operation, such as maintenance or remounting.
    """

    number: int
    file: str | Path
    channel: str = ""
    begin: float = float("nan")
    end: float = float("nan")
    breaker: str = ""
    phase: str = ""
    date: str = ""
    temperature: float = float("nan")
    event: str = ""
