"""A document as a tidy table: one row for each record and parameter or quantity."""

from collections.abc import Mapping
from csv import DictWriter
from io import StringIO

__all__ = ["table_of"]

_KINDS = {"parameters": "parameter", "quantities": "quantity"}
_FIRST = ("motion", "operation", "file", "kind", "output", "unit", "median")
_FIRST += tuple(f"interval_{of}_{end}" for of in (50, 95) for end in ("lower", "upper"))
_LEFT_OUT = ("parameters", "quantities", "fit", "limits", "remarks")


def table_of(document: Mapping) -> str:
    """Return the records of a document as CSV.

    Beside what stands in the document of each parameter and quantity, every row has what is known
    of its record: ``part_PART`` of each part of the motion, ``exceeded_LIMIT``, the probabilities
    of limits, and ``verdict``. A rejected record is one row without numbers.
    """
    rows = [row for record in document["records"] for row in _rows(record)]
    names = dict.fromkeys([*_FIRST, *(name for row in rows for name in row)])
    text = StringIO()
    writer = DictWriter(text, [*names], lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return text.getvalue()


def _rows(record: Mapping) -> list[dict]:
    about = {name: each for name, each in record.items() if name not in _LEFT_OUT}
    about["remarks"] = "; ".join(record["remarks"])
    if not record["accepted"]:
        return [about]
    fit = dict(record["fit"])
    parts = {f"part_{name.replace(' ', '_')}": each for name, each in fit.pop("parts").items()}
    about |= fit | {"motions": " ".join(fit["motions"])} | parts
    about |= {f"exceeded_{e['name']}": e["probability"] for e in record.get("limits", [])}
    return [
        {"kind": kind, "output": name, **_numbers(each), **about}
        for group, kind in _KINDS.items()
        for name, each in record[group].items()
    ]


def _numbers(each: Mapping) -> dict:
    """A parameter or quantity in columns; its meaning is no number."""
    found = {"unit": each["unit"], "median": each["median"]}
    for name in ("interval_50", "interval_95"):
        ends = each[name] or (None, None)
        found |= {f"{name}_{end}": v for end, v in zip(("lower", "upper"), ends, strict=True)}
    return found | {name: each[name] for name in ("source", "prior_sds") if name in each}
