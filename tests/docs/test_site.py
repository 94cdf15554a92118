"""The site of the documentation: its navigation, pages and environment; `make site` builds it."""

import ast
import importlib.util
import re
from pathlib import Path

import pytest

import breaker

ROOT = Path(__file__).parents[2]
NAVIGATION = ROOT / "mkdocs.yml"


@pytest.fixture(scope="module")
def site():
    """The module that writes the pages."""
    spec = importlib.util.spec_from_file_location("pages_of_site", ROOT / "envs/site.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def missing(pages):
    """Pages that neither exist nor are written as the site is built."""
    return [page for page in pages if page != "api/index.md" and not (ROOT / page).is_file()]


def test_the_navigation_names_pages_that_exist_and_none_is_left_out(site):
    pages = site.navigation(NAVIGATION.read_text(encoding="utf-8"))
    assert missing(pages) == []
    assert missing([*pages, "docs/gone.md"]) == ["docs/gone.md"]
    assert {f"docs/{page.name}" for page in (ROOT / "docs").glob("*.md")} <= set(pages)
    assert {page.name for page in ROOT.glob("*.md")} <= set(pages)


def test_examples_of_docstrings_become_blocks_and_code_stays_code(site):
    text = '''def f():
    """Do.

    >>> a = [1,
    ...      2]
    >>> a
    [1, 2]
    """
'''
    assert site.fenced(text).count("```") == 2
    assert ast.literal_eval(ast.unparse(ast.parse(site.fenced(text)).body[0].body[0])).endswith(
        "    [1, 2]\n    ```\n    "
    )
    for file in Path(breaker.__file__).parent.rglob("*.py"):
        ast.parse(site.fenced(file.read_text(encoding="utf-8")))


def test_its_lock_has_hashes_and_what_is_asked_for():
    lock = (ROOT / "envs/site.lock").read_text(encoding="utf-8").replace("\\\n", " ")
    pins = [line for line in lock.splitlines() if line and not line.startswith("#")]
    assert all("--hash=sha256:" in line for line in pins)
    asked = re.findall(r"^[\w-]+", (ROOT / "envs/site.in").read_text(encoding="utf-8"), re.M)
    assert set(asked) <= {line.split("==")[0] for line in pins}
