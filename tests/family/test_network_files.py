"""Model files of a family: only what fits together is read, whatever is in them."""

import json

import numpy as np
import pytest
from safetensors import safe_open

from breaker.common.tensor_file import ModelFileError, write_model
from breaker.drive.family.network_files import open_network
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


@pytest.mark.parametrize(
    "change",
    [
        lambda a: a[None],
        lambda a: a[..., None],
        lambda a: a.reshape(1, -1) if a.ndim == 1 else a.reshape(-1),
        lambda a: a[:0],
        lambda a: np.concatenate([a, a[:1]]),
    ],
    ids=["before", "behind", "flat", "empty", "longer"],
)
def test_no_tensor_of_another_shape_is_read(parts, tmp_path, change):
    """One that stands alone in a size, such as inputs, may be another: it is found where used."""
    settings, tensors = parts
    for name, tensor in tensors.items():
        why = refused(tmp_path, settings, tensors | {name: np.ascontiguousarray(change(tensor))})
        assert "does not fit the others; it is damaged" in why, name
        assert why.endswith("; train it anew")


def test_no_tensor_is_missing_or_too_many(parts, tmp_path):
    settings, tensors = parts
    for name in tensors:
        left = {each: tensor for each, tensor in tensors.items() if each != name}
        assert "is missing" in refused(tmp_path, settings, left), name
    more = tensors | {"network.more": np.zeros(3, np.float32)}
    assert "its tensor network.more is not known" in refused(tmp_path, settings, more)


@pytest.mark.parametrize("value", [None, "x", -1, [], {}])
def test_settings_that_make_no_drive_are_refused(parts, tmp_path, value):
    settings, tensors = parts
    assert "no network of a family" in refused(tmp_path, settings | {"kind": value}, tensors)
    for prior in (value, {**settings["prior"], "L": value}):
        why = refused(tmp_path, settings | {"prior": prior}, tensors)
        assert "do not describe a model" in why


def test_an_answer_of_no_number_is_refused(parts, tmp_path, monkeypatch):
    settings, tensors = parts
    if settings["kind"] != "levels":
        pytest.skip("changes are told beside a level")
    monkeypatch.chdir(tmp_path)
    write_model("m.safetensors", settings, tensors | {"centre": 1e30 * tensors["centre"]})
    from breaker.drive.family.network_inputs import NormalisedRecords

    levels, rng = open_network("m.safetensors"), np.random.default_rng(1)
    nothing = NormalisedRecords.nothing(1)
    with pytest.raises(ModelFileError, match="answers no sizes of a drive"):
        levels.draw({"closing": nothing}, 10, rng)
