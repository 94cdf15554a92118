"""The site of the documentation: its navigation, pages and environment; `make site` builds it."""

import re

from tests.scripts import ROOT, script


def missing(pages):
    """Pages that neither exist nor are written as the site is built."""
    return [page for page in pages if page != "api/index.md" and not (ROOT / page).is_file()]


def test_the_navigation_names_pages_that_exist_and_none_is_left_out():
    pages = script("envs/site.py").navigation((ROOT / "mkdocs.yml").read_text(encoding="utf-8"))
    assert missing(pages) == []
    assert missing([*pages, "docs/gone.md"]) == ["docs/gone.md"]
    assert {str(page.relative_to(ROOT)) for page in (ROOT / "docs").rglob("*.md")} <= set(pages)
    assert {page.name for page in ROOT.glob("*.md")} <= set(pages)


def test_its_lock_has_hashes_and_what_is_asked_for():
    lock = (ROOT / "envs/site.lock").read_text(encoding="utf-8").replace("\\\n", " ")
    pins = [line for line in lock.splitlines() if line and not line.startswith("#")]
    assert all("--hash=sha256:" in line for line in pins)
    asked = re.findall(r"^[\w-]+", (ROOT / "envs/site.in").read_text(encoding="utf-8"), re.M)
    assert set(asked) <= {line.split("==")[0] for line in pins}
