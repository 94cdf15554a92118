"""The first page: what is said follows from the tables, and nothing else."""

import numpy as np

from breaker.drive.life.first_page import (
    headline,
    limit_words,
    look_first,
    opening,
    since_new,
    trust,
)
from tests.life.test_tables import tables
from tests.lives import a_life


def said(life):
    decisions, limits, changes = tables(life)
    return headline(decisions, limits), since_new(changes, life), trust(life)


def test_a_healthy_drive_says_what_is_next():
    words, new, belief = said(a_life(fails=(900.0, np.inf)))
    assert words.startswith("Healthy: next is slow, 400 operations left (200 to 600).")
    assert "As of operation 500." in words
    assert "drive friction +10 % (+7.5 to +12)" in new
    assert "perhaps contact gap, by up to 3 %" in new
    assert "nothing else beyond 2 %" in new
    assert "medium_voltage" in belief
    assert "agree" in belief


def test_a_plan_names_operation_and_limit_and_what_cannot_be_told():
    words, *_ = said(a_life(fails=(600.0, 590.0)))
    assert words.startswith("Plan service by operation 5")
    assert "slow" in words
    assert "Cannot tell stiff (P < 1 %)." in words


def test_an_exceeded_limit_is_said_with_the_operation_since_when():
    life = a_life()
    words, *_ = said(life)
    assert words.startswith("Service now: exceeded: slow (certain at 450).")
    _, limits, _ = tables(life)
    row = limit_words(limits).iloc[0]
    assert row["operations left (90 %)"] == "exceeded: certain at 450, crossed about 450"
    assert row["P"] == "> 99 %"


def test_what_is_not_known_is_not_said():
    alone = a_life(family="")
    assert "parameters are withheld" in said(alone)[1]
    assert "of no family" in trust(alone.assign_attrs(agreement=1.0))
    assert "contradict" in trust(alone.assign_attrs(agreement=0.001))
    words, new, _ = said(a_life(told=1000, fails=(900.0, np.inf)))
    assert words.startswith("Unknown: no limit can be told yet.")
    assert "nothing is told before record 1,000, and there are 500" in new
    beyond = a_life()
    beyond["changed"][:] = np.nan
    assert "larger than any wear" in said(beyond)[1]


def test_where_to_look_first_is_said_for_all_limits_that_are_due(defaults):
    advice = defaults["advice"]
    decisions, limits, _ = tables(a_life())
    (look,) = look_first(decisions, limits, advice)
    assert decisions.iloc[-1].limit == "slow"
    names = limits.quantity[limits.limit == "slow"]
    assert look.startswith(f"Where to look first (no diagnosis): {names.iloc[0]}: ")
    assert advice[names.iloc[0]] in look
    assert not any(advice[name] in look for name in limits.quantity if name not in {*names})
    assert look_first(decisions, limits, {}) == []
    decisions, limits, _ = tables(a_life(fails=(450.0, 560.0), half=(0.01, 0.1)))  # both are due
    assert limits.state.isin(["plan", "now"]).all()
    (look,) = look_first(decisions, limits, advice)
    first, second = (limits.quantity[limits.limit == name].iloc[0] for name in ("slow", "stiff"))
    assert look.index(advice[first]) < look.index(advice[second])
    decisions, limits, _ = tables(a_life(fails=(900.0, np.inf)))  # healthy
    assert look_first(decisions, limits, advice) == []


def test_the_page_holds_sentences_table_and_picture():
    _, limits, _ = tables()
    page = opening(["A < b", "more"], limit_words(limits), b"png")
    assert "<h1>A &lt; b</h1>\n<p>more</p>" in page
    assert "<td>slow</td>" in page
    assert "data:image/png;base64,cG5n" in page
