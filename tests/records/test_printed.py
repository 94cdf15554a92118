"""Results of an analyser are compared with the same quantity, motion and channel."""

import math

import pytest

from breaker.records.proposal import inspect_file
from tests.records.printed_styles import STYLES, write_style

SENSOR = {"start": -2.0, "stop": 58.0, "samples": 151, "noise_sd": 0.1}


@pytest.mark.parametrize("style", STYLES)
def test_a_result_is_compared_with_its_counterpart_and_nothing_else(tmp_path, style):
    truth = write_style(tmp_path / "export.csv", style)
    proposal = inspect_file(tmp_path / "export.csv", SENSOR)
    columns = [proposal.layout.column(each.place) for each in proposal.travels]
    phase_of = dict(zip(columns, "RYB", strict=True))
    compared = {}
    for each in proposal.compared:
        if math.isfinite(each.measured):
            motion = each.motion if (truth[each.printed.value] or ("", "?"))[1] else ""
            compared[each.printed.value] = phase_of[each.column], motion, each.quantity
    assert compared == {value: each for value, each in truth.items() if each}
