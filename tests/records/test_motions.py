"""Which motions a text names."""

import pytest

from breaker.records.words import motion_of, motions_in, sequence_of


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


@pytest.mark.parametrize(
    ("text", "sequence"),
    [
        ("O - t - CO - t' - CO", "O-C-O-C-O"),
        ("E-A", "C-O"),
        ("Trip", "O"),
        ("合分", "C-O"),
        ("", ""),
    ],
)
def test_a_sequence_is_read_in_its_order(text, sequence):
    assert sequence_of(text) == sequence
