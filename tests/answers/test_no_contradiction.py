"""Sentences of a comparison never contradict each other, whatever two visits show: made-up ones."""

import re
from functools import cache

import numpy as np
import pytest

from breaker.documents.terminal import text_of
from breaker.drive.answers.comparability import unlike
from breaker.drive.answers.visit_changes import VERDICT_WORDS, VisitChanges, measured_changes
from breaker.drive.answers.visit_document import (
    ComparisonSettings,
    visits_document,
    words_of_visits,
)
from breaker.drive.family.membership import PARTS, Match
from breaker.quantities.parameters import MOTIONS, NAMES
from tests.answers.test_visited import SPEEDS, records

CHANGED, NOT_TOLD, SAME = VERDICT_WORDS
DRAWS, LEAST, VISITS = 400, 0.001, 120


@cache  # of two visits, by how slow and how far the second is
def measured(slow, stroke):
    return measured_changes(records(), records(slow=slow, stroke=stroke), SPEEDS)


def drawn(rng, size):
    """Draws of a relative change: none, small or large, known well or badly."""
    some = rng.normal(rng.choice([0.0, 0.03, 0.06, -0.1, 0.3]), rng.choice([0.005, 0.03]), size)
    return np.where(rng.random(size) < rng.choice([0.0, 0.4, 0.98]), 0.0, some)


def compared(number):
    """A comparison in which every kind of answer occurs, as of a number."""
    rng = np.random.default_rng(number)
    p_values = rng.choice([0.5, 0.05, 1e-5], p=[0.6, 0.3, 0.1], size=4)
    each = iter(p_values)
    matches = {
        m: {v: Match(next(each), dict.fromkeys(PARTS, 1.0), None) for v in ("before", "today")}
        for m in MOTIONS
    }
    fits, agreement = p_values.min() >= LEAST, rng.choice([0.4, 1e-4], p=[0.8, 0.2])
    whole = [(m,) for m in MOTIONS] if agreement < LEAST else [MOTIONS]
    told = whole if fits and rng.random() < 0.9 else []
    found = VisitChanges(
        "medium_voltage",
        matches,
        {m: {"before": 80.0, "today": 80.0} for m in MOTIONS},
        {},
        bool(fits),
        {m: 1.0 + np.stack([drawn(rng, DRAWS) for _ in NAMES], 1) for m in told},
        {m: drawn(rng, DRAWS) for m in MOTIONS if told},
        {n: drawn(rng, DRAWS) for n in ("drag", "build_up") if len(told) == 1},
        float(agreement),
        str(rng.choice(NAMES)),
    )
    rows = measured(rng.choice([1.0, 1.03, 1.15]), rng.choice([80.0, 80.8, 74.0, 131.2]))
    return visits_document(
        found,
        rows,
        unlike(rows, found.strokes, {}),
        ComparisonSettings(0.05, 1, LEAST),
        limits=[],
        records={m: {"before": 2, "today": 2} for m in MOTIONS},
        rejected=[],
    )


def contradictions(document):
    """Pairs of sentences of a comparison that cannot both be true."""
    headline, trust = document.headline, " ".join(document.trust)
    text = " ".join(text_of(words_of_visits(document)).split())
    rows, found = [*document.changes, *document.mechanisms], []
    moved = any(row.kind == "measured" and row.verdict == CHANGED for row in rows)
    named = re.findall(r"(\w+(?: \((?:closing|opening)\))?) [+-][\d.]+ % \(", headline)
    by = {row.label: row for row in rows}
    found += [f"{n} is changed and {by[n]['verdict']}" for n in named if by[n].verdict != CHANGED]
    others = re.split(r"cannot be told: |not beyond [\d.]+ %: ", headline)[1:]
    twice = [n for n in named for some in others if re.search(rf"\b{re.escape(n)}(,|;|$)", some)]
    found += [f"{n} is changed and not" for n in twice]
    inferred = [n for n in named if by[n].kind != "measured"]
    if inferred and (not moved or document.parameters != "told"):
        found.append(f"{inferred} changed, and {headline}")
    if "look like both visits" in trust and "of no family" in headline:
        found.append("family fits and does not")
    if "agree (" in trust and "contradict" in f"{trust} {headline}":
        found.append("motions agree and contradict")
    if named and "No change of the drive is told" in headline:
        found.append("a change, and none is told")
    found += [f"look at {n}, which is not told" for n in document.worse if n not in headline]
    for row in rows:
        low, _, high = row.change
        if row.verdict == CHANGED and (row.unchanged or 0.0) > 0.05:
            found.append(f"{row.name} changed and is the same")
        if row.verdict == SAME and (low > 5.0 or high < -5.0):
            found.append(f"{row.name} is the same, and its interval is beyond")
    if "all others" in headline and NOT_TOLD in {
        r.verdict for r in rows if r.kind in ("parameter", "time")
    }:
        found.append("all others are the same, and some cannot be told")
    assert headline.split("\n")[0] in text
    return found


@pytest.fixture(scope="module")
def visits():
    return [compared(number) for number in range(VISITS)]


def test_made_up_visits_have_every_kind_of_answer(visits):
    states = {each.parameters for each in visits}
    assert states == {"told", "withheld", "beyond", "apart", "unlike"}
    lines = " ".join(each.headline for each in visits)
    for some in ("Changed: ", "Mechanisms beside", "No parameter is told: nothing", "all others"):
        assert some in lines


def test_no_sentence_of_a_comparison_contradicts_another(visits):
    assert {n: found for n, each in enumerate(visits) if (found := contradictions(each))} == {}
