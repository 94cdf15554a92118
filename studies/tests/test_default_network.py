"""The study of the default network: tiny trainings, resumed, and rows whose numbers are known."""

import numpy as np
import pandas as pd
import pytest

from studies import default_network as study


@pytest.fixture
def small(tmp_path, monkeypatch):
    """The study with hardly trained networks, in a folder of its own."""
    monkeypatch.setattr(study, "SENSORS", {"paper": ["config/test.yaml", "config/paper.yaml"]})
    monkeypatch.setattr(study, "MOTIONS", ("opening",))
    monkeypatch.setattr(study, "HELD_OUT", 600)
    monkeypatch.setattr(study, "JUDGED", 5)
    monkeypatch.setattr(study, "PACE", 5)
    monkeypatch.setattr(study, "KEPT", tmp_path)
    monkeypatch.setattr(study, "TABLE", tmp_path / "table.csv")
    return tmp_path


@pytest.mark.slow
def test_both_networks_are_trained_once_and_judged_by_the_same_curves(small, monkeypatch):
    study.main()
    result = pd.read_csv(study.TABLE).set_index(["network", "quantity"])
    assert result.population.nunique() == 1
    for network in study.NETWORKS:
        quantities = result.loc[network]
        assert quantities.n[["log_density", "lost", "divergence"]].tolist() == [600, 600, 5]
        assert quantities.n["draws_per_second"] == 40
        assert (quantities.value[["draws_per_second", "training_seconds"]] > 0).all()
    lost = result.loc["flow_matching"].loc["lost"]
    densities = result.xs("log_density", level=1).value
    assert lost.value == pytest.approx(
        densities["coupling_flow"] - densities["flow_matching"], abs=0.02
    )
    assert lost.low < lost.value < lost.high
    monkeypatch.delattr(study, "train")  # all is kept: nothing is trained anew
    study.main()


def test_rows_have_means_with_intervals_of_95_percent():
    rng = np.random.default_rng(1)
    numbers = {
        "curves": np.array(9),
        "log_density": rng.normal(size=400),
    }
    numbers |= {
        "draws_per_second": np.array(9.0),
        "training_seconds": np.array(3.0),
        "divergence": np.full(4, 0.03),
    }
    worse = numbers | {"log_density": numbers["log_density"] - 0.25}
    result = study.table("some", {"coupling_flow": numbers, "flow_matching": worse})
    rows = result.set_index(["network", "quantity"]).loc["flow_matching"]
    assert rows.loc["lost", ["value", "low", "high"]].tolist() == pytest.approx([0.25] * 3)
    assert rows.n[["divergence", "draws_per_second"]].tolist() == [4, 9]
    density = rows.loc["log_density"]
    assert density.high - density.low == pytest.approx(2 * 1.96 * 0.05, rel=0.2)
