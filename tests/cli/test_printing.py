"""Names that others gave, on the terminal, by every command."""

import json
import re

import pytest

from breaker.cli import main

ACTS = re.compile(r"[\x00-\x08\x0b-\x1f\x7f-\x9f\u200b-\u200f\u202a-\u202e\u2060-\u2069\ufeff]")
NASTY = "\x1b[31m\u202e\u200b"
COMMANDS = [
    "inspect {file}",
    "infer {file} --config own.yaml",
    "infer {file} --config own.yaml --json",
    "infer {file} --channel {nasty}",
    "compare {file} --today open.csv --config own.yaml",
    "report {file} --output r.html --config own.yaml",
    "inspect records",
    "fit-prior records --config own.yaml",
]


def _exported(folder, name, column, **stated):
    """The closing of a folder as an export with names that others gave."""
    samples = [line for line in (folder / "a.csv").read_text().splitlines() if line[:1].isdigit()]
    rows = [line.replace(",", ";") for line in samples]
    head = [f"{key};{value}" for key, value in stated.items()]
    (folder / "records").mkdir(exist_ok=True)
    text = "\n".join([*head, "", f"time (s);{column} (mm)", *rows])
    (folder / "records" / name).write_text(text, encoding="utf-8")
    return f"records/{name}"


@pytest.fixture
def file(folder):
    stated = {"Station": f"S{NASTY}", "Bay": f"Q0{NASTY}", "Phase": f"L1{NASTY}"}
    name = _exported(folder, f"b{NASTY}.csv", f"Weg{NASTY}", **stated, Stroke="150 mm")
    assert main(["inspect", name, "--output", "own.yaml"]) == 0
    return name


@pytest.mark.parametrize("command", COMMANDS)
def test_no_name_acts_on_the_terminal(file, capsys, command):
    capsys.readouterr()
    words = [word.format(file=file, nasty=NASTY) for word in command.split(" ")]
    main(words)
    out, err = capsys.readouterr()
    assert out + err
    assert not ACTS.search(out + err)
    if "--json" in words:
        assert json.loads(out)["records"][0]["accepted"]
