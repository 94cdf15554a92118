"""Model files: what is written is what is read, and what does not fit is refused."""

import json
import pickle
import subprocess
import sys

import numpy as np
import pytest
import torch
from safetensors import safe_open
from safetensors.torch import save_file

from breaker.common.tensor_file import ModelFileError, _finished
from breaker.paper.posterior import Posterior
from tests.networks_fixtures import (
    COMBINATIONS,
    SENSOR,
    Trap,
    curved_model,
    noise_of,
)


@pytest.fixture(scope="module")
def model_file(series, tmp_path_factory):
    path = tmp_path_factory.mktemp("model") / "closing.safetensors"
    series[0].save(path)
    return path


@pytest.mark.parametrize("name", COMBINATIONS)
def test_a_loaded_model_is_the_saved_one_bit_for_bit(name, tmp_path):
    """Of every inference network, with its frozen inputs."""
    posterior, records = curved_model(COMBINATIONS[name])
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
    assert loaded.settings == posterior.settings
    assert (loaded.steps, loaded.motion) == (posterior.steps, "closing")
    assert loaded.outputs == posterior.outputs
    assert not loaded.training


def test_a_model_file_explains_itself(model_file):
    with safe_open(str(model_file), framework="pt") as file:
        header = file.metadata()
    assert json.loads(header["settings"])["sensor"] == SENSOR
    assert set(header) == {"format", "breaker_version", "settings", "checksum"}
    with pytest.raises(FileNotFoundError, match=r"there is no model file .*none"):
        Posterior.load(model_file.with_name("none.safetensors"))


def test_equal_models_are_equal_bytes(series, model_file, tmp_path):
    """The library alone writes three texts in six orders: twelve files alike by chance, 2e-9."""
    for _ in range(12):
        series[0].save(tmp_path / "again.safetensors")
        assert (tmp_path / "again.safetensors").read_bytes() == model_file.read_bytes()


def test_a_model_stays_as_it_was_when_its_file_is_written_over(series, model_file, tmp_path):
    target = tmp_path / "m.safetensors"
    target.write_bytes(model_file.read_bytes())
    loaded = Posterior.load(target)
    with target.open("r+b") as file:  # in place, as a copy over it does
        file.write(bytes(target.stat().st_size))
    for name, value in series[0].state_dict().items():
        torch.testing.assert_close(loaded.state_dict()[name], value, rtol=0, atol=0)


def parts(path):
    """Tensors and header of a model file, without the checksum."""
    with safe_open(str(path), framework="pt") as file:
        header = {name: text for name, text in file.metadata().items() if name != "checksum"}
        return {name: file.get_tensor(name) for name in file.keys()}, header  # noqa: SIM118


def write(tensors, header, target):
    """Write a model file with the checksum of what it holds, as if it was written like that."""
    save_file(tensors, target, metadata=header)
    if header and "settings" in header:
        target.write_bytes(_finished(target.read_bytes()))


def with_bytes(change):
    return lambda source, target: target.write_bytes(change(source.read_bytes()))


def with_header(change):
    def fault(source, target):
        tensors, header = parts(source)
        write(tensors, change(header), target)

    return fault


def with_settings(change):
    def changed(header):
        new = change(json.loads(header["settings"]))
        return {**header, "settings": new if isinstance(new, str) else json.dumps(new)}

    return with_header(changed)


def with_tensors(change):
    def fault(source, target):
        tensors, header = parts(source)
        change(tensors)
        write(tensors, header, target)

    return fault


def cut_to(share):
    return with_bytes(lambda content: content[: int(share * len(content))])


def summary_with(**changes):
    def change(read):
        read["network"]["summary"].update(changes)
        return read

    return with_settings(change)


def sensor_with(**changes):
    return with_settings(lambda read: read | {"sensor": read["sensor"] | changes})


def with_value(name, value):
    def change(tensors):
        tensors[name] = tensors[name].clone()
        tensors[name].view(-1)[0] = value

    return with_tensors(change)


def raw(header, size=None):
    """A file of a header of any bytes, and of a size that it only claims."""
    length = len(header) if size is None else size
    return lambda _, target: target.write_bytes(length.to_bytes(8, "little") + header)


