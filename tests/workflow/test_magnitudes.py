"""Any value at one key of the configuration: refused with a message, or it can be used."""

import math
import time
from functools import reduce
from operator import getitem

import numpy as np
import pytest

from breaker.configuration.definitions import simulated_test
from breaker.configuration.loading import ConfigurationError, check, defaults, of_motion
from breaker.family.endurance import EnduranceTest
from breaker.model.parameters import MOTIONS
from breaker.networks.summary import build
from breaker.paper.joint_model import Model
from tests.networks_fixtures import built

ANY = [math.nan, math.inf, -math.inf, 1e300, -1e300, 1e-300, 10**30, 2**63, 0, -1, True, None]
ANY += ["", "x", "1e3", "base64", "\0", "a" * 10**5, [], [[]], [1e300] * 1000, {}, {"a": 1}]
MUTATIONS = 150


def leaves(value, above=()):
    """Keys of everything but sections, entries of lists too."""
    if isinstance(value, dict) or (isinstance(value, list) and value):
        pairs = value.items() if isinstance(value, dict) else enumerate(value)
        return [key for name, part in pairs for key in leaves(part, (*above, name))]
    return [above]


def mutated(rng: np.random.Generator) -> tuple[tuple, object, dict]:
    """The defaults with another value at one key: any at all, or the same times a power of ten."""
    config = defaults()
    keys = leaves(config)
    *above, last = key = keys[rng.integers(len(keys))]
    section = reduce(getitem, above, config)
    value, scale = section[last], 10.0 ** rng.uniform(-8, 8)
    if type(value) in (int, float) and rng.random() < 0.7:
        section[last] = type(value)(value * scale)
    else:
        section[last] = ANY[rng.integers(len(ANY))]
    return key, section[last], config


def use(config: dict) -> None:
    """Build what is quickly built, and simulate a little."""
    for motion in MOTIONS:
        model = Model.from_settings({**config, "motion": motion})
        values = np.zeros((4, len(model.outputs)))
        values[:, :7] = model.prior.sample(4, np.random.default_rng(1))
        assert np.isfinite(model.curves(values)).all()
        network = of_motion(config, motion)["network"]
        try:
            built(build, network, samples=config["sensor"]["samples"], dims=8)
        except ValueError as error:  # the network knows which layers fit a record
            if "convolutions" not in str(error):
                raise
        test = EnduranceTest.from_settings(simulated_test(config), config["seed"])
        for operation in (1, config["simulated_test"]["operations"]):
            times, travel = test.record(motion, operation)
            assert times.shape == travel.shape


@pytest.mark.slow
def test_every_mutation_is_refused_or_can_be_used():
    rng, accepted = np.random.default_rng(11), 0
    use(defaults())  # compiles
    for _ in range(MUTATIONS):
        key, value, config = mutated(rng)
        try:
            check(config)
        except ConfigurationError:
            continue
        accepted += 1
        start = time.process_time()
        use(config)
        assert time.process_time() - start < 10.0, (key, value)
    assert 10 <= accepted <= 0.6 * MUTATIONS
