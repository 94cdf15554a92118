"""Why a record cannot be used, said by the step that finds it; the reader adds the file's name."""

__all__ = ["UnusableError"]


class UnusableError(ValueError):
    """A record that cannot be used, and the line of its file that shows it, if there is one."""

    def __init__(self, reason: str, *, line: int | None = None) -> None:
        super().__init__(reason)
        self.line = line
