"""Reports in another language: every pattern of a report has a translation with the same values."""

import ast
import re
from pathlib import Path

import pytest

import breaker
from breaker.documents.parts import Cell, Document, Joined, Table, Text, in_language
from breaker.drive.answers.report_tables import RESULTS
from breaker.drive.answers.zone_words import zone_of
from breaker.quantities.catalogue import QUANTITIES
from breaker.quantities.moving_mass import MASS_QUANTITIES
from breaker.quantities.parameters import MOTIONS, PARAMETERS
from breaker.quantities.speeds import Speed
from breaker.shipped import words_of

SOURCE = Path(breaker.__file__).parent
VALUES = re.compile(r"\{(\w+)\}")
LETTERS = re.compile(r"[a-z]{2}")


def _is_name(node):
    return isinstance(node, ast.Name)


def patterns():
    """Every pattern in the source that has words of its own."""
    found = set()
    for file in sorted(SOURCE.rglob("*.py")):
        tree = ast.parse(file.read_text(encoding="utf-8"))
        assigned = [each for each in tree.body if isinstance(each, ast.Assign)]
        constants = {
            each.targets[0].id: each.value for each in assigned if _is_name(each.targets[0])
        }
        for node in ast.walk(tree):
            if isinstance(node, ast.Call) and getattr(node.func, "id", "") == "Text" and node.args:
                first = node.args[0]
                first = constants.get(first.id, first) if _is_name(first) else first
                found |= {first.value} if isinstance(first, ast.Constant) else set()
    return sorted(each for each in found if LETTERS.search(VALUES.sub("", each)))


@pytest.fixture(scope="module")
def german():
    return words_of("de")


def test_every_pattern_is_known_in_german(german):
    assert len(patterns()) > 50
    assert [each for each in patterns() if each not in german] == []


def test_a_translation_has_the_values_of_its_pattern(german):
    for english, other in german.items():
        assert sorted(VALUES.findall(english)) == sorted(VALUES.findall(other)), english


def test_what_a_sheet_shows_by_name_is_known_in_german(german):
    names = [each for each, q in QUANTITIES.items() if "record" in q.of or each == "wipe"]
    assert [
        each for each in (*names, *MOTIONS, *map(str, dict(RESULTS))) if each not in german
    ] == [
        "fail"  # of the data; the sheet says FAIL
    ]
    meanings = [each.meaning for each in (*PARAMETERS, *MASS_QUANTITIES)]
    assert [each for each in meanings if each not in german] == []


def test_another_language_changes_patterns_alone():
    known = {"{verdict}: {limits}": "{limits}: {verdict}", "FAIL": "DURCHGEFALLEN", "slow": "lahm"}
    told = Joined(", ", ["slow", Text("{text} ({where})", text="late", where="R")])
    cell = Cell(Text("{verdict}: {limits}", verdict=Text("FAIL"), limits=told), "bad")
    document = Document(
        "slow", summary=[cell], parts=[Table(("FAIL", Text("FAIL")), [(cell, "1")])]
    )
    other = in_language(document, known)
    assert other.title == "slow"  # names of users stay
    assert other.summary == ["slow, late (R): DURCHGEFALLEN"]
    assert other.summary[0].tone == "bad"
    assert other.parts[0].head == ("FAIL", "DURCHGEFALLEN")
    assert in_language(document, {}) == document


ZONES = [
    ("closing_speed", ["10 % of stroke", "90 % of stroke"]),
    ("closing_speed", ["6.5 mm before touch", "touch"]),
    ("closing_speed_late", ["10 ms before touch", "2.5 ms after touch"]),
    ("opening_speed", ["parting", "10 ms after parting"]),
    ("opening_speed_far", ["20 mm from closed", "40 mm from closed"]),
    ("opening_speed_to", ["20 mm from closed", "10 ms after 70 % of stroke"]),
    ("closing_speed_open", ["20 mm from open", "15 mm from closed"]),
]


@pytest.mark.parametrize(("name", "points"), ZONES)
def test_a_zone_in_english_is_that_of_the_speed_and_in_german_has_no_english(german, name, points):
    speed = Speed.read(name, points)
    assert zone_of(speed) == speed.words
    other = in_language(zone_of(speed), german)
    assert not {"from", "to", "before", "after", "of", "touch", "open"} & {*other.split()}
    assert re.findall(r"\d+", other) == re.findall(r"\d+", speed.words)
    assert "." not in other


def test_no_language_is_lost():
    assert words_of("en") == {}
    assert words_of("de")["pass"] == "bestanden"
