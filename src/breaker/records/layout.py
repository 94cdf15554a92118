"""Former names of what ``sheet`` and ``formats.registry`` have."""

from breaker.records.formats.registry import look_into, stated_in
from breaker.records.sheet import LayoutError
from breaker.records.sheet import Sheet as Layout

__all__ = ["Layout", "LayoutError", "look_into", "stated_in"]
