"""Copy the pages of the documentation, and write an API reference, for ``mkdocs.yml``.

Run by ``make site``, from the project's folder. The folder of pages mirrors the project, so that
links between pages, tables and code work as in the project.
"""

import re
import shutil
from collections.abc import Iterator
from pathlib import Path

__all__ = ["fenced", "linked", "navigation", "public_modules"]

ROOT = Path(__file__).resolve().parents[1]
PAGES = ROOT / "build" / "site" / "pages"
SOURCES = ROOT / "build" / "site" / "src"  # for the reference: examples in docstrings as code

_LINK = re.compile(r"\]\((?!https?:)([^)#\s]+)")
_EXAMPLE = re.compile(r'^( *)>>> .*(?:\n(?!\1""")\1\S.*)*', re.MULTILINE)
_API = """\
# API

Modules of the package, by folder. [Extend](../docs/research/extend.md) shows the way in, [the
map](../docs/development.md#the-map) what each folder contains.

"""


def navigation(text: str) -> list[str]:
    """Return the pages in the navigation of the text of ``mkdocs.yml``."""
    return re.findall(r"^ +- .*: (\S+\.md)$", text, re.MULTILINE)


def linked(pages: list[str]) -> set[Path]:
    """Return pages and all files they link to or show, recursively, relative to the project."""
    waiting, result = [ROOT / page for page in pages], set()
    while waiting:
        file = waiting.pop().resolve()
        if file in result or not file.is_file():
            continue
        result.add(file)
        if file.suffix == ".md":
            links = _LINK.findall(file.read_text(encoding="utf-8"))
            waiting += [file.parent / link for link in links]
    return {file.relative_to(ROOT) for file in result}


def public_modules() -> Iterator[tuple[str, list[str]]]:
    """Yield the folders of the package, except the command line, with their modules."""
    package = ROOT / "src" / "breaker"
    for face in sorted(package.rglob("__init__.py")):
        room = face.parent
        if "cli" in room.parts:
            continue
        files = [f for f in sorted(room.glob("*.py")) if not f.name.startswith("_")]
        name = ".".join(room.relative_to(package.parent).parts)
        if files:
            yield name, [f"{name}.{file.stem}" for file in files]


def fenced(text: str) -> str:
    """Return code with the examples of its docstrings as blocks of code in Markdown."""
    return _EXAMPLE.sub(r"\1```pycon\n\g<0>\n\1```", text)


def main() -> None:
    """Write all pages."""
    shutil.rmtree(SOURCES, ignore_errors=True)
    for file in (ROOT / "src" / "breaker").rglob("*.py"):
        copy = SOURCES / file.relative_to(ROOT / "src")
        copy.parent.mkdir(parents=True, exist_ok=True)
        copy.write_text(fenced(file.read_text(encoding="utf-8")), encoding="utf-8")
    shutil.rmtree(PAGES, ignore_errors=True)
    stated = navigation((ROOT / "mkdocs.yml").read_text(encoding="utf-8"))
    for page in linked([page for page in stated if not page.startswith("api/")]):
        (PAGES / page).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / page, PAGES / page)
    (PAGES / "api").mkdir()
    index = _API
    for room, modules in public_modules():
        index += f"- [`{room}`]({room}.md)\n"
        text = f"# `{room}`\n\n" + "".join(f"::: {module}\n\n" for module in modules)
        (PAGES / "api" / f"{room}.md").write_text(text, encoding="utf-8")
    (PAGES / "api" / "index.md").write_text(index, encoding="utf-8")


if __name__ == "__main__":
    main()
