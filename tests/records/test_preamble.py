"""What stands above the samples is read by its words, in any layout; a doubt is no guess."""

import math

import pytest

from breaker.records.dates import clock_of, dates_of
from breaker.records.header import header_of
from tests.exports import preamble


def split(text, sign=","):
    return [line.split(sign) for line in text.splitlines()]


@pytest.mark.parametrize(
    ("line", "rate"),
    [
        ("Abtastrate;10;kHz", 10.0),
        ("sample interval 0.1 ms", 10.0),
        ("dt = 0.0001 s", 10.0),
        ("采样频率: 20kHz", 20.0),
        ("Sampling time: 50 us", None),
        ("Sample interval (µs): 50", 20.0),
        ("Mains frequency 50 Hz", None),
        ("Rate = 20 samples/ms", 20.0),
        ("Sample rate;5000;samples/s", 5.0),
        ("Duration: 600 ms", None),
        ("Recorded at 2024-11-20 15:13:07", None),
        ("Samplerate=25600", 25.6),
        ("Sampling Rate: 10000", 10.0),
        ("Sampling Rate: 10", None),
        ("Sampling Speed (kC) :,10,,Resistance Range (uOhm) :,8000", 10.0),
        ("Resistance Range (uOhm) : 8000   Sampling Speed (kC) : 5", 5.0),
        ("Number of samples: 8000", None),
        ("Rated Frequency (Hz) :,50,,Rated Voltage (kV) :,420", None),
        ("Abtastrate: 12,5 kHz", 12.5),
        ("Sample rate (Hz): 20,000", 20.0),
        ("Sampling Speed : 10 kC, Resistance Range : 8000 uOhm", 10.0),
        ("Sampling Speed,:,10,kC,,Plot Length,:,400,ms", 10.0),
        ("No of Samples/ms : 10", 10.0),
        ("Samples/sec : 10000", 10.0),
        ("Sampling Rate (per sec) : 5000", 5.0),
        ("Time Base: 0.1 ms/sample", 10.0),
        ("Operation : C - 0.3s - O, Sampling = 10kHz", 10.0),
    ],
)
def test_stated_rates(line, rate):
    """As one cell, and split where a file has that sign between its cells."""
    signs = [
        "\0",
        *([] if ",000" in line or "12,5" in line else ","),
        *(";" if ";" in line else []),
    ]
    for sign in signs:
        found = header_of([line.split(sign)]).rate
        assert found == pytest.approx(rate) if rate else math.isnan(found)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("Sampling Rate: 10", "has no unit"),
        ("Sampling Rate: 10 kHz\nSampling Rate 2: 5 kHz", "several rates are stated"),
        ("Logger 20 kHz", "does not say that it is of the samples"),
        (
            "Sampling Rate: 10 kHz\nPlot Length (ms): 800",
            "4000 samples in a length of 800 ms are 5 kHz",
        ),
        ("Plot Length (ms): 400", "4000 samples in a length of 400 ms are 10 kHz"),
    ],
)
def test_a_doubtful_rate_is_none(text, said):
    found = header_of(split(text, "\0"), samples=4000)
    assert math.isnan(found.rate)
    assert said in found.rate_doubt


def test_a_length_confirms_a_rate_without_a_unit():
    found = header_of([["Sampling Rate:", "10"], ["Plot Length (ms):", "400"]], samples=4001)
    assert found.rate == 10.0


def test_a_rate_that_no_recorder_has_is_doubtful():
    found = header_of([["Sampling Speed (kC) :", "10000"]])
    assert math.isnan(found.rate)
    assert found.rate_doubt


@pytest.mark.parametrize(("samples", "told"), [(3015, False), (3061, True)])
def test_a_length_that_is_off_by_more_than_a_hundredth_is_told(samples, told):
    rows = [line.split(",") for line in ["Sampling Speed (kC) :,10", "Plot Length (ms) :,300"]]
    assert bool(header_of(rows, samples=samples).rate_doubt) == told


@pytest.mark.parametrize("length", ["4000", "4", "400"])
def test_a_length_without_a_unit_may_be_that_of_samples(length):
    found = header_of([["Sampling Rate:", "10 kHz"], ["Plot Length:", length]], samples=4000)
    assert found.rate == 10.0


def test_all_of_an_analysers_preamble():
    results = {"Stroke (mm)": [178.0, 178.4], "Closing Velocity (m/s)": [4.3, 4.4]}
    lines = preamble(results=results, channels=2, ratio=1.64, motions=("closing", "opening"))
    found = header_of([line.split(",") for line in lines], samples=4000)
    assert (found.rate, found.length, found.ratio) == (10.0, 400.0, 1.64)
    assert (found.station, found.bay, found.type) == ("North 400 kV", "Bay 4", "LTB 420")
    assert (found.serial, found.operation) == ("HV-20417", "C-O")
    assert (found.date, found.travel_unit) == ("2021-03-14T10:42:17", "mm")
    assert found.phases == {1: "R", 2: "Y", 3: "B"}
    assert len(found.speed_points) == 4
    assert found.doubts == ()
    assert [each[:5] for each in found.results] == [
        ("stroke", "", "CH1", 178.0, "mm"),
        ("stroke", "", "CH2", 178.4, "mm"),
        ("speed", "closing", "CH1", 4.3, "m/s"),
        ("speed", "closing", "CH2", 4.4, "m/s"),
    ]


