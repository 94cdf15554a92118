"""The study of the default network: rows whose numbers are known."""

import numpy as np
import pytest

from studies import default_network as study


def test_rows_have_means_with_intervals_of_95_percent():
    numbers = {"log_density": np.random.default_rng(1).normal(size=400)}
    numbers |= {"divergence": np.full(4, 0.03), "curves": np.array(9)}
    numbers["draws_per_second"] = np.array(9.0)
    worse = numbers | {"log_density": numbers["log_density"] - 0.25}
    result = study.table("some", {"coupling_flow": numbers, "flow_matching": worse})
    rows = result.set_index(["network", "quantity"]).loc["flow_matching"]
    assert rows.loc["lost", ["value", "low", "high"]].tolist() == pytest.approx([0.25] * 3)
    assert rows.n[["divergence", "draws_per_second"]].tolist() == [4, 9]
    worse["log_density"] = 2.0 * numbers["log_density"]  # the difference scatters by 1
    result = study.table("some", {"coupling_flow": numbers, "flow_matching": worse})
    (lost,) = result[(result.network == "flow_matching") & (result.quantity == "lost")].itertuples()
    assert lost.high - lost.low == pytest.approx(2 * 1.96 * 0.05, rel=0.2)
