"""An example of a format, complete, to copy: records of a recorder that nobody has.

A file has the signs ``EXAMPLE1``, the number of samples a second, and the travel in mm, as
little-endian numbers of four bytes. It passes the tests of all formats. To be read it needs a line
of ``FORMATS`` in ``registry``, with the names of its files in messages by ending, and the first
bytes that prove a file to be of this format, whatever its ending:

    Format(__name__, {".example-record": "a record of the example"}, (b"EXAMPLE1",))
"""

from collections.abc import Mapping

import numpy as np

from breaker.records.files import Opened, RejectedCurveError, check_size
from breaker.records.sheet import Sheet


def read(opened: Opened, form: Mapping) -> list[Sheet]:
    """Return the tables of samples in a file, best first; here there is one.

    Args:
        opened: The file. Its bytes are ``opened.content``, which are read once, and those of a
            second file of the record ``opened.companion(name)``.
        form: The section ``endurance.format``, complete; empty where nothing is known yet, as when
            ``breaker inspect`` looks at the file.

    Raises:
        RejectedCurveError: If the file is damaged, with what is wrong and what to do.
    """
    header, content = 12, opened.content
    size, rest = divmod(len(content) - header, 4)
    if size < 1 or rest:
        raise RejectedCurveError(opened.file, "is no whole record of the example; export it again")
    check_size(opened.file, size, 2)  # before arrays are built: a file may have any size
    rate = int.from_bytes(content[8:header], "little")  # Hz
    if rate == 0:
        raise RejectedCurveError(opened.file, "states a rate of 0 Hz; export it again")
    travel = np.frombuffer(content, "<f4", offset=header).astype(float)
    return [
        Sheet(
            file=opened.file,
            names=["time", "travel"],
            columns=[1e3 * np.arange(size) / rate, travel],
            texts=["ms", "mm"],
            preamble=[["Sampling rate (Hz):", str(rate)]],
            clock=0,  # the time is this column, whatever settings call it
        )
    ]
