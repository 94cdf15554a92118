"""Short chains, so that tests are quick, and the network of the family."""

import pytest

from breaker.family.saved import open_network
from breaker.shipped import model_file
from breaker.typical import spread


@pytest.fixture(autouse=True, scope="package")
def short_chains():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(spread, "_SWEEPS", 200)
        patch.setattr(spread, "_UNSETTLED", 40)
        yield


@pytest.fixture(scope="package")
def levels():
    return open_network(model_file("medium_voltage", "levels"))
