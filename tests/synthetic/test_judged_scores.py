"""Scores of judged rigs by hand: coverage, errors, false alarms, delays, power."""

import numpy as np
import pandas as pd
import pytest

from breaker.synthetic.judged_scores import score_lives, score_power


def one(table, score, quantity=""):
    (row,) = table[(table.score == score) & (table.quantity == quantity)].itertuples()
    return row


def life(number, *events, change=1200, faster=5.0, ratio=8.0):
    begins = {"set": "held_back", "life": number, "change": change, "faster": faster}
    begins |= {"ratio": ratio, "scale": 1.0, "source": "both", "name": ""}
    return [begins | each for each in ({"score": "life"}, *events)]


def event(operation, score="alarm"):
    return {"score": score, "operation": operation}


def interval(score, name, truth, lower, median, upper):
    values = {"truth": truth, "lower": lower, "median": median, "upper": upper}
    return {"score": score, "name": name, "operation": 1080} | values


@pytest.fixture(scope="module")
def table():
    rows = [
        *life(0, event(1230), interval("slope", "f", 1.0, 0.0, 3.0, 4.0)),
        *life(1, event(1100), event(1400, "step"), interval("slope", "f", 1.0, 1.5, 2.0, 4.0)),
        *life(2, interval("remaining", "0.5", 300.0, 200.0, 250.0, np.inf), ratio=2.0),
        *life(3, event(1500, "step"), change=2000, faster=1.0, ratio=np.nan),
    ]
    return score_lives(pd.DataFrame(rows), settle=100, every=10, operations=2000)


def test_drifts_by_hand(table):
    assert one(table, "coverage, slope", "f").value == 0.5
    error = one(table, "error, slope", "f")
    assert error.value == pytest.approx(np.sqrt((4.0 + 1.0) / 2))
    assert error.lower_95 < error.value < error.upper_95
    assert one(table, "coverage, remaining", "0.5").value == 1.0
    assert one(table, "coverage, remaining", "0.25").n == 0


def test_false_alarms_by_hand(table):
    """Watched from operation 1,000 on to the change: 3 times 200 and 1,000."""
    alarms = one(table, "false alarms in 10,000 operations")
    assert (alarms.value, alarms.n) == (pytest.approx(1e4 / 1600), 1600)
    assert one(table, "false steps in 10,000 operations").value == pytest.approx(1e4 / 1600)


def test_changes_found_by_hand(table):
    """Within 60 operations: life 0; later life 1, and life 2 never."""
    assert one(table, "found within 3 % of life").value == pytest.approx(1 / 3)
    assert one(table, "found").value == pytest.approx(2 / 3)
    assert one(table, "found within 3 % of life, ratio of 5 or more").value == 0.5
    assert one(table, "found, ratio of 5 or more").n == 2
    assert one(table, "followed together").value == 1.0


def test_power_by_hand():
    rows = pd.DataFrame(
        [
            {"rig": 0, "fault": "2 ms of bounce", "after": 2, "kind": "step", "clear": 3.0},
            {"rig": 1, "fault": "2 ms of bounce", "kind": "none", "clear": 1.0},
            {"rig": 2, "fault": "2 ms of bounce", "kind": "left out"},
            {"rig": 1, "fault": "before", "kind": "alarm"},
        ]
    )
    table = score_power(rows, settle=100, every=10, records=150)
    reported = one(table, "reported", "2 ms of bounce")
    assert (reported.value, reported.n) == (0.5, 2)
    assert one(table, "change over noise, median", "2 ms of bounce").value == 2.0
    alarms = one(table, "false alarms in 10,000 operations")
    assert (alarms.value, alarms.n) == (pytest.approx(1e4 / 1500), 1500)
    assert one(table, "false steps in 10,000 operations").value == 0.0
