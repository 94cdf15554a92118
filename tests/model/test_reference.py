"""The reference drive is that of the defaults, and is read without torch."""

import shutil
import subprocess
import sys

import pytest

from breaker.mechanism.parameters import MOTIONS
from breaker.model import reference
from breaker.model.prior import Prior
from breaker.model.reference import reference_model
from breaker.model.saved import ModelFileError
from breaker.model.sensor import Sensor
from breaker.shipped import DEFAULTS, model_file
from breaker.workflow.configuration import read


@pytest.mark.parametrize("motion", MOTIONS)
def test_it_is_that_of_the_defaults(motion):
    model, defaults = reference_model(motion), read(DEFAULTS)
    prior = Prior.from_settings(defaults["prior"])
    assert model.motion == motion
    assert model.prior.medians == pytest.approx(prior.medians)
    assert model.prior.log_sds == pytest.approx(prior.log_sds)
    assert model.sensor.settings() == Sensor.from_settings(defaults["sensor"]).settings()
    assert model.sensor.discrepancy.factor.shape == (20, 151)
    assert reference_model(motion, 0.0).sensor.discrepancy is None
    twice = reference_model(motion, 2.0).sensor.discrepancy
    assert twice.sd == pytest.approx(2.0 * model.sensor.discrepancy.sd)


def test_it_needs_no_torch():
    code = (
        "import sys; from breaker.model import reference_model; reference_model('closing'); "
        "print('torch' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "False\n"


def test_a_damaged_or_missing_file_is_refused_with_the_remedy(tmp_path, monkeypatch):
    file = shutil.copy(model_file("closing"), tmp_path / "closing.safetensors")
    monkeypatch.setattr(reference, "model_file", lambda motion: file)
    reference_model("closing")
    file.write_bytes(file.read_bytes()[:-3] + b"abc")
    with pytest.raises(ModelFileError, match=r"closing.*checksum.*install the package again$"):
        reference_model("closing")
    file.unlink()
    with pytest.raises(FileNotFoundError, match=r"no model file .*; install the package again$"):
        reference_model("closing")
