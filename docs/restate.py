"""Write the numbers of runs into the README and the page on reproduction.

    python docs/restate.py

A paragraph or table with numbers of a run has a comment above it that names all its numbers, in
order: by the name in numbers.csv (the default run), by this name after ``paper.`` in
paper_numbers.csv (the paper's setting), or by its value if it is not a number of a run.
Names that begin with ``tables.`` are numbers from the tables of the studies, see ``from_tables``.

    <!-- numbers: closing.gap closing.gap_se 95 -->
    The mean gap is 0.07 ± 0.02 nats, and an interval of 95 % ...

In the README a paragraph without such a comment must not have a decimal number or a percentage.
"""

import csv
import re
import sys
from collections.abc import Mapping
from pathlib import Path

DOCS = Path(__file__).resolve().parent
README = DOCS.parent / "README.md"
PAGES = (README, DOCS / "research" / "reproduce.md")

_MARKED = re.compile(r"<!-- numbers:(?P<names>[^>]*?)-->\n(?P<block>.+?)(?=\n\s*\n|\n?\Z)", re.S)
_NUMBER = re.compile(r"(?<![\w.−-])[−-]?\d+(?:,\d{3})*(?:\.\d+)?(?!\w)")
_RESULT = re.compile(r"(?<!Python 3)(?<=\d)(?:\.\d| %)")
_PARAMETERS = ("mu", "k_a", "k_b", "gamma_a", "gamma_b", "f", "L")
_CODE = re.compile(r"```.*?```|`[^`\n]*`", re.S)


def read() -> dict[str, str]:
    """Return the numbers of both runs by name, as texts."""
    result = {}
    for prefix, table in (("", "numbers.csv"), ("paper.", "paper_numbers.csv")):
        with (DOCS / table).open(encoding="utf-8", newline="") as file:
            result |= {prefix + row["name"]: row["value"] for row in csv.DictReader(file)}
    return result | from_tables()


def _rows(table: str, **values: str) -> list[dict[str, str]]:
    """Return the rows of a table of a study with these values."""
    with (DOCS / table).open(encoding="utf-8", newline="") as file:
        rows = [*csv.DictReader(file)]
    return [row for row in rows if all(row[name] == value for name, value in values.items())]


def from_tables() -> dict[str, str]:
    """Return the numbers of the README from tables of the studies, as texts."""

    def percent(row: Mapping[str, str], column: str) -> str:
        return f"{100 * float(row[column]):.0f}"

    held = [percent(row, "coverage_90") for row in _rows("family_medium_voltage.csv")]
    state = [row for row in _rows("other_code.csv", of="level") if row["name"] in _PARAMETERS]
    covered = [percent(row, "hold") for row in state]
    numbers = {"family.lowest": min(held, key=int), "family.highest": max(held, key=int)}
    numbers |= {"other.lowest": min(covered, key=int), "other.highest": max(covered, key=int)}
    for name in ("f", "gamma_b"):
        (row,) = _rows("other_code.csv", of="change", drives="changed", name=name)
        numbers |= {f"{name}.reported": row["reported"], f"{name}.changed": row["truly_changed"]}
    for name in ("stroke", "separation_time"):
        (row,) = _rows("exports.csv", of=f"value: {name}")
        numbers |= {f"{name}.{key}": percent(row, key) for key in ("right", "withheld", "false")}
        numbers[f"{name}.values"] = row["values"]
    for limit, records in (("measured", "monitoring"), ("changed", "monitoring")):
        (row,) = _rows("plans.csv", limit=limit, **{"looked at": records})
        numbers |= {f"{limit}.{key}": f"{float(row[key]):.2f}" for key in ("cost", "low", "high")}
        numbers[f"{limit}.lives"] = row["lives"]
    for kind in ("due", "planned"):
        (row,) = _rows("alarms.csv", reported=kind, limit="measured")
        numbers |= {f"{kind}.false": row["false"], f"{kind}.of": row["of"]}
    for kind in ("all", "excursion"):
        (row,) = _rows("faults.csv", kind=kind)
        numbers |= {f"faults.{kind}.{key}": f"{int(row[key]):,}" for key in ("files", "silent")}
    return {f"tables.{name}": value for name, value in numbers.items()}


def restated(text: str, numbers: Mapping[str, str]) -> str:
    """Return a text with the numbers of its marked paragraphs corrected.

    Args:
        text: Markdown.
        numbers: Values by name.

    Raises:
        ValueError: If a name is unknown, or a comment and its paragraph differ in the count of
            numbers, or in a number that is not of the run.
    """
    return _MARKED.sub(lambda match: _block(match, numbers), text)


def unmarked(text: str) -> list[str]:
    """Return the paragraphs without a comment that state a decimal number or a percentage."""
    rest = _CODE.sub("", _MARKED.sub("", text))
    return [part for part in re.split(r"\n\s*\n", rest) if _RESULT.search(part)]


def _block(match: re.Match, numbers: Mapping[str, str]) -> str:
    names, block = match["names"].split(), match["block"]
    result = _NUMBER.findall(block)
    if len(names) != len(result):
        raise ValueError(f"{len(names)} numbers are named, but {result} stand in:\n{block}")
    for name, number in zip(names, result, strict=True):
        if _NUMBER.fullmatch(name) and name != number:
            raise ValueError(f"{name} is named, but {number} stands in:\n{block}")
        if not _NUMBER.fullmatch(name) and name not in numbers:
            raise ValueError(f"no number of the run is named {name}, in:\n{block}")
    values = iter(names)

    def value(_: re.Match) -> str:
        name = next(values)
        return numbers.get(name, name)

    return match[0][: -len(block)] + _NUMBER.sub(value, block)


def main() -> int:
    """Correct the numbers of all pages, and print which pages have changed."""
    numbers = read()
    for page in PAGES:
        old = page.read_text(encoding="utf-8")
        new = restated(old, numbers)
        page.write_text(new, encoding="utf-8")
        print(f"{page.name}: {'unchanged' if new == old else 'numbers put right'}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
