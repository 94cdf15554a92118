"""Known events: work on a drive or its transducer, after which its path starts anew.

Work is a step and a new rate, of which nobody needs to be warned. What a transducer shows after it
was mounted again is no change of the drive.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from breaker.reading.files.operations_table import EVENTS, event_words

_TRANSDUCER = "transducer"


@dataclass(frozen=True)
class Event:
    """Work that was done before an operation.

    Attributes:
        text: Its words, as the table of operations has them.
        renews: Whether anything starts anew.
        transducer: Whether it is the transducer alone.

    Example:
        >>> Event.from_text("Greased, inspected")
        Event(text='Greased, inspected', renews=True, transducer=False)
    """

    text: str
    renews: bool = False
    transducer: bool = False

    @classmethod
    def from_text(cls, text: str, more: Mapping[str, Sequence[str]] | None = None) -> "Event":
        """Build from a cell of the table.

        Args:
            more: Section ``endurance.events`` of the configuration: what starts anew, by event.

        Raises:
            ValueError: If an event has no meaning.
        """
        every = [*EVENTS.items(), *(more or {}).items()]
        known = {word: meaning for key, meaning in every for word in event_words(key)}
        if unknown := [word for word in event_words(text) if word not in known]:
            raise ValueError(f"endurance.events has no {', '.join(unknown)}; add what starts anew")
        affected = {name for word in event_words(text) for name in known[word]}
        return cls(text, bool(affected), affected == {_TRANSDUCER})

    @classmethod
    def by_operation(
        cls, texts: Mapping[int, str], more: Mapping[str, Sequence[str]]
    ) -> dict[int, "Event"]:
        """Build those of several operations, from cells by their numbers."""
        return {number: cls.from_text(text, more) for number, text in texts.items()}
