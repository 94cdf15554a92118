"""All kinds of wrong inputs, and one case of a kind: the input, its twin, and the verdicts."""

import re
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

from studies.wrong_inputs.ask import STANDING, Kind, Said, answers
from studies.wrong_inputs.desk import Desk
from studies.wrong_inputs.folders import FOLDERS
from studies.wrong_inputs.records import RECORDS
from studies.wrong_inputs.texts import TEXTS
from studies.wrong_inputs.visits import VISITS

KINDS: dict[str, Kind] = {**RECORDS, **TEXTS, **VISITS, **FOLDERS}


def plain(text: str, folder: str) -> str:
    """Return a text without names of files, and without what every plain file gets."""
    text = re.sub(re.escape(folder) + r"[\w./]*", "FILE", text) if folder else text
    return re.sub(STANDING, "", text, flags=re.MULTILINE)


def verdict(said: Sequence[Said], false: Callable, words: str, folder: str = "") -> dict:
    """Return what became of an input: silent, warned, told beside a word, or crashed.

    Silent is what is false without a word; `warned` has a word, `beside` is false nevertheless,
    and `inspect_only` has its word from `breaker inspect` alone, not with the answer.
    Names of files are no words.
    """
    text = plain("\n".join(each.words for each in said), folder)
    found = re.search(words, text, re.IGNORECASE | re.MULTILINE)
    answer = plain("\n".join(each.words for each in said if not each.inspection), folder)
    own = re.search(words, answer, re.IGNORECASE | re.MULTILINE)
    wrong = "" if any(each.crashed for each in said) else false(said)
    line = next((n for n in text.splitlines() if found and found[0] in n), "").strip()
    return {
        "silent": bool(wrong) and not found,
        "warned": bool(found),
        "inspect_only": bool(found) and not own,
        "beside": bool(wrong) and bool(found),
        "crashed": any(each.crashed for each in said),
        "false": wrong,
        "word": line[:200],
    }


def one_input(kind: str, number: int, seed: int, wrong: bool, folder: Path) -> dict:
    """Make one input in a folder, ask the product, and return the verdict on it."""
    place = folder / ("wrong" if wrong else "right")
    desk = Desk.draw([seed, number, *kind.encode()], place)
    question = KINDS[kind].make(desk, wrong)
    begun = time.perf_counter()
    said = answers(question, place)
    seconds = time.perf_counter() - begun
    row = {"kind": kind, "number": number, "wrong": wrong, "seconds": round(seconds, 2)}
    row |= verdict(said, question.false, KINDS[kind].words, str(place))
    row["commands"] = " && ".join(" ".join(map(str, each)) for each in question.commands)
    return row


def one_case(kind: str, number: int, seed: int, keep: Path | None = None) -> list[dict]:
    """Return the verdicts on a wrong input and on its right twin, made from the same draws."""
    with TemporaryDirectory() as scratch:
        folder = (keep or Path(scratch)) / kind.replace(" ", "_").replace(",", "") / str(number)
        return [one_input(kind, number, seed, wrong, folder) for wrong in (True, False)]
