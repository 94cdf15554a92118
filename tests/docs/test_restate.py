"""The texts state the numbers of the run: a digit that differs is seen."""

import pytest

from tests.scripts import script

restate = script("docs/restate.py")

NUMBERS = {"gap": "0.07", "gap_se": "0.02", "operations": "2,000", "r": "-0.64"}
TEXT = """A title with 3 words.

<!-- numbers: gap gap_se 95 operations
r -->
The gap of k_b is 0.07 ± 0.02 nats, 95 % of 2,000 operations
have x86-64 and `-c2`, and correlate by -0.64.

The next paragraph, of 10 words.
"""


@pytest.mark.parametrize("page", restate.PAGES, ids=lambda page: page.name)
def test_pages_state_the_numbers_of_the_run(page):
    text = page.read_text(encoding="utf-8")
    assert restate.restated(text, restate.read()) == text


def test_the_readme_states_no_result_without_naming_it():
    assert restate.unmarked(restate.README.read_text(encoding="utf-8")) == []


@pytest.mark.parametrize(
    ("right", "wrong"), [("0.07", "0.08"), ("2,000", "2,001"), ("-0.64", "0.64"), ("0.02", "0.020")]
)
def test_a_changed_digit_is_put_right(right, wrong):
    assert restate.restated(TEXT.replace(right, wrong), NUMBERS) == TEXT


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        (TEXT.replace("95 %", "96 %"), "95 is named, but 96"),
        (TEXT.replace("0.07 ± 0.02", "0.07"), "5 numbers are named"),
        (TEXT.replace("gap_se", "gap_sd"), "no number of the run is named gap_sd"),
    ],
)
def test_what_cannot_be_put_right_is_refused(wrong, message):
    with pytest.raises(ValueError, match=message):
        restate.restated(wrong, NUMBERS)


def test_a_result_without_a_name_is_found():
    assert restate.unmarked(TEXT) == []
    added = "Coverage is 93 % here."
    assert restate.unmarked(f"{TEXT}\n{added}\n") == [f"{added}\n"]
    assert restate.unmarked(f"{TEXT}\n`alarm` of `0.95`\n") == []
