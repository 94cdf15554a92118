"""Complete example of a format to copy: records of a fictitious recorder.

A file contains the signs ``EXAMPLE1``, the number of samples per second, and the travel in mm, as
little-endian numbers of four bytes. The format passes the tests of all formats. To use it, add it
to ``FORMATS`` in ``detection``, with the names of its files in messages by ending, and the first
bytes that identify the format, whatever the ending of the file:

    Format(__name__, {".example-record": "a record of the example"}, (b"EXAMPLE1",))
"""

from collections.abc import Mapping

import numpy as np

from breaker.records.files import Opened, RejectedCurveError, check_size
from breaker.records.sheet import Sheet


def read(opened: Opened, form: Mapping) -> list[Sheet]:
    """Return the tables of samples in a file, best first; this format has one table.

    Args:
        opened: The file. ``opened.content`` are its bytes, which are read once;
            ``opened.companion(name)`` are the bytes of a second file of the record.
        form: The section ``endurance.format``, complete; empty if nothing is known yet, as when
            ``breaker inspect`` reads the file.

    Raises:
        RejectedCurveError: If the file is damaged; the message states the reason and the remedy.
    """
    header, content = 12, opened.content
    size, rest = divmod(len(content) - header, 4)
    if size < 1 or rest:
        raise RejectedCurveError(opened.file, "is not a complete example record; export it again")
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
            clock=0,  # this column is the time, whatever its name in the settings
        )
    ]
