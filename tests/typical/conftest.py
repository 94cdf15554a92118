"""Short chains, so that tests are quick."""

import pytest

from breaker.typical import spread


@pytest.fixture(autouse=True, scope="package")
def short_chains():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(spread, "_SWEEPS", 200)
        patch.setattr(spread, "_UNSETTLED", 40)
        yield
