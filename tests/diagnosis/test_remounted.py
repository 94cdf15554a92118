"""What a transducer that was mounted again shows between two inspections is not of the drive."""

import numpy as np
import pytest

from breaker.diagnosis.inspection_change import compare_inspections
from breaker.diagnosis.reading import read_operations
from breaker.diagnosis.session import Diagnosis
from breaker.family.endurance import write_curve
from breaker.model.curves import travel
from breaker.model.parameters import MOTIONS
from breaker.records.operations import Operation

TIME = 0.1 * np.arange(760)  # ms


def inspection(folder, theta, rng, slack=0.0, zero=0.0):
    """Three records of each motion, with a slack of the transducer and its zero, mm."""
    folder.mkdir()
    operations = {motion: [] for motion in MOTIONS}
    for motion, some in operations.items():
        for number in (1, 2, 3):
            way = travel(theta[None], TIME, motion, onset=10.0).travel[0]
            gone = way if motion == "closing" else way[0] - way
            hidden = np.exp(-((gone / (2.0 * slack)) ** 2)) if slack else 0.0
            shown = gone * (1.0 - hidden)
            shown = (shown if motion == "closing" else way[0] - shown) + zero
            file = folder / f"{motion}_{number}.csv"
            noisy = shown + 0.05 * rng.standard_normal(TIME.size)
            write_curve(file, TIME, noisy, motion=motion, operation=number)
            some.append(Operation(number, file, phase="L1"))
    return read_operations(operations, {"zero": "rest"})


@pytest.mark.parametrize(
    ("change", "about", "codes"),
    [
        ((), {"today": 0.4}, ["other-slack"] * 2),
        ((), {"before": 0.4}, []),  # a start that takes longer may be a force that builds up later
        (((5, 0.97), (4, 1.5)), {"zero": 5.0}, []),
    ],
    ids=["slack", "slack before", "weaker force, more contact damping, another zero"],
)
def test_slack_of_the_transducer_is_a_difference_of_the_setup_and_wear_is_not(
    tmp_path, prior, defaults, change, about, codes
):
    rng, theta = np.random.default_rng(1), prior.medians.copy()
    first = inspection(tmp_path / "before", theta, rng, about.get("before", 0.0))
    for place, factor in change:
        theta[place] *= factor
    slack, zero = (about.get(name, 0.0) for name in ("today", "zero"))
    second = inspection(tmp_path / "today", theta, rng, slack, zero)
    result = compare_inspections(Diagnosis(defaults), {"before": first, "today": second})
    assert [one.code for one in result.differences if one.code == "other-slack"] == codes
    if codes:
        assert (result.state, result.reported) == ("different_setup", [])
