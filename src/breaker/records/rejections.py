"""Why a record cannot be used, said by the step that finds it; the reader adds the file's name."""

from collections.abc import Sequence


class UnusableError(ValueError):
    """A record that cannot be used, and the line of its file that shows it, if there is one."""

    def __init__(self, reason: str, *, line: int | None = None) -> None:
        super().__init__(reason)
        self.line = line


class SeveralMotionsError(UnusableError):
    """A record with a motion more than once, and the parts that hold each of them, ms."""

    def __init__(self, reason: str, parts: Sequence[tuple[float, float]]) -> None:
        super().__init__(reason)
        self.parts = parts


class NotShownError(ValueError):
    """A value that the curve does not show."""
