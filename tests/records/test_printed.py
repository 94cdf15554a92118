"""Results of an analyser are compared with the same quantity, motion, channel and zone."""

import math

import pytest

from breaker.records.printed import stated_speeds
from breaker.records.proposal import inspect_file
from tests.records.printed_styles import STYLES, write_style

SENSOR = {"start": -2.0, "stop": 58.0, "samples": 151, "noise_sd": 0.1}


@pytest.mark.parametrize("style", STYLES)
def test_a_result_is_compared_with_its_counterpart_and_nothing_else(tmp_path, style):
    truth, phases = write_style(tmp_path / "export.csv", style)
    proposal = inspect_file(tmp_path / "export.csv", SENSOR)
    columns = [proposal.layout.column(each.place) for each in proposal.travels]
    phase_of = dict(zip(columns, phases, strict=True))
    compared = {}
    for each in proposal.compared:
        if math.isfinite(each.measured):
            motion = each.motion if (truth[each.printed.value] or ("", "?"))[1] else ""
            speed = each.printed.speed(each.motion, stated_speeds(proposal.layout.stated))
            zone = speed.words if speed else ""
            compared[each.printed.value] = phase_of[each.column], motion, each.quantity, zone
    assert compared == {value: each for value, each in truth.items() if each}
