"""What stands above the samples is read by its words, in any layout; a doubt is no guess."""

import math

import pytest

from breaker.records.header import header_of
from tests.exports import preamble


def split(text, sign=","):
    return [line.split(sign) for line in text.splitlines()]


RATES = {
    "Abtastrate;10;kHz": 10.0,
    "sample interval: 0.1 ms": 10.0,
    "采样频率: 20kHz": 20.0,
    "Sampling time: 50 us": math.nan,
    "Mains frequency 50 Hz": math.nan,
    "Sample rate;5000;samples/s": 5.0,
    "Samplerate=25600": 25.6,
    "Sampling Rate: 10": math.nan,
    "Resistance Range (uOhm) : 8000   Sampling Speed (kC) : 5": 5.0,
    "Time Base: 0.1 ms/sample": math.nan,
    "Rated Frequency (Hz) :,50,,Rated Voltage (kV) :,420": math.nan,
    "Sampling Speed : 10 kC, Resistance Range : 8000 uOhm": 10.0,
    "Operation : C - 0.3s - O, Sampling = 10kHz": 10.0,
}


@pytest.mark.parametrize("line", RATES)
def test_stated_rates(line):
    """As one cell, and split where a file has that sign between its cells."""
    for sign in ("\0", ",", *(";" if ";" in line else [])):
        result = header_of([line.split(sign)]).rate
        assert result == pytest.approx(RATES[line], nan_ok=True)


@pytest.mark.parametrize(
    ("text", "rate"),
    [
        ("Sampling Rate: 10", math.nan),
        ("Sampling Rate: 10 kHz\nSampling Rate 2: 5 kHz", math.nan),
        ("Sampling Rate: 10 kHz\nPlot Length (ms): 800", math.nan),
        ("Sampling Rate: 10 kHz\nPlot Length (ms): 398", 10.0),
        ("Plot Length (ms): 400", math.nan),
        ("Sampling Rate: 10 kHz\nPlot Length: 4", 10.0),  # perhaps of samples
        ("Sampling Speed (kC) : 10000", math.nan),  # which no recorder has
    ],
)
def test_a_doubtful_rate_has_its_reason(text, rate):
    result = header_of(split(text, "\0"), samples=4000)
    assert result.rate == pytest.approx(rate, nan_ok=True)
    assert bool(result.rate_doubt) == math.isnan(rate)


def test_all_of_an_analysers_preamble():
    results = {"Stroke (mm)": [178.0, 178.4], "Over Travel (mm)": [4.3, 4.4]}
    lines = preamble(results=results, channels=2, ratio=1.64, motions=("closing", "opening"))
    result = header_of([line.split(",") for line in lines], samples=4000)
    assert (result.rate, result.ratio) == (10.0, "1.64")
    assert (result.station, result.bay, result.type) == ("North 400 kV", "Bay 4", "LTB 420")
    assert (result.serial, result.operation) == ("HV-20417", "C-O")
    assert (result.dates, result.travel_unit) == (("2021-03-14T10:42:17",), "mm")
    assert result.phases == {1: "R", 2: "Y", 3: "B"}
    assert result.strokes == (178.0, 178.4)
    zones = [("closing", ["40 % of stroke", "80 % of stroke"])]
    zones += [("opening", ["20 % of stroke", "60 % of stroke"])]
    assert [(motion, speed.points) for motion, speed in result.speeds.items()] == zones


@pytest.mark.parametrize(
    ("text", "sign"),
    [
        ("Umspannwerk: Nord\nAbzweig: E04\nSerien-Nr.: 17", "\0"),
        ("Station,Nord,Bay,E04\nCB Serial No,17,Test Date,2021-03-04", ","),
        ("Station;Nord\nBay;E04\nGerät;17\nBreaker Type;GL314\nAerial;3", ";"),
        ("Station :,Nord,,,Bay :,E04,,\nTransducer Serial No :,9,,Serial No :,17,,,", ","),
        ('Station :,Nord,,,Bay :,E04,,\n"Serial": "17",,,', ";"),
    ],
)
def test_pairs_in_any_layout(text, sign):
    result = header_of(split(text, sign))
    assert (result.station, result.bay, result.serial) == ("Nord", "E04", "17")


def test_decimal_commas_and_contradictions():
    result = header_of(split("Hub L1;178,25 mm\nAbtastintervall (ms);0,05", ";"))
    assert (result.rate, result.strokes) == (20.0, (178.25,))
    result = header_of(split("Phase : R\nOperation : C\nPhase : Y\nOperation : O", "\0"))
    assert (result.phases, result.operation) == ({}, "")


@pytest.mark.parametrize(
    ("text", "dates"),
    [
        ("Test Date: 03/14/2021 1:05 PM", ["2021-03-14T13:05:00"]),
        ("Test Date: 02/03/2021", ["2021-03-02", "2021-02-03"]),
        ("Manufacturing Date: 01/05/2004\nDate: 05/05/2021", ["2021-05-05"]),
        ("Test Date: 02/03/2021\nTest Time: 10:42", ["2021-03-02T10:42:00", "2021-02-03T10:42:00"]),
    ],
)
def test_dates(text, dates):
    assert [*header_of(split(text, "\0")).dates] == dates
