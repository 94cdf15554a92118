"""Lives of judged rigs: wear, scatter and limits as stated, and what is kept of those followed."""

import numpy as np
import pytest

from breaker.mechanism.parameters import NAMES
from breaker.model.joint import Model
from breaker.synthetic.judged import family_of
from breaker.synthetic.judged_lives import FRACTIONS, RigLife, judge_lives, ratio_of
from breaker.synthetic.learning import ensemble, learn


@pytest.fixture(scope="module")
def judged(defaults):
    return defaults["judged"]


@pytest.fixture(scope="module")
def family(prior, defaults, judged):
    return family_of("held_back", prior, defaults["rigs"], judged)


@pytest.fixture(scope="module")
def lives(family, judged):
    rng = np.random.default_rng(1)
    return [RigLife.draw(family, judged, rng) for _ in range(60)]


def test_half_of_the_lives_have_a_change(lives, judged):
    """Within four standard errors of one half: false-alarm probability 1e-4."""
    changed = [life for life in lives if life.changes]
    assert abs(len(changed) - 30) < 4 * np.sqrt(15)
    low, high = np.array(judged["change"]) * judged["operations"]
    assert all(low <= life.change <= high for life in changed)
    assert all(life.faster == 1.0 for life in lives if not life.changes)


def test_wear_is_linear_and_faster_after_the_change(lives):
    life = next(each for each in lives if each.changes)
    assert life.share(0) == 0.0
    assert life.share(life.operations) == pytest.approx(1.0)
    early, late = life.share(np.array([100, 200])), life.share(life.change + np.array([0, 100]))
    assert np.diff(late) == pytest.approx(life.faster * np.diff(early))
    np.testing.assert_allclose(life.theta(np.array([life.operations]))[0], life.worn.theta)


def test_conditions_scatter_about_the_trend(lives, family, judged):
    """What does not wear stays; the scatter of what wears is the stated one, of 500 values."""
    names = family.settings["wear"]["change"]
    life = next(each for each in lives if each.worn.theta != each.new.theta)
    k = int(np.argmax(np.abs(np.subtract(life.worn.theta, life.new.theta))))
    drives = [life.condition(operation, names) for operation in range(1, 501)]
    trend = life.theta(np.arange(1, 501))
    relative = np.array([each.theta for each in drives]) / trend - 1.0
    assert relative[:, k].std() == pytest.approx(judged["scatter"], rel=0.2)
    still = np.equal(life.worn.theta, life.new.theta)
    np.testing.assert_allclose(relative[:, still], 0.0, atol=1e-12)


def test_limits_are_first_exceeded_where_they_say(lives, judged):
    """By the level, whatever single operations do."""
    found = 0
    for i, life in enumerate(lives):
        chosen = life.limit(judged["scatter"], np.random.default_rng(i))
        if chosen is None:
            continue
        limit, first = chosen
        over = limit.exceeded(limit.evaluate(life.theta(np.arange(1, life.operations + 200))))
        assert life.changes
        assert over[first - 1]
        assert not over[: first - 1].any()
        found += 1
    assert found >= 5


def test_ratio_grows_with_the_change(lives, prior, sensor, judged):
    models = {motion: Model(prior, sensor, motion) for motion in ("closing", "opening")}
    ratios = np.array([ratio_of(life, models, judged) for life in lives])
    assert np.isnan(ratios[[not life.changes for life in lives]]).all()
    assert np.nanmin(ratios) >= 0.0
    assert np.nanmax(ratios) > 1.0


def test_what_is_kept_of_lives(family, prior, sensor, defaults, judged):
    models = {motion: Model(prior, sensor, motion) for motion in ("closing", "opening")}
    rng = np.random.default_rng(2)
    learned = learn(
        ensemble(family, sensor, list(models), 60, rng), sensor, components=4, widening=1.3
    )
    short = judged | {"operations": 300}
    few = defaults["wear_model"] | {"baseline": 10, "settle": 10, "lines": 10, "horizon": 600}
    rows = judge_lives("held_back", family, models, learned, [0, 1], short, few)
    followed = rows[rows.score == "life"]
    assert set(followed.scale) == {0.0, 1.0}
    for _, one in rows.groupby(["life", "scale", "source"]):
        for score in ("level", "slope"):
            part = one[one.score == score]
            assert part.name.tolist() == list(NAMES)
            assert (part.lower <= part["median"]).all()
            assert (part["median"] <= part.upper).all()
        assert one[one.score == "remaining"].name.isin([f"{share:g}" for share in FRACTIONS]).all()
        assert one.change.nunique() == 1
    both = followed.groupby(["life", "scale"]).source.apply(set)
    assert all(each in ({"both"}, {"closing", "opening"}) for each in both)
