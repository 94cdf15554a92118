"""The tables of a life: one row per operation, per limit and per change."""

import numpy as np
import pandas as pd
import xarray as xr

from breaker.configuration.loading import defaults
from breaker.prognosis.states import states_of
from breaker.prognosis.tables import (
    CHANGES,
    DECISIONS,
    LIMITS,
    change_table,
    decide,
    limit_table,
    operation_metadata,
)
from tests.lives import OPERATIONS, a_life

PLANNING = defaults()["planning"] | {"operations": 150, "years": 2.0}


def curves(**columns):
    """Records of one motion, of which the third could not be used."""
    accepted = np.ones(OPERATIONS.size, dtype=bool)
    accepted[2] = False
    data = {"accepted": ("operation", accepted)}
    data |= {name: ("operation", np.array(each)) for name, each in columns.items()}
    return xr.Dataset(data, {"operation": OPERATIONS})


def tables(life=None, **columns):
    life = a_life() if life is None else life
    known = operation_metadata(
        {"closing": curves(**columns), "opening": curves()}, life.operation.values
    )
    stands = states_of(life, PLANNING, np.full(OPERATIONS.size, np.nan))
    return decide(life, stands, known), limit_table(life, stands), change_table(life)


def test_there_is_a_row_for_every_operation_without_empty_columns_of_dates():
    table, _, _ = tables()
    assert table.operation.tolist() == OPERATIONS.tolist()
    assert set(table) < set(DECISIONS)
    assert not {"date", "days_left", "breaker"} & set(table)
    assert table.not_used[2] == "closing, opening"
    assert table.not_used[3] == ""


def test_what_is_known_of_operations_is_kept():
    dates = [f"2024-{1 + k // 28 % 12:02d}-{1 + k % 28:02d}" for k in range(OPERATIONS.size)]
    temperature = np.where(OPERATIONS % 2, 20.0, np.nan)
    table, _, _ = tables(date=sorted(dates), temperature=temperature, event=[""] * 500)
    assert {"date", "temperature", "days_left", "service_by_date"} <= set(table)
    assert table.temperature[0] == 20.0
    assert "event" not in table


def test_decisions_say_state_limit_and_what_is_left():
    table, _, _ = tables()
    row = table.set_index("operation").loc[380]
    assert (row.state, row.limit) == ("planned", "slow")
    assert row.operations_left_5 < row.operations_left < row.operations_left_95
    assert 380 < row.service_by < 450
    assert table.service_by[table.state == "ok"].isna().all()
    assert table.set_index("operation").change[310] == "rate"
    assert table.exceeded.iloc[-1] == "slow"


def test_limits_have_new_now_bound_and_probability():
    _, table, _ = tables()
    assert list(table) == list(LIMITS)
    row = table.iloc[0]
    assert (row.limit, row.unit, row.state, row.p_exceeded) == ("slow", "ms", "due", 1.0)
    assert row.now_5 < row.now < row.now_95
    assert row.certain == 450
    assert pd.isna(table.certain[1])


def test_changes_are_noticed_ones_and_what_is_known_at_the_end():
    _, _, table = tables()
    assert list(table)[: len(CHANGES)] == list(CHANGES)
    assert table.kind.tolist() == ["rate", "now"]
    assert table.noticed.tolist() == [310, 500]
    assert table.gamma_a.tolist() == [6.2, 10.0]  # read at the next operation that is asked
    assert table.f_unchanged.tolist() == [1.0, 1.0]


def test_a_life_without_changes_and_limits_has_tables():
    life = a_life().isel(limit=slice(0, 0), part=slice(0, 0), change=slice(0, 0))
    decisions, limits, changes = tables(life)
    assert (decisions.state == "unknown").all()
    assert limits.empty
    assert len(changes) == 1
