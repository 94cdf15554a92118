"""Single records of judged rigs: sensors as stated, intervals that hold, and ones that cannot."""

from dataclasses import replace

import numpy as np
import pytest

from breaker.mechanism.parameters import NAMES
from breaker.model.discrepancy import Discrepancy
from breaker.model.joint import Model
from breaker.synthetic.judged import READ, Reading, family_of, judge_records, record_of


@pytest.fixture(scope="module")
def judged(defaults):
    return defaults["judged"] | {"scales": [0.0]}


@pytest.fixture(scope="module")
def exact(prior, defaults, judged):
    """A family of drives of the model, and a sensor as the model has it."""
    plain = judged | {"rounded": 0.0, "coloured": 0.0}
    return family_of("held_back", prior, defaults["rigs"] | {"strength": 0.0}, plain), plain


def nothing(model):
    t = model.sensor.samples
    return Discrepancy(np.zeros(t), np.zeros((7, t)), np.zeros((0, t)))


def hits(rows):
    return ((rows.lower <= rows.truth) & (rows.truth <= rows.upper)).to_numpy()


def test_only_foreign_rigs_have_what_the_family_lacks(prior, defaults, judged):
    rng = np.random.default_rng(1)
    for name, there in (("held_back", False), ("tuning", False), ("foreign", True)):
        elements = family_of(name, prior, defaults["rigs"], judged).new(rng).elements
        for element, (low, high) in judged["foreign"].items():
            value = getattr(elements, element)
            assert (low <= value <= high and value > 0.0) if there else value == 0.0


def test_sensors_round_and_colour(sensor, judged):
    """Correlation of neighbours from 15,100 samples: standard error 0.008."""
    rng = np.random.default_rng(2)
    zeroless = replace(sensor, zero_sd=0.0)
    read = np.array([Reading(0.0, 0.6).corrupt(np.zeros(151), zeroless, rng) for _ in range(100)])
    assert read.std() == pytest.approx(sensor.noise_sd, rel=0.05)
    assert (read[:, 1:] * read[:, :-1]).mean() / read.var() == pytest.approx(0.6, abs=0.04)
    rounded = Reading(0.25, 0.0).corrupt(np.linspace(0, 10, 151), sensor, rng)
    np.testing.assert_allclose(rounded / 0.25, np.round(rounded / 0.25), atol=1e-9)
    drawn = [Reading.draw(judged, rng) for _ in range(400)]
    # Shares of 400 within four standard errors: false-alarm probability 1e-4.
    assert np.mean([each.quantum > 0 for each in drawn]) == pytest.approx(0.5, abs=0.1)
    assert np.mean([each.colour > 0 for each in drawn]) == pytest.approx(0.25, abs=0.09)
    quanta = [each.quantum for each in drawn if each.quantum]
    assert judged["quantum"][0] <= min(quanta) < max(quanta) <= judged["quantum"][1]


def test_a_drive_that_does_not_hold_has_no_record(exact, sensor):
    drive = exact[0].new(np.random.default_rng(3)).changed(f=0.1)
    read = record_of(drive, sensor, "closing", Reading(0.0, 0.0), np.random.default_rng(4))
    assert np.isnan(read).all()


def test_rows(prior, sensor, defaults, judged):
    models = {motion: Model(prior, sensor, motion) for motion in READ}
    left_out = {motion: nothing(model) for motion, model in models.items()}
    family = family_of("foreign", prior, defaults["rigs"], judged)
    settings = judged | {"scales": [1.0, 0.0]}
    rows = judge_records(
        "foreign", family, models, left_out, [3, 7], settings, defaults["correction"]
    )
    assert len(rows) == 2 * 2 * 2 * 9
    assert rows.groupby("motion", sort=False).quantity.unique().map(list).to_dict() == {
        motion: [*NAMES, *names] for motion, names in READ.items()
    }
    assert (rows.lower <= rows.upper)[rows.resolved].all()
    same = rows[rows.quantity == "f"].groupby("rig").truth.nunique()
    assert same.tolist() == [1, 1]
    alone = judge_records(
        "foreign", family, models, left_out, [7], settings, defaults["correction"]
    )
    np.testing.assert_array_equal(alone.lower, rows[rows.rig == 7].lower)


def test_overconfident_posteriors_are_noticed(exact, prior, sensor, defaults, monkeypatch):
    """Of 20 intervals of the touch time, at least 12 hold, with probability 1 - 7e-5.

    With a fifth of the noise that there is they would hold in a quarter.
    """
    family, settings = exact
    found = {}
    true = sensor.corrupt  # whatever the model takes the noise for
    monkeypatch.setattr(Reading, "corrupt", lambda self, curve, _, rng: true(curve, rng))
    for share in (1.0, 0.2):
        model = Model(prior, replace(sensor, noise_sd=share * sensor.noise_sd), "closing")
        rows = judge_records(
            *("held_back", family, {"closing": model}, {"closing": nothing(model)}),
            *(range(20), settings, defaults["correction"]),
        )
        found[share] = hits(rows[rows.quantity == "touch_time"]).sum()
    assert found[1.0] >= 12
    assert found[0.2] < 12
