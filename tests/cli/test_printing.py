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
    "inspect .",
]


@pytest.mark.parametrize("command", COMMANDS)
def test_no_name_acts_on_the_terminal(folder, capsys, command):
    """The closing of the folder as an export with names that others gave."""
    text = (folder / "a.csv").read_text()
    rows = [line.replace(",", ";") for line in text.splitlines() if line[:1].isdigit()]
    head = [f"{key};{key[0]}{NASTY}" for key in ("Station", "Bay", "Phase")]
    lines = [*head, "Stroke;150 mm", "", f"time (s);Weg{NASTY} (mm)", *rows]
    (folder / (file := f"b{NASTY}.csv")).write_text("\n".join(lines), encoding="utf-8")
    assert main(["inspect", file, "--output", "own.yaml"]) == 0
    capsys.readouterr()
    main([word.format(file=file, nasty=NASTY) for word in command.split()])
    out, err = capsys.readouterr()
    assert out + err
    assert not ACTS.search(out + err)
    if "--json" in command:
        assert json.loads(out)["records"][0]["accepted"]
