"""What somebody who joins finds: forms that parse, and a paper that cites what it lists."""

import re
from pathlib import Path

import pytest
import yaml

ROOT = Path(__file__).parents[2]
FORMS = sorted((ROOT / ".github/ISSUE_TEMPLATE").glob("*.yml"))
PAPER = ROOT / "docs/joss/paper.md"
FIELDS = {"markdown", "input", "textarea", "dropdown"}


def content(form):
    return yaml.safe_load(form.read_text(encoding="utf-8"))


@pytest.mark.parametrize("form", [f for f in FORMS if f.stem != "config"], ids=lambda f: f.stem)
def test_a_form_has_what_its_host_asks_for(form):
    stated = content(form)
    assert (
        {"name", "description", "body"} <= set(stated) <= {"name", "description", "labels", "body"}
    )
    assert {field["type"] for field in stated["body"]} <= FIELDS
    asked = [field for field in stated["body"] if field["type"] != "markdown"]
    names = [field["id"] for field in asked]
    assert len(set(names)) == len(names)
    assert all(field["attributes"]["label"] for field in asked)


def test_the_form_of_a_misread_file_asks_for_what_reading_it_needs():
    stated = content(ROOT / ".github/ISSUE_TEMPLATE/misread_file.yml")["body"]
    required = {f["id"] for f in stated if f.get("validations", {}).get("required")}
    assert required == {"instrument", "report", "truth", "publish"}  # the report has the rest


def unknown(text, references):
    """Keys that a text cites and its references lack, and those that it does not cite."""
    cited = set(re.findall(r"@([a-z]+\d*)", text))
    return cited ^ set(re.findall(r"^@\w+\{(\w+),", references, re.MULTILINE))


def test_the_paper_has_the_sections_and_references_of_its_journal():
    _, head, text = PAPER.read_text(encoding="utf-8").split("---\n", 2)
    stated = yaml.safe_load(head)
    assert {"title", "tags", "authors", "affiliations", "date", "bibliography"} <= set(stated)
    headings = re.findall(r"^# (.*)$", text, re.MULTILINE)
    assert headings[:3] == ["Summary", "Statement of need", "State of the field"]
    assert headings[-1] == "References"
    references = (PAPER.parent / stated["bibliography"]).read_text(encoding="utf-8")
    assert unknown(text, references) == set()
    assert unknown(text.replace("@sbi", "@sbi2"), references) == {"sbi", "sbi2"}
    assert 250 < len(text.split()) < 1750


def test_commands_that_a_page_for_newcomers_names_exist():
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    goals = set(re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.M))
    assert set(re.findall(r"(?:`|^)make ([a-z-]+)", text, re.M)) <= goals
