"""The study of the default network: tiny trainings, resumed, and rows whose numbers are known."""

import numpy as np
import pandas as pd
import pytest

from studies import default_network as study


@pytest.mark.slow
def test_both_networks_are_trained_once_and_judged_by_the_same_curves(tmp_path, monkeypatch):
    small = {"SENSORS": {"paper": ["config/test.yaml", "config/paper.yaml"]}, "HELD_OUT": 600}
    small |= {"MOTIONS": ("opening",), "JUDGED": 5, "PACE": 5}
    for name, value in (small | {"KEPT": tmp_path, "TABLE": tmp_path / "table.csv"}).items():
        monkeypatch.setattr(study, name, value)
    study.main()
    result = pd.read_csv(study.TABLE).set_index(["network", "quantity"])
    for network in study.NETWORKS:
        quantities = result.loc[network]
        assert quantities.n[["lost", "divergence"]].tolist() == [600, 5]
        assert quantities.value["draws_per_second"] > 0
    monkeypatch.delattr(study, "train")  # all is kept: nothing is trained anew
    study.main()


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
