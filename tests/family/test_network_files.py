"""Model files of a family: only what fits together is read, whatever is in them."""

import json

import numpy as np
import pytest
from safetensors import safe_open

from breaker.common.tensor_file import ModelFileError, write_model
from breaker.family.network_files import open_network
from breaker.shipped import KINDS, model_file


@pytest.fixture(scope="module", params=KINDS)
def parts(request):
    """Settings and tensors of a network that ships."""
    with safe_open(str(model_file("any", request.param)), framework="numpy") as file:
        settings = json.loads(file.metadata()["settings"])
        return settings, {name: file.get_tensor(name) for name in list(file.keys())}


def refused(folder, settings, tensors):
    """Why a file of these, written as if it was right, is not read; "" if it is."""
    write_model(folder / "m.safetensors", settings, tensors)
    try:
        open_network(folder / "m.safetensors")
    except ModelFileError as error:
        return str(error)
    return ""


def test_a_file_written_again_is_read(parts, tmp_path):
    assert refused(tmp_path, *parts) == ""


def test_no_tensor_is_missing(parts, tmp_path):
    settings, tensors = parts
    for name in ("usual", "bases.closing.mean", "network.inference.leave"):
        left = {each: tensor for each, tensor in tensors.items() if each != name}
        assert refused(tmp_path, settings, left), name


@pytest.mark.parametrize("value", [None, "x", -1, [], {}])
def test_settings_that_make_no_drive_are_refused(parts, tmp_path, value):
    settings, tensors = parts
    assert refused(tmp_path, settings | {"kind": value}, tensors)
    for prior in (value, {**settings["prior"], "L": value}):
        assert refused(tmp_path, settings | {"prior": prior}, tensors)


def test_an_answer_of_no_number_is_refused(parts, tmp_path, monkeypatch):
    settings, tensors = parts
    if settings["kind"] != "levels":
        pytest.skip("changes are told beside a level")
    monkeypatch.chdir(tmp_path)
    write_model("m.safetensors", settings, tensors | {"centre": 1e30 * tensors["centre"]})
    from breaker.family.inputs import NormalisedRecords

    levels, rng = open_network("m.safetensors"), np.random.default_rng(1)
    nothing = NormalisedRecords.nothing(1)
    with pytest.raises(ModelFileError):
        levels.draw({"closing": nothing}, 10, rng)
