"""Names of pairs that lack a letter."""

from breaker.reading.files.name_value_pairs import pairs_of


def names(*cells):
    row = [part for cell in cells for part in (f"{cell} :", "1", "")]
    return [pair.name for pair in pairs_of([row])]


def test_a_name_that_lacks_a_letter_is_read_as_those_of_other_channels():
    usual = ["Mechanism Travel T1", "Mechanism Travel T2"]
    assert names(*usual, "Mehanism Travel T3") == [*usual, "Mechanism Travel T3"]
    assert names(*usual, "Contact Travel T3")[-1] == "Contact Travel T3"


def test_signs_of_numbers_in_names_stay():
    usual = ["Breaker # Travel T1", "Breaker # Travel T2"]
    assert names(*usual, "Breker # Travel T3") == [*usual, "Breaker # Travel T3"]
