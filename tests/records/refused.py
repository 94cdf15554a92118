"""What is said of a file that is refused."""

import pytest

from breaker.records.files import RejectedCurveError


def refusal(file, read):
    """Why, in one line after the file's name."""
    with pytest.raises(RejectedCurveError) as caught:
        read()
    message = str(caught.value)
    assert message.startswith(str(file))
    assert "\n" not in message
    return message.removeprefix(str(file))
