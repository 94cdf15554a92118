"""The table of how good the exact posterior is: what it makes of made-up rows."""

import numpy as np
import pandas as pd
import pytest

from breaker.common.randomness import generator
from breaker.quantities.parameters import MOTIONS, NAMES
from studies.exact import ELSEWHERE, OTHER, OWN, table


def rows(network_sd: float, n: int = 400) -> pd.DataFrame:
    """Errors of 1 sd, told with a standard deviation of 1 by the exact answer."""
    from scipy.stats import norm

    rng = generator(1, "made-up rows of the exact posterior")
    found = {"motion": np.resize(MOTIONS, n), "told": np.arange(n) % 10 > 0}
    ones = ("seconds", "processor", "drives", "gap", "right_contact", "p_value")
    found |= {name: 1.0 for name in ones} | {"of": OWN}
    found["effective_size"] = np.where(found["told"], 500.0, 20.0)
    for by, sd in (("exact", 1.0), ("network", network_sd)):
        found[f"{by} log density"] = -np.log(sd) * len(NAMES)
        for name in NAMES:
            found[f"{by} rank {name}"] = norm.cdf(rng.standard_normal(n) / sd)
    return pd.DataFrame(found)


def test_a_calibrated_answer_holds_and_a_narrow_one_does_not():
    found = table(rows(network_sd=0.5))["either"]
    assert found["exact: 90 % intervals hold"] == pytest.approx(0.9, abs=0.02)
    assert found["exact: smallest p of flat ranks"] > 1e-3 / 7  # false alarms: 1e-3
    assert found["network: 90 % intervals hold"] < 0.7
    assert found["network: smallest p of flat ranks"] < 1e-3
    gain = found["gain in log density at the truth, nats"]
    assert gain == pytest.approx(len(NAMES) * np.log(0.5))


def test_what_is_not_resolved_counts_against_the_share_that_is():
    found = table(rows(network_sd=1.0))
    assert found.loc["resolved", "either"] == pytest.approx(0.9)
    assert found.loc["effective size at least 400", "closing"] <= 1.0
    assert found.loc["records", "opening"] == 200


def test_drives_that_another_family_answers_count_for_none():
    some = rows(network_sd=1.0)
    some.loc[:99, "of"], some.loc[100:149, "of"] = ELSEWHERE, OTHER
    assert table(some).loc["records"].tolist() == [125, 125, 250, 50]
