"""Check words, the length of sentences and names, for ``make lint``: no word of ``AVOIDED``, no
sentence of more than ``LONGEST`` words, no identifier with a part in ``NAMES`` or in ``VAGUE``."""

import ast
import re
import sys
import tokenize
from collections.abc import Iterator
from pathlib import Path

import yaml

AVOIDED = r"told|tells?|foretells?|foretold|beside|anew|whole|alike|odd|strange|visits?"
AVOIDED += r"|(?:is|are) (?:no|none)|of which|other code"
LONGEST = 25
NAMES = {"told", "foretold", "visit", "visits", "beside", "anew", "part_time", "wipe_at_touch"}
VAGUE = {"each", "found"}  # as a name alone
PAGES = ("*.md", "docs/*.md", "docs/[!r]*/*.md", "docs/research/*.md", "[cs]*/*.md", "src/*/*/*.md")
TEXTS = ("workflow/report/*.rst", "src/breaker/diagnosis/sentences.yaml", "src/breaker/cli/*.py")
CODE = ("src/**/*.py", "studies/**/*.py", "tests/**/*.py", "workflow/**/*.py", "workflow/**/*.smk")
_LEFT_OUT = r"```.*?```|<!--.*?-->|\]\([^)]*\)|`[^`\n]*`|\{[{%].*?[%}]\}|\{[^}]*\}"
_BETWEEN = r"^ *\|.*$|(?<=[.!?:;])[*_]*\s+|\n\s*\n|\n\s*(?:[-*#>]|\d+\.)\s"


def texts_of(file: Path) -> list[str]:
    """Return the texts of a page, of a file of templates, or of the help of a command."""
    content = file.read_text(encoding="utf-8")
    if file.suffix == ".yaml":
        return [text for part in yaml.safe_load(content).values() for text in part.values()]
    if file.suffix == ".py":
        words = (node for node in ast.walk(ast.parse(content)) if isinstance(node, ast.keyword))
        return [str(getattr(w.value, "value", "")) for w in words if w.arg in ("help", "epilog")]
    return [content]


def check_text(text: str) -> Iterator[str]:
    """Yield the avoided words and the long sentences of a text in Markdown or plain words."""
    text = re.sub(_LEFT_OUT, " x ", text, flags=re.S | re.M)
    yield from (f"avoid {word!r}" for word in re.findall(rf"\b(?:{AVOIDED})\b", text, re.I))
    for words in map(str.split, re.split(_BETWEEN, text, flags=re.M)):
        if len(words) > LONGEST:
            yield f"{len(words)} words: {' '.join(words[:9])} ..."


def check_names(file: Path) -> Iterator[str]:
    """Yield the banned identifiers (tokens of type 1) of a file of code."""
    with tokenize.open(file) as code:
        names = {t.string for t in tokenize.generate_tokens(code.readline) if t.type == 1}
    banned = (name for name in names if NAMES & {name, *name.split("_")} or name in VAGUE)
    yield from (f"rename {name}" for name in sorted(banned))


if __name__ == "__main__":
    texts = [(f, t) for place in PAGES + TEXTS for f in Path().glob(place) for t in texts_of(f)]
    lines = {f"{file}: {fault}" for file, text in texts for fault in check_text(text)}
    code = (file for place in CODE for file in Path().glob(place))
    lines |= {f"{file}: {fault}" for file in code for fault in check_names(file)}
    print(*sorted(lines), sep="\n")
    sys.exit(bool(lines))
