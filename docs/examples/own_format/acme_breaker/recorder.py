"""Records of the Acme recorder: the signs ACME, the rate in Hz, and the travel in mm."""

import numpy as np

from breaker.records.files import RejectedCurveError
from breaker.records.sheet import Sheet

ENDINGS = {".acme": "a record of Acme"}
SIGNATURES = (b"ACME",)
EXTRA = ""


def read(opened, form):
    time, travel = _samples(opened)
    return [Sheet(opened.file, ["time", "travel"], [time, travel], ["ms", "mm"])]


def _samples(opened):
    content = opened.content  # the bytes, which are read once
    if content[:4] != b"ACME" or len(content) < 12 or len(content) % 4:
        raise RejectedCurveError(opened.file, "is no whole record of Acme")
    rate = np.frombuffer(content, "<u4", 1, offset=4)[0]
    travel = np.frombuffer(content, "<f4", offset=8).astype(float)
    return 1e3 * np.arange(travel.size) / rate, travel
