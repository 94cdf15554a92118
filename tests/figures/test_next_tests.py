"""The figure of `breaker plan`: bars are as long as sds, and the best test is above."""

import pytest

from breaker.drive.answers.next_test import Narrowing, Outlook, Plan, Plans
from breaker.figures.next_tests import next_tests


def outlook(name, gain, told, reason=""):
    return Outlook(name, f"do {name}", 2.0, gain, gain / 2.0, told, {}, reason)


@pytest.fixture(scope="module")
def plans():
    narrowing = {
        "L": Narrowing("parameter", "%", 8.0, 4.0, 0.3),
        "wide": Narrowing("limit", "1", 0.5, 0.4, 0.01),
    }
    tests = [outlook("contact", 0.6, narrowing), outlook("size", 0.0, {}, "not simulated")]
    one = Plan("Q1", "L1", {"closing": 1}, ["L", "wide"], tests)
    return Plans([one, Plan("Q1", "L2", {}, [], [], "out of the family")], {}, {})


def test_bars_are_sds(plans):
    figure = next_tests(plans)
    gain, gap, limit = figure.axes
    assert [bar.get_width() for bar in gain.patches] == pytest.approx([30.0, 0.0])
    assert [bar.get_width() for bar in gap.patches] == pytest.approx([8.0, 4.0])
    assert [bar.get_width() for bar in limit.patches] == pytest.approx([0.5, 0.4])
    assert gap.get_ylim()[0] > gap.get_ylim()[1]  # the first test is above
    assert "%" in gap.get_xlabel()
    assert "%" not in limit.get_xlabel()


def test_it_says_what_to_do_first(plans):
    (part,) = next_tests(plans).subfigs
    words = " ".join(part.get_suptitle().split())
    assert words.startswith("Q1, L1: first: do contact. It takes away 60 % of the variance")
