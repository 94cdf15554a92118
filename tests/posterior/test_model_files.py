"""Model files: what is written is what is read, and what does not fit is refused."""

import json
import pickle

import numpy as np
import pytest
import torch
from safetensors import safe_open
from safetensors.torch import save_file

from breaker.mechanism.parameters import NAMES
from breaker.posterior.estimator import Posterior
from breaker.posterior.model_files import ModelFileError
from tests.networks_fixtures import (
    COMBINATIONS,
    MARKS,
    SENSOR,
    Trap,
    curved_model,
    noise_of,
    one_thread,  # noqa: F401
    settings,
)

pytestmark = MARKS


@pytest.fixture(scope="module")
def curved():
    return curved_model()


@pytest.fixture(scope="module")
def model_file(curved, tmp_path_factory):
    path = tmp_path_factory.mktemp("model") / "closing.safetensors"
    curved[0].save(path)
    return path


def test_a_loaded_model_is_the_saved_one_bit_for_bit(curved, model_file):
    posterior, records = curved
    loaded = Posterior.load(model_file)
    noise = noise_of(posterior, 5, 20)
    draws = posterior.sample(records, noise)
    np.testing.assert_array_equal(loaded.sample(records, noise), draws)
    density = posterior.log_prob(draws, records)
    np.testing.assert_array_equal(loaded.log_prob(draws, records), density)
    np.testing.assert_array_equal(loaded.distance(records), posterior.distance(records))
    assert loaded.settings == posterior.settings
    assert (loaded.steps, loaded.motion, loaded.names) == (3, "closing", posterior.names)
    assert not loaded.training


@pytest.mark.parametrize("name", COMBINATIONS)
def test_every_combination_of_networks_is_kept(name, tmp_path):
    """With its frozen inputs, and records with samples missing where they are accepted."""
    posterior, records = curved_model(COMBINATIONS[name])
    if posterior.summary.missing:
        records[:, ::3] = np.nan
    posterior.save(tmp_path / "m.safetensors")
    loaded = Posterior.load(tmp_path / "m.safetensors")
    assert [type(part) for part in loaded.children()] == [
        type(part) for part in posterior.children()
    ]
    draws = posterior.sample(records, noise_of(posterior, 5, 20))
    np.testing.assert_array_equal(loaded.sample(records, noise_of(posterior, 5, 20)), draws)
    density = posterior.log_prob(draws, records)
    np.testing.assert_array_equal(loaded.log_prob(draws, records), density)
    np.testing.assert_array_equal(loaded.distance(records), posterior.distance(records))


def test_a_model_file_explains_itself(model_file):
    with safe_open(str(model_file), framework="pt") as file:
        header = file.metadata()
    assert json.loads(header["settings"])["sensor"] == SENSOR
    assert set(header) == {"format", "breaker_version", "settings"}


def test_equal_models_are_equal_bytes(curved, model_file, tmp_path):
    """The library alone writes three texts in six orders: twelve files alike by chance, 2e-9."""
    for _ in range(12):
        curved[0].save(tmp_path / "again.safetensors")
        assert (tmp_path / "again.safetensors").read_bytes() == model_file.read_bytes()


def test_settings_beyond_the_model_are_kept(tmp_path):
    posterior = Posterior({**settings(), "seed": 5, "training": {"steps": 7}})
    posterior.save(tmp_path / "m.safetensors")
    assert Posterior.load(tmp_path / "m.safetensors").settings["training"] == {"steps": 7}


def test_a_model_on_other_settings_has_other_shapes(tmp_path):
    """With and without the onset: eight or seven outputs, from the file alone."""
    Posterior(settings(onset=False)).save(tmp_path / "m.safetensors")
    assert Posterior.load(tmp_path / "m.safetensors").names == list(NAMES)


def parts(path):
    with safe_open(str(path), framework="pt") as file:
        return {name: file.get_tensor(name) for name in file.keys()}, file.metadata()  # noqa: SIM118


def with_settings(change):
    def fault(source, target):
        tensors, header = parts(source)
        read = json.loads(header["settings"])
        changed = change(read)
        text = changed if isinstance(changed, str) else json.dumps(changed)
        save_file(tensors, target, metadata={**header, "settings": text})

    return fault


def with_tensors(change):
    def fault(source, target):
        tensors, header = parts(source)
        change(tensors)
        save_file(tensors, target, metadata=header)

    return fault


def with_header(change):
    def fault(source, target):
        tensors, header = parts(source)
        save_file(tensors, target, metadata=change(header))

    return fault


