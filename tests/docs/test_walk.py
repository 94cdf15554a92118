"""The commands of pages run in order in an empty folder, and print what the pages show."""

import re

import pytest

from breaker.configuration.data_files import simulated_test
from breaker.family.endurance import EnduranceTest
from breaker.family.exports import HIGH_VOLTAGE
from tests.bare import without_extras
from tests.scripts import script

walk = script("docs/walk.py")


@pytest.mark.parametrize("page", walk.PAGES, ids=lambda page: page.stem)
def test_commands_print_what_the_page_shows(page, tmp_path):
    """In an environment without extras."""
    (tmp_path / "empty").mkdir()
    bare = without_extras(tmp_path / "path")
    text = page.read_text(encoding="utf-8")
    steps = list(walk.run(text, tmp_path / "empty", environment=bare))
    shown = [walk.as_printed(block, output) for step, output in steps for block in step.shown]
    assert len(steps) > 2
    assert len(shown) == text.count("```text")


def test_true_values_are_stated(defaults):
    text = walk.PAGES[0].read_text(encoding="utf-8")
    drive = EnduranceTest.from_settings(simulated_test(defaults), 1).new.scaled(HIGH_VOLTAGE)
    stated = re.search(r"`mu` is (\S+), `k_a` (\S+), `k_b` (\S+) and `gamma_a` (\S+)\.", text)
    true = [f"{drive.value(name):.3g}" for name in ("mu", "k_a", "k_b", "gamma_a")]
    assert [*stated.groups()] == true


def test_a_line_that_is_not_printed_is_an_error():
    assert walk.as_printed("a 1 b\n...\n", "x\na  2 b\n") == "a  2 b\n...\n"
    with pytest.raises(ValueError, match="do not print"):
        walk.as_printed("a 1 c\n", "a 1 b\n")


def test_a_command_that_fails_is_an_error(tmp_path):
    with pytest.raises(RuntimeError, match="fails with 1"):
        list(walk.run("```sh\nbreaker infer nothing.csv\n```\n", tmp_path))
