"""What a known moving mass adds to an answer: forces, springs, friction and energies."""

import csv
import json

import numpy as np
import pytest

from breaker.cli import main
from breaker.common.plain_values import to_json
from breaker.common.randomness import generator
from breaker.drive.answers.answer_document import document, table_of
from breaker.drive.answers.assessment import Assessment, given_by
from breaker.drive.answers.moving_mass import mass_draws, with_mass

BY_HAND = {  # of 8 kg, f 0.75 mm/ms^2, k_a 0.045 and k_b 0.04 1/ms^2, gamma 0.3 and 0.12 1/ms
    "closing_force": 6_000.0,  # 750 m/s^2
    "opening_spring": 360_000.0,  # 45,000 1/s^2
    "contact_spring": 320_000.0,
    "drive_friction": 2_400.0,  # 300 1/s
    "contact_friction": 960.0,
    "closing_work": 120.0,  # 6,000 N over 20 mm
    "opening_energy": 72.0,  # half of 360,000 N/m times (0.02 m)^2
}


def test_units_are_those_computed_by_hand():
    theta = np.array([[2.0, 0.045, 0.04, 0.3, 0.12, 0.75, 10.0]])
    found = with_mass(theta, 20.0, np.array([8.0]))
    assert {name: float(each[0]) for name, each in found.items()} == pytest.approx(BY_HAND)


def test_its_doubt_is_in_every_interval_and_it_narrows_nothing(answers):
    draws = mass_draws(12.0, 1.0, 400, generator(1, "moving mass"))
    sure = np.full(400, 12.0)
    plain, known, wide = (document(answers, [[]] * 4, {}, {}, mass=m) for m in (None, sure, draws))
    for without, one, other in zip(plain.records, known.records, wide.records, strict=True):
        assert without.with_mass is None
        assert without.parameters == one.parameters == other.parameters
        assert without.quantities == other.quantities
        if not one.accepted:
            continue
        f = without.parameters["f"]
        force, doubtful = (each.with_mass["closing_force"] for each in (one, other))
        assert force.median == pytest.approx(12_000.0 * f.median, rel=1e-4)
        assert force.interval_95 == pytest.approx([12_000.0 * e for e in f.interval_95], rel=1e-4)
        assert doubtful.half > 1.2 * force.half
    rows = [
        row for row in csv.DictReader(table_of(wide).splitlines()) if row["kind"] == "with mass"
    ]
    assert [row["output"] for row in rows[:7]] == [*BY_HAND]
    assert "with_mass" not in json.loads(to_json(plain))["records"][0]


def test_draws_of_the_mass_are_of_the_seed(defaults):
    given, _ = given_by(defaults | {"known": {"mass": [12, 0.5]}})
    assert not given.known
    one, again = (Assessment(defaults, given=given).mass for _ in range(2))
    assert np.array_equal(one, again)
    assert len(one) == defaults["endurance"]["draws"]
    assert Assessment(defaults).mass is None


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("mass=0", "has the value 0."),
        ("mass=-3:0.1", "has the value -3."),
        ("mass=nan", "mass=12:0.5 in kg"),
        ("mass=12:nan", "mass=12:0.5 in kg"),
        ("mass=12:9", "from 0 to 4"),
    ],
)
def test_a_mass_that_nothing_has_is_refused(text, said, capsys):
    with pytest.raises(SystemExit):
        main(["infer", "a.csv", "--known", text])
    assert said in " ".join(capsys.readouterr().err.split())


def test_so_is_one_in_a_configuration(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "my.yaml").write_text("known: {mass: [0, 0.5]}\n")
    (tmp_path / "a.csv").write_text("1;2\n")
    assert main(["infer", "a.csv", "--config", "my.yaml"]) == 1
    assert "known.mass is [0, 0.5]" in capsys.readouterr().err
