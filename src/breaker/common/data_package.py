"""Tables of a run as a data package: what each file is, its columns, their types and meanings.

After the specification of Frictionless Data (https://specs.frictionlessdata.io, tabular data
package). It stands beside the tables, so that others read them without knowing this package.
"""

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from breaker import __version__

_TYPES = {"b": "boolean", "i": "number", "f": "number"}  # by kind of an array


@dataclass(frozen=True)
class DescribedTable:
    """A table of a run.

    Attributes:
        file: CSV, in the folder of the package or below it.
        title: What it is.
        columns: What each column is, by name; those that the file lacks do not count.
    """

    file: Path
    title: str
    columns: Mapping[str, str]


def data_package(folder: Path, title: str, tables: Sequence[DescribedTable]) -> dict[str, Any]:
    """Return the content of ``datapackage.json``.

    Args:
        folder: Where it will be.
        title: What the tables are of.

    Raises:
        ValueError: If a column of a table is not described, or a table lies outside of the folder.
    """
    return {
        "profile": "tabular-data-package",
        "name": "breaker-results",
        "title": title,
        "version": __version__,
        "resources": [_resource(folder, table) for table in tables],
    }


def _resource(folder: Path, table: DescribedTable) -> dict[str, Any]:
    path = table.file.resolve().relative_to(folder.resolve()).as_posix()
    content = table.file.read_bytes()
    return {
        "profile": "tabular-data-resource",
        "name": path.removesuffix(".csv").replace("/", "-").lower(),
        "path": path,
        "title": table.title,
        "format": "csv",
        "mediatype": "text/csv",
        "encoding": "utf-8",
        "bytes": len(content),
        "hash": f"sha256:{hashlib.sha256(content).hexdigest()}",
        "schema": {"fields": _fields(table), "missingValues": [""]},
    }


def _fields(table: DescribedTable) -> list[dict[str, str]]:
    """Columns of a table, in its order. One without a value is of texts."""
    import pandas as pd  # here, as it is slow to load

    frame = pd.read_csv(table.file, keep_default_na=False, na_values=[""])
    if unknown := [name for name in frame if name not in table.columns]:
        raise ValueError(f"{table.file}: nothing describes {', '.join(unknown)}")
    return [
        {"name": name, "type": _type(column), "description": table.columns[name]}
        for name, column in frame.items()
    ]


def _type(column: Any) -> str:
    """Type of the values of a column, gaps aside: whole numbers are numbers, as in another run they
    may have fractions.
    """
    kinds = {each.dtype.kind for each in [column.dropna().convert_dtypes().to_numpy()] if each.size}
    return _TYPES.get(kinds.pop() if kinds else "", "string")
