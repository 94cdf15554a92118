"""Where in its file each measured number of a document is read."""

from collections.abc import Mapping, Sequence

import numpy as np

from breaker.drive.answers.evidence import Answer
from breaker.reading.records.measurements import Reading
from breaker.reading.records.sample_places import places_of

_LINE = "  {:<50} {:<22} {:>8} {:>11}"


def explained(document: Mapping, answers: Sequence[Answer]) -> dict:
    """Return a document with the places of what is measured.

    Args:
        document: What ``document`` returns.
        answers: Those that it is of.

    Returns:
        The same; each accepted record has ``places``, by the names of its quantities a list of
        ``what`` is there, its ``time`` and, of a rest, ``until``, ms of the file; ``sample``, the
        number of the nearest one from 1; and ``travel``, mm towards closed; None where there is
        none.
    """
    records = []
    for entry, answer in zip(document["records"], answers, strict=True):
        more = {"places": _places(entry, answer)} if entry["accepted"] else {}
        records.append({**entry, **more})
    return {**document, "records": records}


def place_lines(record: Mapping) -> list[str]:
    """Return the places of a record as lines of a terminal; none where the document has none."""
    rows = record.get("places", {})
    lines = [_LINE.format("where it is read", "time of the file, ms", "sample", "travel, mm")]
    for name, places in rows.items():
        for each in places:
            until = "" if each["until"] is None else f" to {each['until']:.2f}"
            way = "" if each["travel"] is None else f"{each['travel']:.3f}"
            what, at = f"{name}: {each['what']}", f"{each['time']:.2f}{until}"
            lines.append(_LINE.format(what, at, each["sample"], way).rstrip())
    return lines if rows else []


def _places(entry: Mapping, answer: Answer) -> dict[str, list[dict]]:
    raw, found = answer.record.raw, {}
    reading = Reading(raw, answer.contact, answer.speeds)
    for name, each in entry["quantities"].items():
        if each["median"] is None or each["source"] == "inferred":
            continue
        found[name] = [
            {
                "what": place.what,
                "time": place.time,
                "until": None if place.until == place.time else place.until,
                "sample": round((place.time - float(raw.time[0])) / raw.step) + 1,
                "travel": place.travel if np.isfinite(place.travel) else None,
            }
            for place in places_of(reading, name)
        ]
    return {name: places for name, places in found.items() if places}
