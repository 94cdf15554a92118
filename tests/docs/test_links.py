"""Every relative link of a text leads to a file, and to a heading where it names one."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGES = sorted(
    page
    for place in ("*.md", "config/*.md", "docs/**/*.md", "studies/*.md", "src/breaker/**/*.md")
    for page in ROOT.glob(place)
)
CODE = re.compile(r"^```.*?^```", re.S | re.M)
LINK = re.compile(r"\]\((?!https?:)([^)#\s]*)(?:#([^)\s]*))?\)")
# Names of pages in comments, messages and texts without a link, from the project's folder.
NAMED = re.compile(r"(?<![\w/.])docs/[\w/]+\.(?:md|csv|png|svg|py)")
FILES = ["Makefile", *(f"{name}/**/*" for name in ("config", "envs", "src", "studies", "workflow"))]


def anchors(page):
    """Return the anchors of a page's headings, as GitHub makes them."""
    text = CODE.sub("", page.read_text(encoding="utf-8"))
    titles = re.findall(r"^#+ (.*)$", text, re.M)
    return {re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-") for title in titles}


def broken(page):
    """Return the links of a page that lead nowhere."""
    links = LINK.findall(CODE.sub("", page.read_text(encoding="utf-8")))
    places = [(page.parent / path if path else page, anchor) for path, anchor in links]
    return [
        f"{place}#{anchor}"
        for place, anchor in places
        if not place.exists() or (anchor and anchor not in anchors(place))
    ]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_links_lead_somewhere(page):
    assert broken(page) == []


def test_pages_that_programs_and_pages_name_are_there():
    files = {file for place in FILES for file in ROOT.glob(place) if file.is_file()}
    texts = [file.read_bytes().decode("utf-8", "ignore") for file in {*files, *PAGES}]
    named = {name for text in texts for name in NAMED.findall(text)}
    assert sorted(name for name in named if not (ROOT / name).exists()) == []


def test_commands_that_a_page_for_newcomers_names_exist():
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    goals = set(re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.M))
    assert set(re.findall(r"(?:`|^)make ([a-z-]+)", text, re.M)) <= goals


def test_a_link_that_leads_nowhere_is_found(tmp_path):
    page = tmp_path / "page.md"
    page.write_text("# A `b`, c\n\n[1](#a-b-c) [2](page.md#a) [3](other.md) [4](https://a.b)\n")
    assert broken(page) == [f"{page}#a", f"{tmp_path / 'other.md'}#"]
