"""Which motions a text names."""

import pytest

from breaker.records.words import motion_of, motions_in, sequence_of


@pytest.mark.parametrize(
    ("text", "motion"),
    [
        *[(word, "closing") for word in ("Close coil 1", "EIN-Spule", "fermeture", "合闸速度")],
        *[(word, "closing") for word in ("Chiusura", "V_closing (m/s)", "C speed", "включение")],
        *[(word, "opening") for word in ("Trip coil", "Ausschaltzeit", "apertura", "分闸时间")],
        *[(word, "") for word in ("Stroke C", "triple pole", "分析", "close-open", "Enclosure")],
    ],
)
def test_a_motion_is_named_by_words_of_several_languages(text, motion):
    assert motion_of(text) == motion


def test_a_letter_is_no_word():
    assert motions_in("C_12") == ()


@pytest.mark.parametrize(
    ("text", "sequence"),
    [
        ("O-0.3s-CO", "O-C-O"),
        ("O - t - CO - t' - CO", "O-C-O-C-O"),
        ("O-F", "O-C"),
        ("E-A", "C-O"),
        ("Trip", "O"),
        ("合分", "C-O"),
        ("Test a", ""),
        ("", ""),
    ],
)
def test_a_sequence_is_read_in_its_order(text, sequence):
    assert sequence_of(text) == sequence
