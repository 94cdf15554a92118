"""Ask the product as a user does, and what of its answers is false or a word of warning."""

import html
import json
import re
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

from studies.exports.__main__ import call

Command = Sequence[object]
# What every plain file gets, and what only says which setting holds, names no trouble.
STANDING = (
    r"- the sign is a guess(?:.*\n)(?: {4}.*\n)*|^note: .*$"
    r"|^the phase is not stated \(before: no phase; today: no phase\).*$"
)
WARNING_KEYS = ("warnings", "remarks", "doubts", "rejected", "differences")


class Said(NamedTuple):
    """What a command printed; `document` is its JSON, if it printed one, and `page` its report."""

    status: int | str
    text: str
    err: str
    document: dict
    page: str = ""

    @property
    def crashed(self) -> bool:
        """Say whether it ended in an exception."""
        return isinstance(self.status, str) and "Traceback" in self.status

    @property
    def inspection(self) -> bool:
        """Say whether it is that of `breaker inspect`."""
        return not self.document and (
            "Proposed, to lay over" in self.text or "To look at:" in self.text
        )

    @property
    def records(self) -> list[dict]:
        """Return accepted records of `breaker infer`."""
        found = self.document.get("records", [])
        return [each for each in found if isinstance(each, dict) and each.get("accepted")]

    @property
    def words(self) -> str:
        """Return what it says beside the answer."""
        if self.document:
            return "\n".join([self.err, *sentences(self.document)])
        if self.inspection:
            found = re.findall(r"To look at:\n((?:.+\n)+)", self.text)
            found += re.findall(r".*(?:REJECTED|FILL IN|<$).*(?:\n {4}.*)*", self.text, re.M)
            return "\n".join([self.err, *found])
        return "\n".join([self.err, self.text, self.page])


class Question(NamedTuple):
    """Commands about files, and what of the answers is false.

    `layout` and `today` are files by which `breaker inspect` proposes how all, or those of the
    visit today, are read; `own` is laid over it. `look`: its remarks count as words, too.
    """

    commands: Sequence[Command]
    false: Callable[[Sequence[Said]], str]
    layout: Path | None = None
    today: Path | None = None
    own: str = ""
    look: bool = False
    strip: bool = False


def sentences(document: dict) -> list[str]:
    """Return the sentences of a JSON document that warn, reject or withhold."""
    found: list[str] = []
    for key in WARNING_KEYS:
        found += flat(document.get(key))
    own = document.get("sentences") or []
    found += [each["text"] for each in own if each["code"].endswith("-check")]
    records = document.get("records")
    for record in records if isinstance(records, list) else []:
        found += flat(record.get("remarks")) + flat(record.get("reason"))
        found += flat((record.get("fit") or {}).get("reason"))
        own = record.get("quantities") or {}
        found += [
            t for n in ("stroke", "travel_time") for t in flat((own.get(n) or {}).get("reason"))
        ]
        for limit in record.get("limits") or []:
            found += flat(limit.get("reason"))
    return found


def flat(value: object) -> list[str]:
    """Return all texts in a value."""
    if isinstance(value, dict):
        return [text for each in value.values() for text in flat(each)]
    if isinstance(value, list):
        return [text for each in value for text in flat(each)]
    return [value] if isinstance(value, str) else []


def one_call(command: Command, options: Sequence[object] = ()) -> Said:
    """Call a command, and read what it prints or writes."""
    status, text, err = call(*command, *options)
    document, page = {}, ""
    if "--json" in command:
        with suppress(json.JSONDecodeError):
            document = json.loads(text)
    if command[0] == "report":
        file = Path(str(command[list(command).index("--output") + 1]))
        page = file.read_text(encoding="utf-8") if file.exists() else ""
        page = re.sub(r"<(style|script|svg)\b.*?</\1>", " ", page, flags=re.S)
        page = html.unescape(re.sub(r"<[^>]*>", " ", page))
    return Said(status, text, err, document, page)


def layout_of(file: Path, to: Path, question: Question) -> tuple[list[Path], Said]:
    """Return the proposed layout of a file, as a list that is empty where there is none."""
    to.unlink(missing_ok=True)
    said = one_call(["inspect", file, "--output", to])
    if to.exists() and question.strip:
        lines = to.read_text(encoding="utf-8").splitlines(keepends=True)
        to.write_text("".join(n for n in lines if "    stroke:" not in n), encoding="utf-8")
    return ([to] if to.exists() else []), said


def answers(question: Question, folder: Path) -> list[Said]:
    """Ask, and return what each command says; first `breaker inspect` where its words count."""
    options: list[object] = []
    said: list[Said] = []
    configs: list[Path] = []
    if question.layout is not None:
        configs, look = layout_of(question.layout, folder / "layout.yaml", question)
        said += [look] if question.look else []
    if question.own:
        own = folder / "own.yaml"
        own.write_text(question.own, encoding="utf-8")
        configs.append(own)
    if configs:
        options = ["--config", *configs]
    if question.today is not None:
        found, _ = layout_of(question.today, folder / "today.yaml", question)
        options += ["--config-today", *found] if found else []
    return said + [one_call(command, options) for command in question.commands]


def off(
    motion: str, truth: dict, tolerance: float = 0.02, names: Sequence[str] = ()
) -> Callable[[Sequence[Said]], str]:
    """Return a test of measured values: which are false beyond their intervals and a tolerance."""

    def false(said: Sequence[Said]) -> str:
        found = []
        for record in [r for each in said for r in each.records]:
            if record["motion"] != motion:
                found.append(f"told as {record['motion']}")
                continue
            for name in names or ("stroke", "travel_time"):
                item = (record.get("quantities") or {}).get(name) or {}
                value, ends = item.get("median"), item.get("interval_95") or [0.0, 0.0]
                if value is None or item.get("source") in ("estimated", "mixed"):
                    continue
                room = max(tolerance * truth[name], ends[1] - ends[0])
                if abs(value - truth[name]) > room:
                    found.append(f"{name} {value:.4g} ±{(ends[1] - ends[0]) / 2:.2g}")
                    found[-1] += f" (true {truth[name]:.4g})"
        return "; ".join(dict.fromkeys(found))

    return false


def _rows(said: Sequence[Said], kind: str) -> list[dict]:
    """Return the rows of comparisons that are "measured" or "inferred"."""
    return [row for each in said for row in each.document.get(kind, [])]


def told(said: Sequence[Said]) -> str:
    """Return parameters of the drive that are told as changed, or else what is measured so."""
    inferred, measured = (
        [f"{row['name']} {row['change'][1]:+.0f} %" for row in _rows(said, kind) if row["changed"]]
        for kind in ("inferred", "measured")
    )
    return "; ".join(inferred) or (measured and f"measured {'; '.join(measured)}") or ""


def compared(said: Sequence[Said]) -> str:
    """Return that visits are compared, where they must not be without a word."""
    rows = [*_rows(said, "measured"), *_rows(said, "inferred")]
    return f"{len(rows)} rows compared; told: {told(said) or 'no change'}" if rows else ""


def answered(said: Sequence[Said]) -> str:
    """Return that something was answered, where no answer can be right without a word."""
    own = [each for each in said if not each.inspection]
    count = sum(len(each.records) for each in own if each.document)
    texts = [each for each in own if not each.document and each.status == 0]
    return f"{count} records, {len(texts)} texts" if count or texts else ""


class Kind(NamedTuple):
    """A kind of input: what makes it or its right twin, and the words that name its trouble."""

    make: Callable[..., Question]
    words: str
