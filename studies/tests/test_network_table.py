"""One row a network, of parts whose numbers are known."""

from types import SimpleNamespace

import numpy as np
import pandas as pd
import xarray as xr

from breaker.common.randomness import generator
from breaker.paper.calibration import judge_draws
from studies.networks import table as tables
from studies.networks.table import draws_per_second, network_row
from tests.validation.made import exact_posteriors

NAMES = ["mu", "L", "onset"]
N, DRAWS = 800, 199


def validation(width=1.0):
    """Exact posteriors of normal observations; ``width`` times the sd of the second output."""
    known = {"prior_sd": np.array([0.2, 0.05, 0.3]), "contraction": np.array([0.4, 0.8, 0.95])}
    draws, truth = exact_posteriors(
        generator(1, "test quality"), N, DRAWS, **known, width=np.array([1, width, 1])
    )
    return xr.Dataset(
        {"draws": (("curve", "draw", "output"), draws), "truth": (("curve", "output"), truth)},
        coords={"output": NAMES},
    )


class Network:
    """A network that draws zeros and counts how often."""

    outputs, steps = NAMES, 3

    def __init__(self):
        self.calls = []

    def sample(self, measured, noise):
        assert noise.shape == (len(measured), 500, 3)
        self.calls.append(len(measured))
        return np.zeros_like(noise)

    def parameters(self):
        return [SimpleNamespace(numel=lambda: 7), SimpleNamespace(numel=lambda: 5)]


def row_of(data):
    judged = {"gap_nats": 4.5, "gap_se": 0.1, "efficiency_median": 0.55}
    judged |= {"efficiency_10_percent": 0.19, "rounds_mean": 3.0}
    history = xr.Dataset(
        attrs={"held_out_log_density": 3.25, "held_out_log_density_se": 0.125, "best_step": 7}
    )
    training = pd.DataFrame({"s": [90.0], "mean_load": [97.0], "cpu_time": [87.5]})
    data = data.assign(measured=(("curve", "time"), np.zeros((N, 4))))
    return network_row("its_name", Network(), data, pd.DataFrame([judged]), history, training)


def test_row_of_a_network_has_the_numbers_of_its_parts():
    data = validation()
    table = row_of(data)
    assert len(table) == 1
    speed = table.pop("draws_per_second").item()
    assert 0 < speed < np.inf
    judged = judge_draws(data.draws.values, data.truth.values)
    assert table.iloc[0].to_dict() == {
        "network": "its_name",
        "held_out_log_density": 3.25,
        "held_out_log_density_se": 0.125,
        "gap_nats": 4.5,
        "gap_se": 0.1,
        "efficiency_median": 0.55,
        "efficiency_10_percent": 0.19,
        "calibration_p": judged.p_value,
        "calibrated": True,
        "training_seconds": 87.5,
        "solver_steps": 3,
        "weights": 12,
    }
    bad = row_of(validation(width=0.7))
    assert bad.calibration_p.item() < 1e-4
    assert not bad.calibrated.item()


def test_draws_per_second_counts_processor_time(monkeypatch):
    """A clock that says two seconds; a few records, or fewer. The first call does not count."""
    network = Network()
    monkeypatch.setattr(tables, "process_time", lambda: 2.0 * len(network.calls))
    assert draws_per_second(network, np.zeros((50, 4))) == 10 * 500 / 2.0
    assert network.calls == [1, 10]
    assert draws_per_second(network, np.zeros((4, 4))) == 4 * 500 / 2.0
