"""Words on where to look first: each quantity has some, and a wrong name is refused."""

import pytest

from breaker.configuration.loading import ConfigurationError, load
from breaker.drive.family.mechanisms import MECHANISMS
from breaker.quantities.catalogue import AFTER_RELEASE, ANSWERED, QUANTITIES
from breaker.shipped import DEFAULTS


def test_every_quantity_that_can_become_worse_has_its_words(defaults):
    known = {*QUANTITIES, *MECHANISMS} - ANSWERED | {*AFTER_RELEASE.values()}
    assert {*defaults["advice"]} == known
    assert all(1 < len(words) < 130 for words in defaults["advice"].values())


def test_a_name_that_nothing_has_is_refused(tmp_path):
    (tmp_path / "my.yaml").write_text("advice: {gama_a: grease}\n", encoding="utf-8")
    with pytest.raises(ConfigurationError, match=r"advice\.gama_a is not a known key"):
        load([DEFAULTS, tmp_path / "my.yaml"])
