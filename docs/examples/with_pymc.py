"""The simulator and the prior of this package in PyMC: the posterior of one record."""

import numpy as np
import pymc
import pytensor.tensor as pt
from pytensor.graph.op import Op

from breaker.configuration.loading import load
from breaker.model.curves import travel
from breaker.model.parameters import NAMES
from breaker.model.prior import Prior

prior = Prior.from_settings(load()["prior"])
times = np.arange(0.0, 58.0, 0.4)  # ms after the start of motion
rng = np.random.default_rng(1)
record = travel(prior.medians[None], times, "closing").travel[0]  # or your own, mm
record = record + 0.1 * rng.standard_normal(times.size)


class Curve(Op):
    """Travel of a closing, mm, from the seven parameters."""

    itypes, otypes = [pt.dvector], [pt.dvector]

    def perform(self, node, inputs, outputs):
        outputs[0][0] = travel(inputs[0][None], times, "closing").travel[0]


with pymc.Model():
    pairs = zip(NAMES, prior.medians, prior.log_sds, strict=True)
    theta = pt.stack([pymc.LogNormal(name, np.log(median), sd) for name, median, sd in pairs])
    _, k_a, _, _, _, f, gap = (theta[i] for i in range(len(NAMES)))
    pymc.Potential("pressed", pt.switch(f > k_a * gap, 0.0, -np.inf))  # condition of the prior
    pymc.Normal("record", Curve()(theta), 0.1, observed=record)
    draws = pymc.sample(20_000, step=pymc.DEMetropolisZ(), cores=1, chains=4)
