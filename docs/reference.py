"""Write the pages of docs/reference from the code: commands, quantities, files and codes.

python docs/reference.py    # `make defaults` writes the page of settings
"""

import argparse
import inspect
import os
import re
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from unittest.mock import patch

import yaml

from breaker.cli import command
from breaker.configuration.settings import Settings
from breaker.diagnosis import sentences
from breaker.diagnosis.changes import QuantityChange
from breaker.diagnosis.explanations import Explanation
from breaker.diagnosis.inspection_change import InspectionChange
from breaker.model.quantities import OF_STROKE, quantities, speeds_of
from breaker.records.operations import EVENTS, READ, Operation
from breaker.records.rejections import TEXTS

FOLDER = Path(__file__).resolve().parent / "reference"
INFER = FOLDER / "infer_keys.txt"
"""Keys of the JSON of `breaker infer`, which a test compares with an answer."""

_SOURCES = {"record": "measured", "model": "inferred", "answer": "inferred"}
_WORSE = {1: "more", -1: "less", 0: ""}
_RENEWED = {"all": "the drive", "transducer": "the reading of the transducer"}


def table(head: str, rows: Iterable[Sequence[str]]) -> str:
    """Return a Markdown table; ``head`` has the names of the columns, separated by commas."""
    cells = [[" ".join(str(cell).split()).replace("|", "\\|") for cell in row] for row in rows]
    names = head.split(", ")
    lines = [names, ["---"] * len(names), *cells]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines).replace("``", "`") + "\n"


def attributes(kind: type) -> list[tuple[str, str]]:
    """Return names and meaning of the attributes of a class, from the entries of its docstring."""
    text = inspect.getdoc(kind).partition("Attributes:\n")[2].split("\n\n")[0]
    return re.findall(r"^ {4}(\w[\w, ]*): (.*(?:\n {8}.*)*)", text, re.M)


def commands() -> Iterator[str]:
    """Yield the help of every command."""
    with patch.dict(os.environ, {"COLUMNS": "90"}):
        parser = command.parser()
        (every,) = (e for e in parser._actions if isinstance(e, argparse._SubParsersAction))
        for name, part in {"": parser, **every.choices}.items():
            yield f"## breaker {name}".rstrip() + f"\n\n```text\n{part.format_help()}```\n"


def quantities_table() -> Iterator[str]:
    """Yield the table of all quantities."""
    rows = []
    for name, quantity in quantities(speeds_of(OF_STROKE)).items():
        motions = " and ".join(getattr(quantity, "motions", ()))
        sources = " or ".join(dict.fromkeys(_SOURCES[source] for source in quantity.of))
        meaning = quantity.unit, quantity.meaning
        rows.append((f"`{name}`", *meaning, motions, sources, _WORSE[quantity.worse]))
    yield "Limits `of: record` take measured quantities, and limits `of: model` inferred ones.\n"
    yield "The 6 mm of a speed scale with the stroke: 60 mm for a stroke of 125 mm.\n"
    yield table("name, unit, meaning, motion, source, worse", rows)


def files() -> Iterator[str]:
    """Yield the columns of operations.csv, and the keys of the JSON documents."""
    layout = Settings.model_fields["endurance"].annotation.model_fields["format"].annotation
    about = {name: text for names, text in attributes(Operation) for name in names.split(", ")}
    about |= {name: field.description for name, field in layout.model_fields.items()}
    about |= {"operation": about["number"], "from": about["begin"], "to": about["end"]}
    about["motion"] = "Motion of the record."
    cells = ((f"`{k}`", about[k], cell.what or "such as 2026-12-31") for k, cell in READ.items())
    events = ((k, _RENEWED[v[0]] if v else "nothing") for k, v in EVENTS.items())
    yield "Units are mm, ms and m/s. The first three columns of operations.csv are required.\n"
    yield table("column of operations.csv, meaning, a cell is", cells)
    yield table("event, what starts anew", events)
    yield "In JSON, an unknown value is `null` or absent. Look for [codes](codes.md), not texts.\n"
    documents = {
        "key of `breaker infer`": [s.split(": ", 1) for s in INFER.read_text().splitlines()],
        "key of `breaker compare`": attributes(InspectionChange),
        "key of a row of `measured` or `inferred`": attributes(QuantityChange),
        "key of a row of `explanations`": attributes(Explanation),
    }
    for title, keys in documents.items():
        yield table(f"{title}, meaning", ((f"`{names}`", text) for names, text in keys))


def codes() -> Iterator[str]:
    """Yield the sentence of every code."""
    text = Path(sentences.__file__).with_suffix(".yaml").read_text(encoding="utf-8")
    yield "[Troubleshooting](../troubleshooting.md) says what to do.\n"
    for name, texts in {"records": TEXTS, **yaml.safe_load(text)}.items():
        rows = ((f"`{code}`", sentence) for code, sentence in sorted(texts.items()))
        yield f"## {name}\n\n" + table("code, sentence", rows)


def pages() -> dict[Path, str]:
    """Return the text of every page by its file."""
    made = {"Commands": commands, "Quantities": quantities_table, "Files": files, "Codes": codes}
    head = "# {}\n\nThis page is made by `python docs/reference.py`.\n"
    texts = {name: "\n".join([head.format(name), *parts()]) for name, parts in made.items()}
    return {FOLDER / f"{name.lower()}.md": text for name, text in texts.items()}


if __name__ == "__main__":
    for file, text in pages().items():
        file.write_text(text, encoding="utf-8")
        print(f"written to {file}")
