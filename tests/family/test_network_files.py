"""Model files of a family: only what fits together is read, whatever is in them."""

import json

import pytest
from safetensors import safe_open

from breaker.common.tensor_file import ModelFileError, write_model
from breaker.family.networks import open_network
from breaker.shipped import KINDS, model_file


@pytest.fixture(scope="module", params=KINDS)
def parts(request):
    """Settings and tensors of a network that ships."""
    with safe_open(str(model_file("any", request.param)), framework="numpy") as file:
        settings = json.loads(file.metadata()["settings"])
        return settings, {name: file.get_tensor(name) for name in list(file.keys())}


def reading(folder, settings, tensors):
    """Read a file of these, written as if it was right."""
    write_model(folder / "m.safetensors", settings, tensors)
    return open_network(folder / "m.safetensors")


def test_a_file_is_read_with_all_tensors_and_settings_of_a_drive_only(parts, tmp_path):
    settings, tensors = parts
    assert reading(tmp_path, settings, tensors).settings == settings
    for name in ("usual", "bases.closing.mean", "network.inference.leave"):
        left = {key: tensor for key, tensor in tensors.items() if key != name}
        with pytest.raises(ModelFileError):
            reading(tmp_path, settings, left)

    for value in (None, "x", -1, [], {}):
        for wrong in (
            {"kind": value},
            {"prior": value},
            {"prior": settings["prior"] | {"L": value}},
        ):
            with pytest.raises(ModelFileError):
                reading(tmp_path, settings | wrong, tensors)
