"""The page for newcomers names commands that exist."""

import re
from pathlib import Path

ROOT = Path(__file__).parents[2]


def test_commands_that_a_page_for_newcomers_names_exist():
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    goals = set(re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.M))
    assert set(re.findall(r"(?:`|^)make ([a-z-]+)", text, re.M)) <= goals