GAMMA = b'\\"gamma_a\\": {\\"log_sd\\": 0.2', b'\\"gamma_a\\": {\\"log_sd\\": 0.9'
SHAPE = "has the shape"
DESCRIBE = "do not describe a model"
NOT_A_MODEL = "is not a model file of breaker"
FAULTS = {
    "text": (lambda _, target: target.write_text("time,travel\n" * 99), NOT_A_MODEL),
    "empty": (lambda _, target: target.write_bytes(b""), NOT_A_MODEL),
    "pickle": (
        lambda _, target: target.write_bytes(pickle.dumps(Trap(target.with_name("ran")))),
        NOT_A_MODEL,
    ),
    "cut in the header": (cut_to(0.001), NOT_A_MODEL),
    "cut in the weights": (cut_to(0.7), NOT_A_MODEL),
    "no header": (with_header(lambda _: None), "format is None"),
    "other format": (
        with_header(lambda h: {**h, "format": "breaker posterior 2"}),
        "its format is 'breaker posterior 2', this version of breaker reads 'breaker network 1'",
    ),
    "no settings": (with_header(lambda h: {"format": h["format"]}), DESCRIBE),
    "tensor missing": (with_tensors(lambda t: t.pop("inference.head.bias")), SHAPE),
    "tensor too many": (with_tensors(lambda t: t.update(more=torch.ones(2))), SHAPE),
    "other sensor": (sensor_with(samples=41), SHAPE),
    "not json": (with_settings(lambda _: "{steps: 3"), DESCRIBE),
    "a list": (with_settings(lambda _: [1, 2]), DESCRIBE),
    "no prior": (with_settings(lambda s: s | {"prior": {}}), DESCRIBE),
    "prior not positive": (
        with_settings(lambda s: s | {"prior": s["prior"] | {"mu": {"median": -1, "log_sd": 1}}}),
        DESCRIBE,
    ),
    "unknown size": (summary_with(depth=3), DESCRIBE),
    "stride of zero": (summary_with(strides=[0, 1]), DESCRIBE),
    "skip of zero": (summary_with(skip=0), SHAPE),
    "weight nan": (with_value("inference.head.bias", torch.nan), "bias has numbers that are not"),
    "component infinite": (with_value("curve_weights", -torch.inf), "not finite"),
    "other type": (
        with_tensors(lambda t: t.update({"curve_mean": t["curve_mean"].float()})),
        "curve_mean is of float32, not float64",
    ),
    "no steps": (with_value("solver_steps", 0), "solver_steps is 0, but must be from 1 to 1000"),
    "setting changed": (with_bytes(lambda c: c.replace(*GAMMA, 1)), "checksum"),
    "weight changed": (with_bytes(lambda c: c[:-3] + b"abc"), "its checksum is another"),
    "no checksum": (lambda a, b: save_file(*parts(a)[:1], b, parts(a)[1]), "checksum is missing"),
    "number infinite": (with_settings(lambda s: s | {"seed": float("inf")}), "a number is inf"),
    "number nan": (sensor_with(noise_sd=float("nan")), "a number is nan"),
}

# What took forever, or all memory.
HEAVY = {
    "many steps": (with_value("solver_steps", 10**12), "solver_steps is 1000000000000"),
    "density steps": (with_value("density_solver_steps", 10**18), "density_solver_steps is 1000"),
    "many samples": (sensor_with(samples=10**8), ""),
    "samples to 1e300": (sensor_with(samples=1e300), DESCRIBE),
    "wider": (summary_with(width=10**9), "a size is 1e+09"),
    "deep": (summary_with(blocks=10**9), "a size is 1e+09"),
    "long": (summary_with(channels=[4] * 10**5), "a size is 100000"),
    "nested": (with_settings(lambda _: "[" * 200_000 + "]" * 200_000), "RecursionError"),
    "digits": (with_settings(lambda _: '{"seed": ' + "9" * 300_000 + "}"), DESCRIBE),
    "header claimed": (raw(b"{}", 2**62), NOT_A_MODEL),
    "header long": (raw(b" " * 5_000_000), NOT_A_MODEL),
    "header nested": (raw(b"[" * 900_000), NOT_A_MODEL),
    "header of one text": (raw(b'{"__metadata__": {"a": "' + b"x" * 900_000 + b'"}}'), "is None"),
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
    assert not target.with_name("ran").exists()  # no pickle is run


LOAD_ALL = """
import json, resource, sys, time
from breaker.paper.posterior import Posterior
Posterior.load(sys.argv[1])  # what is loaded once
pages = int(open("/proc/self/statm").read().split()[0]) * resource.getpagesize()
resource.setrlimit(resource.RLIMIT_AS, (pages + 2**28, pages + 2**28))
for path in sys.argv[2:]:
    before, start = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss, time.process_time()
    try:
        Posterior.load(path)
        message = "loaded"
    except Exception as error:
        message = f"{type(error).__name__}: {error}"
    used = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before
    print(json.dumps([message[:3000], time.process_time() - start, used / 1024]))
"""


def test_no_model_file_takes_time_or_memory(model_file, tmp_path):
    """Not half a minute of a processor, and 100 MB each, under a limit of 256 MB."""
    files = []
    for i, (fault, _) in enumerate(HEAVY.values()):
        files.append(tmp_path / f"{i}.safetensors")
        fault(model_file, files[-1])
    command = [sys.executable, "-c", LOAD_ALL, model_file, *files]
    done = subprocess.run(command, capture_output=True, text=True, check=True, timeout=120)
    found = [json.loads(line) for line in done.stdout.splitlines()]
    assert len(found) == len(HEAVY)
    for path, (name, (_, message)), (said, seconds, megabytes) in zip(
        files, HEAVY.items(), found, strict=True
    ):
        assert said.startswith(f"ModelFileError: {path}"), (name, said)
        assert message in said, (name, said)
        assert said.endswith("train it anew"), (name, said)
        assert seconds < 30.0, name
        assert megabytes < 100.0, name
