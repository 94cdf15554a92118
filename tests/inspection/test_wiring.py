"""Which columns of contact and coil go with a column of travel."""

import numpy as np
import pytest

from breaker.inspection.layouts import Layout
from breaker.inspection.travelling import travel_channels
from breaker.inspection.wiring import columns_beside
from tests.exports import write

SIGNAL = np.repeat([0.0, 1.0], 50)


def beside(*names, motion="closing", quiet=()):
    """Settings beside the first of columns, of which some have no signal."""
    columns = [SIGNAL * (name not in quiet) for name in names]
    return columns_beside(Layout({}, [], list(names), [None] * len(names), columns), 0, motion)


@pytest.mark.parametrize(
    ("names", "contact"),
    [
        (("Travel 1", "Contact 1", "Contact 2"), "Contact 1"),
        (("Travel L2", "Contact L1", "Contact L2"), "Contact L2"),
        (("Weg", "Kontakt (V)"), "Kontakt (V)"),
        (("Travel 1 (mm)", "Res 1 (uOhm)", "Contact"), "Contact"),
        (("Travel 1", "Res 1", "Res 2"), "Res 1"),
        (("Travel 1", "Contact 2", "Aux contact 1"), None),
        (("Travel 1", "Contact 1 upper", "Contact 1 lower"), None),
        (("Travel", "Contact 1", "Contact 2"), None),
    ],
)
def test_a_contact_goes_with_the_travel_of_its_number_or_phase(names, contact):
    assert beside(*names).get("contact_column") == contact


@pytest.mark.parametrize(("motion", "coil"), [("closing", "Close coil"), ("opening", "Trip coil")])
def test_a_coil_goes_with_its_motion(motion, coil):
    found = beside("Travel 1", "Close coil", "Trip coil", "Motor current 1", motion=motion)
    assert found == {"trigger_column": coil}


def test_a_channel_without_a_signal_is_none():
    assert beside("Travel 1", "Contact 1", quiet=["Contact 1"]) == {}


def test_channels_of_an_export(tmp_path):
    write(tmp_path / "a.csv", motions=("closing", "opening"))
    found = travel_channels(tmp_path / "a.csv")
    assert [each.name for each in found.values()] == ["R", "Y", "B"]
    assert found["Travel 2"].beside["opening"] == {
        "contact_column": "Contact 2",
        "trigger_column": "Coil 2 (A)",
    }
