"""The tables of a life, and the sentences above them."""

import numpy as np
import pandas as pd
import pytest

from breaker.configuration.data_files import advice_of
from breaker.configuration.loading import defaults
from breaker.prognosis.limit_states import states_of
from breaker.prognosis.tables import change_table, decide, limit_table, sentences
from tests.lives import a_life

PLANNING = defaults()["planning"] | {"operations": 150, "years": 2.0}


def tables(life):
    stands = states_of(life, PLANNING)
    return decide(life, stands), limit_table(life, stands), change_table(life)


def test_tables_say_what_a_life_says():
    decisions, limits, changes = tables(a_life())
    row = decisions.set_index("operation").loc[380]
    assert (row.state, row.limit) == ("planned", "slow")
    assert row.operations_left_5 < row.operations_left < row.operations_left_95
    assert 380 < row.service_by < 450
    assert decisions.service_by[decisions.state == "ok"].isna().all()
    assert decisions.set_index("operation").change[310] == "rate"
    assert decisions.exceeded.iloc[-1] == "slow"
    row = limits.iloc[0]
    assert (row.limit, row.unit, row.state, row.p_exceeded) == ("slow", "ms", "due", 1.0)
    assert row.now_5 < row.now < row.now_95
    assert limits.certain.tolist() == [450, pd.NA]
    assert changes.kind.tolist() == ["rate", "now"]
    assert changes.noticed.tolist() == [310, 500]
    assert changes.gamma_a.tolist() == [6.2, 10.0]  # read at the next operation that is asked
    assert tables(a_life().isel(change=slice(0, 0)))[2].kind.tolist() == ["now"]


@pytest.mark.parametrize(
    ("about", "codes"),
    [
        ({}, ["due-exceeded", "changed", "look-first", "inside"]),
        ({"fails": (550.0, np.inf)}, ["planned", "changed", "look-first", "inside"]),
        ({"fails": (np.inf, np.inf)}, ["ok", "changed", "inside"]),
        ({"reported_from": 600}, ["due-exceeded", "few-records", "look-first", "inside"]),
        ({"family": ""}, ["due-exceeded", "withheld", "look-first", "motions-contradict"]),
    ],
)
def test_the_page_says_what_to_do_what_changed_and_whether_to_trust_it(about, codes):
    life = a_life(**about)
    decisions, limits, _ = tables(life)
    result = sentences(life, decisions, limits, advice_of())
    assert [item.code for item in result] == [f"life-{code}" for code in codes]