def cut_to(share):
    def fault(source, target):
        content = source.read_bytes()
        target.write_bytes(content[: int(share * len(content))])

    return fault


def summary_with(**changes):
    def change(read):
        read["network"]["summary"].update(changes)
        return read

    return with_settings(change)


SHAPE = "has the shape"
DESCRIBE = "do not describe a model"
NOT_A_MODEL = "is not a model file of breaker"
FAULTS = {
    "text": (lambda _, target: target.write_text("time,travel\n" * 99), NOT_A_MODEL),
    "empty": (lambda _, target: target.write_bytes(b""), NOT_A_MODEL),
    "pickle": (lambda _, target: target.write_bytes(pickle.dumps(Trap(target / "x"))), NOT_A_MODEL),
    "torch pickle": (lambda _, target: torch.save({"weights": torch.ones(3)}, target), NOT_A_MODEL),
    "cut in the header": (cut_to(0.001), NOT_A_MODEL),
    "cut in the weights": (cut_to(0.7), NOT_A_MODEL),
    "no header": (with_header(lambda _: None), "format is None"),
    "other format": (
        with_header(lambda h: {**h, "format": "breaker posterior 99"}),
        "posterior 99",
    ),
    "no settings": (with_header(lambda h: {"format": h["format"]}), DESCRIBE),
    "tensor missing": (with_tensors(lambda t: t.pop("inference.head.bias")), SHAPE),
    "tensor too many": (with_tensors(lambda t: t.update(more=torch.ones(2))), SHAPE),
    "shape": (with_tensors(lambda t: t.update({"summary.centre": torch.ones(30)})), SHAPE),
    "wider network": (summary_with(width=25), SHAPE),
    "other sensor": (with_settings(lambda s: s | {"sensor": s["sensor"] | {"samples": 41}}), SHAPE),
    "onset off": (with_settings(lambda s: s | {"sensor": s["sensor"] | {"onset_sd": 0.0}}), SHAPE),
    "not json": (with_settings(lambda _: "{steps: 3"), DESCRIBE),
    "a list": (with_settings(lambda _: [1, 2]), DESCRIBE),
    "null": (with_settings(lambda _: None), DESCRIBE),
    "no prior": (with_settings(lambda s: s | {"prior": {}}), DESCRIBE),
    "prior of numbers": (with_settings(lambda s: s | {"prior": dict.fromkeys(NAMES, 1)}), DESCRIBE),
    "prior not positive": (
        with_settings(lambda s: s | {"prior": s["prior"] | {"mu": {"median": -1, "log_sd": 1}}}),
        DESCRIBE,
    ),
    "no network": (with_settings(lambda s: s | {"network": {}}), DESCRIBE),
    "network of text": (with_settings(lambda s: s | {"network": "large"}), DESCRIBE),
    "unknown kind": (summary_with(kind="oracle"), DESCRIBE),
    "unknown size": (summary_with(depth=3), DESCRIBE),
    "negative size": (summary_with(width=-3), DESCRIBE),
    "size of text": (summary_with(width="wide"), DESCRIBE),
    "unequal convolutions": (summary_with(kernels=[5]), DESCRIBE),
    "stride of zero": (summary_with(strides=[0, 1]), DESCRIBE),
    "skip of zero": (summary_with(skip=0), SHAPE),
    "unknown motion": (with_settings(lambda s: s | {"motion": "sideways"}), DESCRIBE),
}


@pytest.mark.parametrize("name", FAULTS)
def test_a_file_that_does_not_fit_is_refused(name, model_file, tmp_path):
    fault, message = FAULTS[name]
    target = tmp_path / "broken.safetensors"
    fault(model_file, target)
    with pytest.raises(ModelFileError) as caught:
        Posterior.load(target)
    assert str(target) in str(caught.value)
    assert message in str(caught.value)
    assert str(caught.value).endswith("train it anew")


def test_no_file_is_said(tmp_path):
    with pytest.raises(FileNotFoundError, match=r"there is no model file .*none"):
        Posterior.load(tmp_path / "none.safetensors")


def test_a_pickle_in_place_of_a_model_is_not_run(tmp_path):
    trap, target = tmp_path / "ran", tmp_path / "model.safetensors"
    target.write_bytes(pickle.dumps(Trap(trap)))
    with pytest.raises(ModelFileError):
        Posterior.load(target)
    assert not trap.exists()
    pickle.loads(target.read_bytes())  # the trap works where pickles are read
    assert trap.exists()
