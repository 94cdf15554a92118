"""One thread for every test, the whole workflow first, and what tests of every room share."""

import os

# Before numpy is loaded, which reads it once. Files run side by side: threads that wait for each
# other on a busy machine take ten times as long as one.
os.environ["OMP_NUM_THREADS"] = "1"
# Workers, commands and jobs load the same modules again and again: compiled once, as is usual.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)

import numba
import pytest

from breaker.configuration import loading
from breaker.diagnosis import inference
from breaker.family.networks import open_network
from breaker.model.parameters import MOTIONS
from breaker.model.prior import Prior
from breaker.model.sensor import Sensor
from breaker.paper.joint_model import Model
from breaker.shipped import model_file

numba.set_num_threads(1)  # it has as many as there are cores for those tests that ask for more


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Start with the longest file, that of the whole workflow: the last one by its name."""
    items.sort(key=lambda item: str(item.path), reverse=True)


@pytest.fixture(scope="session")
def defaults():
    """Every setting with its default."""
    return loading.defaults()


@pytest.fixture(scope="session")
def prior(defaults):
    return Prior.from_settings(defaults["prior"])


@pytest.fixture(scope="session")
def sensor(defaults):
    return Sensor(**defaults["sensor"])


@pytest.fixture(scope="session")
def models(prior, sensor):
    return {motion: Model(prior, sensor, motion) for motion in MOTIONS}


@pytest.fixture(scope="session")
def levels():
    """The network of levels that ships."""
    return open_network(model_file("medium_voltage", "levels"))


@pytest.fixture(scope="module")
def a_quarter_of_the_draws():
    """Weigh a quarter of the draws, and ask for a quarter of their number, for speed."""
    with pytest.MonkeyPatch.context() as patch:
        for name in ("_ROUNDS", "_LEAST"):
            patch.setattr(inference, name, quarter_of(getattr(inference, name)))
        yield


def quarter_of(number):
    """A quarter of a number, or of several."""
    return tuple(map(quarter_of, number)) if isinstance(number, tuple) else number // 4


@pytest.fixture(scope="module")
def one_thread():
    """One thread of torch, so that the order of its sums is always the same."""
    # numba too: its parallel kernels set the number of threads that torch then works with.
    import torch  # most tests do without

    threads, of_numba = torch.get_num_threads(), numba.get_num_threads()
    numba.set_num_threads(1)
    torch.set_num_threads(1)
    yield
    numba.set_num_threads(of_numba)
    torch.set_num_threads(threads)
