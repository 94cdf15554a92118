"""The first page: where to look first, and what the page holds."""

import numpy as np

from breaker.configuration.definitions import advice_of
from breaker.diagnosis.words import say
from breaker.prognosis.page import (
    limit_words,
    look_first,
    opening,
)
from tests.lives import a_life
from tests.prognosis.test_tables import tables


def test_where_to_look_first_is_said_for_all_limits_that_are_due():
    advice = advice_of()
    decisions, limits, _ = tables(a_life())
    (look,) = look_first(decisions, limits, advice)
    assert decisions.iloc[-1].limit == "slow"
    names = limits.quantity[limits.limit == "slow"]
    assert look.startswith(f"{say('look-first')}: {names.iloc[0]}: ")
    assert advice[names.iloc[0]] in look
    assert not any(advice[name] in look for name in limits.quantity if name not in {*names})
    assert look_first(decisions, limits, {}) == []
    decisions, limits, _ = tables(a_life(fails=(450.0, 560.0), half=(0.01, 0.1)))  # both are due
    assert limits.state.isin(["planned", "due"]).all()
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
