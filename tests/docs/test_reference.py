"""The pages of the reference are made from the present code, and every code has a remedy."""

import json
import re
import sys

import pytest
import yaml

from breaker.cli import main
from breaker.diagnosis import sentences
from breaker.records.rejections import TEXTS
from tests.scripts import ROOT, script

reference = script("docs/reference.py")
SECTIONS = ("limits", "session", "type", "estimate", "family")
"""Sections of the sentences of a diagnosis in which every code is a remark or an error."""


@pytest.mark.skipif(sys.version_info[:2] != (3, 11), reason="argparse prints help otherwise")
def test_pages_are_made_from_the_present_code():
    old = [file.name for file, text in reference.pages().items() if file.read_text("utf-8") != text]
    assert old == [], "run: python docs/reference.py"


def test_every_code_of_a_remark_is_in_troubleshooting():
    text = (ROOT / "docs/troubleshooting.md").read_text(encoding="utf-8")
    named = set(re.findall(r"`([a-z]+(?:-[a-z0-9]+)*)`", text))
    file = ROOT / "src/breaker/diagnosis/sentences.yaml"
    sections = yaml.safe_load(file.read_text(encoding="utf-8"))
    remarks = {*TEXTS, *(code for name in SECTIONS for code in sections[name])}
    assert remarks - named == set()
    assert {name for name in named if "-" in name} <= {*remarks, *sentences._templates()}


def keys(value, path=""):
    """Paths of the values of the records in a JSON document; parameters and the like are NAME."""
    if isinstance(value, list):
        return {key for part in value for key in keys(part, f"{path}[]")}
    if not isinstance(value, dict):
        return {path}
    if re.search(r"\.(parameters|effects|quantities)$", path):
        value = {"NAME": {name: part for item in value.values() for name, part in item.items()}}
    return {key for name, part in value.items() for key in keys(part, f"{path}.{name}".strip("."))}


def test_keys_of_an_answer_are_in_the_page(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    limit = {"name": "long", "motion": "closing", "of": "record", "upper": {"stroke": 9}}
    (tmp_path / "limits.yaml").write_text(yaml.safe_dump({"limits": [limit]}), encoding="utf-8")
    main(["example", "folder", "--inspections"])
    main(["inspect", "folder/inspection_2026-03-02.csv", "--output", "my.yaml"])
    capsys.readouterr()
    main(
        [
            "infer",
            "folder/inspection_2026-03-02.csv",
            "--config",
            "my.yaml",
            "limits.yaml",
            "--json",
        ]
    )
    named = []
    for line in reference.INFER.read_text(encoding="utf-8").splitlines():
        first, *others = line.split(": ")[0].split(", ")
        named += [first, *(f"{first.rpartition('.')[0]}.{name}" for name in others)]
    page = re.compile("|".join(rf"{re.escape(name)}(?:$|[.\[])" for name in named))
    given = keys(json.loads(capsys.readouterr().out))
    assert len(given) > 30
    assert {key for key in given if not page.match(key)} == set()
