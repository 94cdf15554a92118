"""The simulator and the prior of this package in sbi."""

import numpy as np
import torch
from sbi.inference import NPE

from breaker.configuration.loading import defaults
from breaker.paper.bank import simulate, truth
from breaker.paper.joint_model import Model

model, rng = Model.from_settings(defaults() | {"motion": "closing"}), np.random.default_rng(1)
bank = simulate(model, 500, rng)
z = torch.tensor(model.standardise(truth(bank, model)), dtype=torch.float32)
records = torch.tensor(model.sensor.corrupt(bank.travel.values, rng), dtype=torch.float32)
estimator = NPE().append_simulations(z, records).train(max_num_epochs=2)
