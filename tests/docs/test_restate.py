"""The texts state the numbers of the run: a digit that differs is seen."""

import csv

import pytest

from tests.scripts import ROOT, script

restate = script("docs/restate.py")

NUMBERS = {"gap": "0.07", "gap_se": "0.02", "operations": "2,000", "r": "-0.64"}
COUNTS = ("count", "truly_changed", "reported", "false")
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


def rows(table):
    """Return the rows of a table beside the pages."""
    with (ROOT / "docs" / table).open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def test_the_readme_states_what_the_family_and_its_lives_reach():
    """As the tables beside the page on evidence have it, each rate with its number."""
    lives = {row["score"]: row for row in rows("lives.csv")}
    held = [float(row["coverage_90"]) for row in rows("family_medium_voltage.csv")]
    plans = {(row["limit"], row["looked at"]): row for row in rows("plans.csv")}
    cost = "cost, beside a fixed interval"
    cells = [f"{100 * min(held):.0f} to {100 * max(held):.0f} %"]
    for of in ("changed", "measured"):
        row = lives[f"{of} limits: 90 % hold operations left"]
        some = (f"{float(row[n]):.2f} of {row[f'{n}_count']}" for n in ("other",))
        cells.append(", ".join(some))
    watched, visits = (plans["measured", way][cost] for way in ("watched", "visits"))
    cells.append(
        f"{float(watched):.2f}, {float(visits):.2f} ({plans['measured', 'visits']['lives']} "
    )
    cells.append(f"{plans['changed', 'visits'][cost]} ({plans['changed', 'visits']['lives']} ")
    alarms = {
        row["limit"]: f"{row['false']} of {row['of']}"
        for row in rows("alarms.csv")
        if (row["drives"], row["told"]) == ("few unworn", "due")
    }
    cells.append(f"{alarms['measured']}, {alarms['changed']}")
    changes = [row for row in rows("other_code.csv") if row["of"] == "change"]
    counts = {key: sum(int(row[key]) for row in changes) for key in changes[0] if key in COUNTS}
    still = counts["count"] - counts["truly_changed"]
    cells.append(f"{counts['reported']} of {counts['truly_changed']}, {counts['false']} of {still}")
    readme = restate.README.read_text(encoding="utf-8")
    assert [cell for cell in cells if f"| {cell}" not in readme] == []


def test_a_result_without_a_name_is_found():
    assert restate.unmarked(TEXT) == []
    added = "Coverage is 93 % here."
    assert restate.unmarked(f"{TEXT}\n{added}\n") == [f"{added}\n"]
    assert restate.unmarked(f"{TEXT}\n`alarm` of `0.95`\n") == []
