"""Whatever stands at one key of the configuration: refused with a message, or it can be used."""

import json
import math
import time
from copy import deepcopy
from functools import cache, reduce
from operator import getitem
from pathlib import Path

import numpy as np

from breaker import shipped
from breaker.common.randomness import generator
from breaker.configuration import loading as configuration
from breaker.configuration.loading import chosen_network, read
from breaker.configuration.yaml_sources import ConfigurationError
from breaker.drive.simulation.drive_family import Family
from breaker.drive.simulation.endurance_rig import Rig
from breaker.model.parameters import MOTIONS
from breaker.networks.build import build
from breaker.paper.joint_model import Model
from tests.networks_fixtures import built

ROOT = Path(__file__).resolve().parents[2]
DEFAULTS = read(shipped.DEFAULTS)
ANY = [math.nan, math.inf, -math.inf, 1e300, -1e300, 1e-300, 10**30, 2**63, 0, -1, True, None]
ANY += ["", "x", "1e3", "base64", "\0", "a" * 10**5, [], [[]], [1e300] * 1000, {}, {"a": 1}]
MUTATIONS = 150


def leaves(value, above=()):
    """Keys of everything that is no section, entries of lists too."""
    if isinstance(value, dict) or (isinstance(value, list) and value):
        pairs = value.items() if isinstance(value, dict) else enumerate(value)
        return [key for name, part in pairs for key in leaves(part, (*above, name))]
    return [above]


def mutated(rng: np.random.Generator) -> tuple[tuple, object, dict]:
    """The defaults with another value at one key: any at all, or the same times a power of ten."""
    config = deepcopy(DEFAULTS)
    keys = leaves(config)
    *above, last = key = keys[rng.integers(len(keys))]
    section = reduce(getitem, above, config)
    value, scale = section[last], 10.0 ** rng.uniform(-8, 8)
    if type(value) in (int, float) and rng.random() < 0.7:
        section[last] = type(value)(value * scale)
    else:
        section[last] = ANY[rng.integers(len(ANY))]
    return key, section[last], config


@cache
def build_once(chosen: str, samples: int) -> None:
    """Build networks of settings, in JSON: most mutations leave them as they are."""
    try:
        built(build, json.loads(chosen), samples=samples, dims=8)
    except ValueError as error:  # the network knows which layers fit a record
        if "convolutions" not in str(error):
            raise


def use(config: dict) -> None:
    """Build what is quickly built, and simulate a little."""
    rng = np.random.default_rng(1)
    for motion in MOTIONS:
        model = Model.from_settings({**config, "motion": motion})
        values = np.zeros((4, len(model.outputs)))
        values[:, :7] = model.prior.sample(4, rng)
        assert np.isfinite(model.curves(values)).all()
        chosen = chosen_network(config["network"][motion])
        build_once(json.dumps(chosen), config["sensor"]["samples"])
        rig = Rig.from_settings(config["rig"], config["seed"])
        for operation in (1, config["rig"]["operations"]):
            times, travel = rig.record(motion, operation)
            assert times.shape == travel.shape
    family = Family(model.prior, config["rigs"])
    try:
        family.worn(family.new(rng), rng)
    except RuntimeError as error:  # drives have to be drawn to see that none of them closes
        if "lower the preloads in rigs.elements" not in str(error):
            raise
    generator(config["seed"], "a purpose")


def test_every_mutation_is_refused_or_can_be_used(monkeypatch):
    monkeypatch.setattr(configuration, "read", cache(configuration.read))  # the schema, once
    rng = np.random.default_rng(11)
    accepted = 0
    use(DEFAULTS)  # compiles
    for _ in range(MUTATIONS):
        key, value, config = mutated(rng)
        try:
            configuration.check(config)
            Rig.from_settings(config["rig"], config["seed"])
        except ConfigurationError:
            continue
        except ValueError as error:  # the rig has to be built to see whether it closes
            if not str(error).startswith("rig.parameters: "):
                raise
            continue
        accepted += 1
        start = time.process_time()
        use(config)
        assert time.process_time() - start < 10.0, (key, value)
    assert 10 <= accepted <= 0.5 * MUTATIONS