LAYOUTS = {
    "cells": ("Umspannwerk: Nord\nAbzweig: E04\nSerien-Nr.: 17", "\0"),
    "equals": ("Station = Nord\nBay = E04\nSerial number = 17", "\0"),
    "bare pairs": ("Station,Nord,Bay,E04\nSerial No,17,Test Date,2021-03-04", ","),
    "tabs": ("Station\tNord\t\tBay\tE04\nSerial No.\t17", "\t"),
    "semicolons": ("Station;Nord\nBay;E04\nS/N;17", ";"),
    "pairs": ("Station :,Nord,,,Bay :,E04,,\nTransducer Serial No :,9,,Serial No :,17,,,", ","),
    "other signs": ("Station :,Nord,,,Bay :,E04,,\nSerial No :,17,,,", ";"),
    "blank value": ("Operator :,,,Station :,Nord,,\nBay :,,,,E04\nSerial No :,17", ","),
}


@pytest.mark.parametrize("name", LAYOUTS)
def test_pairs_in_any_layout(name):
    found = header_of(split(*LAYOUTS[name]))
    assert (found.station, found.bay, found.serial) == ("Nord", "E04", "17")


def test_decimal_commas():
    rows = split("Übersetzung;1,64\nHub L1;178,25 mm\nAbtastintervall (ms);0,05", ";")
    found = header_of(rows, ",")
    assert (found.ratio, found.rate) == (1.64, 20.0)
    assert [each[2:5] for each in found.results] == [("L1", 178.25, "mm")]


def test_nominal_values_and_points_are_no_results():
    text = "Rated Stroke (mm) :,180,,Closing Velocity Point 1 (%) :,40\nTransducer Stroke :,200\n"
    assert header_of(split(text + "Transducer :,Linear 225 mm\nStroke Limit :,5")).results == ()


@pytest.mark.parametrize(
    ("text", "dates"),
    [
        ("Test Date: 14/03/2021", ["2021-03-14"]),
        ("Test Date: 03/14/2021 1:05 PM", ["2021-03-14T13:05:00"]),
        ("Test Date: 02/03/2021", ["2021-03-02", "2021-02-03"]),
        ("Test Date: 02.03.2021", ["2021-03-02"]),
        ("Test Date: 2021-03-02T10:00:00", ["2021-03-02T10:00:00"]),
        ("Date: 2 March 2021", ["2021-03-02"]),
        ("Test Date: 02/03/2021\nCommissioning Date: 25/12/2004", ["2021-03-02"]),
        ("Manufacturing Date: 01/05/2004\nDate: 05/05/2021", ["2021-05-05"]),
        ("Test Date: 40/40/2021", []),
        ("Test Date: 02/03/2021\nTest Time: 10:42", ["2021-03-02T10:42:00", "2021-02-03T10:42:00"]),
    ],
)
def test_dates(text, dates):
    found = header_of(split(text, "\0"))
    assert list(found.dates) == dates
    assert found.date == (dates[0] if len(dates) == 1 else "")
    assert bool(found.doubts) == (len(dates) == 2)


def test_no_such_day_and_time():
    assert dates_of("31/02/2021") == {}
    assert clock_of("25:61") == ""


def test_contradictions_are_not_resolved_by_taking_the_first():
    found = header_of(split("Phase : R\nOperation : C\nPhase : Y\nOperation : O", "\0"))
    assert (found.phases, found.operation) == ({}, "")


@pytest.mark.parametrize(
    ("said", "kind"),
    [
        ("C", "C"),
        ("CO", "C-O"),
        ("O - 0.3 s - C O", "O-C-O"),
        ("Close-Open", "C-O"),
        ("Trip", "O"),
        ("Einschaltung", "C"),
        ("Routine", ""),
    ],
)
def test_operations(said, kind):
    assert header_of([["Operation :", said]]).operation == kind


def test_an_inch_sign_is_no_quotation_mark():
    (found,) = header_of([['Stroke : 7.02"']]).results
    assert (found.value, found.unit) == (7.02, '"')
    assert header_of([['"Serial": "7-7",']]).serial == "7-7"


@pytest.mark.parametrize(
    "name",
    ["CB Serial No. :", "CBSerial No. :", "Gerät :", "Breaker :", "CB No. :"],
)
def test_a_breaker_is_named(name):
    assert header_of([[name, "17/4"]]).serial == "17/4"
    assert header_of([["Breaker Type :", "GL314"], ["Aerial :", "3"]]).serial == ""


def test_a_name_with_two_brackets_keeps_channel_and_unit():
    row = "Stroke (T1)(mm) :,150.1,,Velocity (m/s)(T2) :,4.1,,Coil Current (A)(C1) :,2.1"
    found = header_of([row.split(",")]).results
    assert [(e.quantity, e.channel, e.value, e.unit) for e in found] == [
        ("stroke", "T1", 150.1, "mm"),
        ("speed", "T2", 4.1, "m/s"),
        ("coil_current", "", 2.1, "A"),
    ]


def test_the_way_of_the_contact_is_not_that_of_the_mechanism():
    row = "Mechansm Travel(T1)(mm) :,120.5,,Contact Travel(T1)(mm) :,178.2"
    row += ",,Close - Datum Velocity (m/s)(T1) :,2.9"
    found = header_of([row.split(",")]).results
    assert [(each.quantity, each.motion) for each in found] == [
        ("mechanism_travel", ""),
        ("stroke", ""),
        ("datum_speed", "closing"),
    ]


def test_numbered_points_and_the_operation_of_a_test():
    rows = [["Close1 (%) :", "30", "", "Close2 (%) :", "60"], ["Test :", "O - C"]]
    found = header_of(rows)
    assert [pair.name for pair in found.speed_points] == ["Close1", "Close2"]
    assert found.operation == "O-C"
