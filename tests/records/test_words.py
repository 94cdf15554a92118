"""Words and units of makers: motions, units of travel and time, and of currents and resistances."""

import numpy as np
import pytest

from breaker.records.words import (
    amperes_of,
    microohms_of,
    motion_of,
    motions_in,
    sequence_of,
    split_unit,
    unit_of,
)


@pytest.mark.parametrize(
    ("motion", "texts"),
    [
        ("closing", "Close coil 1|EIN-Spule|fermeture|合闸速度|V_closing (m/s)|C speed|включение"),
        ("opening", "Trip coil|Ausschaltzeit|apertura|分闸时间"),
        ("", "Stroke C|triple pole|分析|close-open|Enclosure"),
    ],
)
def test_a_motion_is_named_by_words_of_several_languages(motion, texts):
    assert {motion_of(text) for text in texts.split("|")} == {motion}
    assert motions_in("C_12") == ()


def test_a_sequence_is_read_in_its_order():
    sequences = {"O - t - CO - t' - CO": "O-C-O-C-O", "E-A": "C-O", "Trip": "O", "合分": "C-O"}
    assert {text: sequence_of(text) for text in sequences} == sequences


@pytest.mark.parametrize(
    ("unit", "spellings"),
    {
        "ms": ["ms", "(ms)", "msec", "MS", "milliseconds"],
        "us": ["us", "µs", "μs", "usec", "microseconds"],
        "deg": ["deg", "°", "[Deg]", "degrees", "Grad", "(grados)", "[gradi]", "degrés"],
        "inch": ["in", '"', "inches", "in.", "(in)", "pulgadas", "Zoll", "дюйм"],
        None: ["", "S", "M", "gone", "phase A", "1"],
    }.items(),
)
def test_units_are_known_in_any_spelling(unit, spellings):
    assert [unit_of(text) for text in spellings] == [unit] * len(spellings)


def test_a_unit_behind_a_blank_is_that_of_a_time_or_a_travel():
    names = {"weg cm": "cm", "Travel 1 mm": "mm", "Zeit s": "s", "in ms": "ms", "Hub zoll": "inch"}
    assert {name: split_unit(name)[1] for name in names} == names
    none = ["Coil mA", "Travel min", "travel in", "Travel S", "52a", "Travel (A)", "S/W"]
    assert [split_unit(name) for name in none] == [(name, None) for name in none]


def test_units_of_currents():
    stated = {"Coil Current C1 (A)": 1.0, "I coil [A]": 1.0, "Auslösestrom/mA": 1e-3}
    phases = ["Coil (A)", "Trip A", "Coil", "Coil [V]"]
    assert {name: amperes_of(name) for name in stated} == stated
    assert np.isnan([amperes_of(name) for name in phases]).all()
    assert amperes_of("Coil", "A") == 1.0
    assert np.isnan(amperes_of("Coil [A]", "V"))  # a row of units counts


def test_units_of_resistances():
    stated = {"Res [uOhm]": 1.0, "DCRM Res CH1 in uOhm": 1.0, "Res (mΩ)": 1e3, "R/Ohm": 1e6}
    stated |= {"Res 1 µΩ": 1.0, "Res 1 μΩ": 1.0}
    assert {name: microohms_of(name) for name in stated} == stated
    assert microohms_of("Res", "mOhm") == 1e3
    others = ["Res", "Res CH1", "Res [V]", "Contact 1", "Res [kOhm]", ""]
    assert np.isnan([microohms_of(name) for name in others]).all()
