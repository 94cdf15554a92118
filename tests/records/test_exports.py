"""Exports of an analyser: what they state is shown, proposed, and set beside what is measured."""

import pytest

from breaker.documents.terminal import text_of
from breaker.records.proposal import inspect_file, words_of
from tests.exports import write

SENSOR = {"start": -2.0, "stop": 58.0, "samples": 151, "noise_sd": 0.1}


def inspected(tmp_path, channel="", **given):
    write(tmp_path / "export.csv", **given)
    return inspect_file(tmp_path / "export.csv", SENSOR, channel)


@pytest.mark.parametrize("plot", [200.0, 800.0])
def test_a_length_that_contradicts_the_rate_leaves_it_to_fill_in(tmp_path, plot):
    proposal = inspected(tmp_path, plot=plot)
    assert list(proposal.lacking) == ["rate"]
    assert f"{4000 / plot:g} kHz" in proposal.lacking["rate"]
    assert proposal.compared == []


@pytest.mark.parametrize("unused", ["zeros", "cross"])
def test_unused_channels_are_no_travels(tmp_path, unused):
    proposal = inspected(tmp_path, unused=unused)
    assert [travel.place for travel in proposal.travels] == [6, 7, 8]
    assert proposal.settings["stroke"] == [160.0, 197.0]
    shown = text_of(words_of(proposal))
    assert ("'Travel 4', 'Travel 5', 'Travel 6'" in shown) == (unused == "cross")


def test_printed_results_stand_beside_measured_ones(tmp_path):
    results = {"Stroke (mm)": [178.0, 182.0, 178.7], "Closing Velocity (m/s)": [4.1, 4.1, 4.4]}
    proposal = inspected(tmp_path, results=results)
    found = [(each.printed.quantity, str(each.column), each.differs) for each in proposal.compared]
    differ = {("stroke", "Travel 2"), ("speed", "Travel 3")}
    every = [(of, f"Travel {i}") for of in ("stroke", "speed") for i in (1, 2, 3)]
    assert found == [(*each, each in differ) for each in every]
    assert proposal.compared[1].difference == pytest.approx(178.36 / 182.0 - 1.0, abs=1e-3)
    assert text_of(words_of(proposal)).count("  <") == 2


def test_a_printed_time_stands_beside_that_from_coil_to_contact_or_has_its_reason(tmp_path):
    printed = {"Close Time (ms)": 50.0, "Rebound (mm)": 3.0, "Open Time (ms)": 0.0}
    results = {name: [value] * 3 for name, value in printed.items()}
    proposal = inspected(tmp_path, results=results)
    found = {(each.printed.quantity, bool(each.reason)) for each in proposal.compared}
    assert found == {("closing_time", False), ("rebound", True)}
    times = [each.measured for each in proposal.compared if not each.reason]
    assert all(40.0 < time < 80.0 for time in times)
