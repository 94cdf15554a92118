"""Which test to do next: what tests would narrow, and what they would not."""

import json
from dataclasses import replace

import numpy as np
import pytest

from breaker.cli import main
from breaker.common.randomness import generator
from breaker.documents.terminal import text_of
from breaker.drive.answers import next_test
from breaker.drive.answers.evidence import Given
from breaker.drive.answers.next_test_words import words_of_plans
from breaker.drive.simulation.drive_family import Family
from breaker.drive.simulation.rich_drive import CONTACTS
from breaker.drive.training.mechanism_sizes import drive_with, mechanism_sizes
from breaker.quantities.parameters import NAMES
from tests.answers.conftest import SETTINGS
from tests.cli.conftest import written

NO_LIMITS = ()


@pytest.fixture(autouse=True, scope="module")
def few_drives():
    """Few drives, so that tests are quick."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(next_test, "_DRIVES", 8)
        patch.setattr(next_test, "_FEWEST", 4)
        patch.setattr(next_test, "_EACH", 300)
        yield


@pytest.fixture(scope="module")
def tests(defaults):
    return defaults["next_tests"]


@pytest.fixture(scope="module")
def foretold(infer, records):
    """The tests of a closing, or of other records, by name."""

    def foretold(tests, some=records[:1], given=None, limits=NO_LIMITS, asked=()):
        given = given or Given()
        answers = infer(given, some)
        (pole,) = next_test.plan(answers, given, SETTINGS, limits, tests, asked).poles
        return {each.name: each for each in pole.tests}

    return foretold


def changed(tests, **values):
    """The section with other settings of some tests."""
    return tests | {name: tests[name] | each for name, each in values.items()}


def alone(tests, name, **values):
    """The section with one test."""
    found = {other: each | {"cost": None} for other, each in tests.items() if other != "facts"}
    return found | {"facts": {}, name: tests[name] | values}


def test_what_tells_nothing_narrows_nothing(tests, foretold):
    """A transducer as noisy as the present one, a measure as vague as none, and a mass."""
    vague = {**tests["facts"], "mu": {"cost": 1.0, "sd": 1e3, "what": "guess"}}
    found = foretold(changed(tests, finer_transducer={"noise": 1.0}) | {"facts": vague})
    for name in ("finer_transducer", "moving_mass"):
        assert found[name].gain == 0.0
        assert all(each.gone == 0.0 for each in found[name].narrowing.values())
    assert all(abs(each.gone) < 1e-4 for each in found["mu"].narrowing.values())
    assert found["other_motion"].gain > 0.1


def test_a_number_narrows_as_a_normal_posterior_would(tests, foretold):
    """The precision of what is measured adds to that of the posterior."""
    for sd in (0.05, 0.2):
        facts = {"mu": {"cost": 1.0, "sd": sd, "what": "weigh"}}
        told = foretold(alone(tests, "contact") | {"facts": facts})["mu"].narrowing["mu"]
        by_hand = 100.0 / np.hypot(100.0 / told.now, 1.0 / sd)
        assert told.expected == pytest.approx(by_hand, rel=0.05)


def test_a_mass_sets_the_scale(tests, foretold):
    found = foretold(changed(alone(tests, "moving_mass"), contact={"cost": 1.0}))
    force, f = found["moving_mass"].adds["closing_force"], found["contact"].narrowing["f"].now
    assert force == pytest.approx(np.hypot(f, 4.0), rel=1e-3)
    mass = Given(mass=(12.0, 0.5))
    assert "moving_mass" not in foretold(alone(tests, "moving_mass"), given=mass)


def test_more_of_a_test_narrows_more(tests, foretold):
    for name, some in {
        "more_records": [{"records": n} for n in (1, 20)],
        "finer_transducer": [{"noise": share} for share in (0.5, 0.1)],
    }.items():
        less, more = (foretold(alone(tests, name, **each))[name].gain for each in some)
        assert 0.0 < less < more


def test_only_what_can_be_done_is_offered(tests, foretold, records, timed):
    both = foretold(tests, [each for each in records if each.operation.number == 1])
    assert "other_motion" not in both
    assert {"contact", "size", "wipe", "more_records"} <= both.keys()
    known = foretold(tests, [timed(20.1)], given=Given(known={"wipe": [3.5, 0.3]}))
    assert not {"contact", "wipe"} & known.keys()
    costly = changed(tests, contact={"cost": None}, other_motion={"cost": None})
    assert not {"contact", "other_motion"} & foretold(costly).keys()


def test_the_best_for_its_cost_comes_first(tests, foretold):
    found = foretold(tests, asked=["L"])
    order = [each.per_cost for each in found.values()]
    assert order == sorted(order, reverse=True)
    gains = [each.gain / each.cost for each in found.values()]
    assert order == pytest.approx(gains, rel=1e-4)
    assert found["wipe"].gain == max(each.gain for each in found.values())
    cheap = foretold(changed(tests, finer_transducer={"cost": 1e-3}), asked=["L"])
    assert next(iter(cheap)) == "finer_transducer"


def test_a_drive_with_sizes_has_them(defaults, prior):
    """``drive_with`` is the inverse of ``mechanism_sizes``."""
    family, rng = Family(prior, defaults["family"]), generator(1, "drive with sizes")
    for _ in range(20):
        drive, laws = family.new(rng), family.new(rng)
        kind = CONTACTS.index(drive.elements.contact)
        laws = replace(laws, elements=replace(laws.elements, contact=drive.elements.contact))
        stroke, duration = 13.0 + rng.random(), 4.0 + rng.random()

        def sizes(some, kind=kind, stroke=stroke, duration=duration):
            theta, elements = some.numbers[None, : len(NAMES)], some.numbers[None, len(NAMES) :]
            about = (np.array([each]) for each in (kind, stroke, duration))
            found = mechanism_sizes(theta, elements, *about)
            return {name: float(each[0]) for name, each in found.items()}

        again = drive_with(laws, drive.theta, sizes(drive), stroke, duration)
        assert again.theta == drive.theta
        assert sizes(again) == pytest.approx(sizes(drive))


def test_every_rendering_has_the_tests(tmp_path, monkeypatch, capsys, prior):
    monkeypatch.chdir(tmp_path)
    written(tmp_path / "a.csv", prior, "closing")
    limits = "limits:\n  - {name: wide, motion: closing, of: model, upper: {L: 10.2}}\n"
    (tmp_path / "my.yaml").write_text(limits)
    command = ["plan", "a.csv", "--config", "my.yaml", "--narrow", "L", "wide", "build_up"]
    assert main([*command, "--json", "--plot", "a.png"]) == 0
    (pole,) = json.loads(capsys.readouterr().out)["poles"]
    assert pole["records"] == {"closing": 1}
    assert pole["asked"] == ["L", "wide", "build_up"]
    (wipe,) = [each for each in pole["tests"] if each["name"] == "wipe"]
    kinds = {name: wipe["narrowing"][name]["kind"] for name in pole["asked"]}
    assert kinds == {"L": "parameter", "wide": "limit", "build_up": "mechanism"}
    assert wipe["narrowing"]["wide"]["expected"] < 0.6 * wipe["narrowing"]["wide"]["now"]
    assert (tmp_path / "a.png").exists()
    assert main(command) == 0
    assert pole["tests"][0]["what"] in " ".join(capsys.readouterr().out.split())


def test_a_test_that_seems_to_widen_is_said_to_be_an_error():
    """By the law of total variance no test widens what is known, on average."""
    by = {"f": next_test.Narrowing("parameter", "%", 5.0, 5.5, 0.1)}
    outlook = next_test.Outlook(
        "more_records", "record more", 1.0, by["f"].gone, by["f"].gone, by, {}
    )

    def words(*tests):
        plan = next_test.Plan("", "", {"closing": 1}, ["f"], tests)
        return " ".join(text_of(words_of_plans(next_test.Plans([plan], {}, {}))).split())

    assert "that more_records would is an error of the networks" in words(outlook)
    assert "error of the networks" not in words(replace(outlook, gain=-0.01))


def test_errors_say_what_to_do(tmp_path, monkeypatch, capsys, prior):
    monkeypatch.chdir(tmp_path)
    written(tmp_path / "a.csv", prior, "closing")
    (tmp_path / "b.csv").write_text("1;2\n")
    (tmp_path / "my.yaml").write_text("next_tests: {contact: {cost: 0}}\n")
    assert main(["plan", "a.csv", "--narrow", "speed"]) == 1
    assert "--narrow speed: of this drive can be narrowed: mu, k_a" in capsys.readouterr().err
    assert main(["plan", "a.csv", "--config", "my.yaml"]) == 1
    assert "next_tests.contact.cost" in capsys.readouterr().err
    assert main(["plan", "b.csv"]) == 1
    assert "rejected: b.csv" in capsys.readouterr().out
