"""The simulator and the prior of this package in BayesFlow."""

import os

os.environ.setdefault("KERAS_BACKEND", "torch")
import bayesflow as bf
import numpy as np

from breaker.configuration.loading import defaults
from breaker.paper.bank import simulate, truth
from breaker.paper.joint_model import Model

model, rng = Model.from_settings(defaults() | {"motion": "closing"}), np.random.default_rng(1)
bank = simulate(model, 500, rng)
z, records = model.standardise(truth(bank, model)), model.sensor.corrupt(bank.travel.values, rng)
workflow = bf.BasicWorkflow(
    inference_variables="z",
    summary_variables="records",
    summary_network=bf.networks.TimeSeriesNetwork(),
)
workflow.fit_offline({"z": z, "records": records[..., None]}, epochs=2)
