"""Quantities of motions against integrated curves read on a dense grid."""

import numpy as np
import pytest

from breaker.common.randomness import generator
from breaker.model.evaluation import evaluate
from breaker.model.parameters import NAMES
from breaker.model.quantities import check_fact, check_quantity
from tests.model_references import changed as with_values
from tests.model_references import integrate

CLOSING = ("spring_compression", "touch_time", "closing_speed", "over_travel")
OPENING = ("spring_compression", "separation_time", "opening_speed", "opening_over_travel")
MEDIANS = np.array([2.0, 0.045, 0.040, 0.30, 0.12, 0.75, 10.0])


def changed(**values):
    """The medians of the default prior with some of them set by name, ``(1, p)``."""
    return with_values(MEDIANS, **values)[None]


def brute_force(theta, motion):
    """The four quantities of a motion from its integrated curve, at a thousand points a ms."""
    _, k_a, k_b, _, _, f, gap = theta.tolist()
    held, times = (f + k_b * gap) / (k_a + k_b), np.arange(60_000) * 1e-3
    curve, switching, _ = integrate(theta, times, motion)
    level = np.interp(switching, times, curve) - 6
    if motion == "closing":
        last = np.flatnonzero((times < switching) & (curve <= level))[-1]
        passed = max(0.0, curve.max() - held)
    else:
        last = np.flatnonzero((times > switching) & (curve <= level))[0] - 1
        passed = max(0.0, -curve.min())
    low, high = sorted(curve[last : last + 2])
    share = (level - low) / (high - low)
    crossing = times[last] + 1e-3 * (share if motion == "closing" else 1 - share)
    return held - gap, switching, 6 / abs(switching - crossing), passed


# ---- values ----------------------------------------------------------------------------------


@pytest.mark.parametrize(("motion", "names"), [("closing", CLOSING), ("opening", OPENING)])
def test_brute_force_agrees(prior, motion, names):
    """Twice as close as asked, or better; without the cubics, or the parabola, ten times worse."""
    assert np.array_equal(MEDIANS, prior.medians)  # on which the sizes of ``evaluation`` rest
    theta = prior.sample(12, generator(1, "test", "quantities", motion))
    # The first comes to rest without passing it.
    theta[0] = changed(gamma_a=0.7 if motion == "closing" else 0.5)
    result = evaluate(names, theta, motion)
    expected = np.array([brute_force(row, motion) for row in theta])
    assert result.dtype == np.float64
    np.testing.assert_allclose(result[:, 0], expected[:, 0], rtol=1e-12)
    np.testing.assert_allclose(result[:, 1], expected[:, 1], atol=1e-7)
    np.testing.assert_allclose(result[:, 2], expected[:, 2], rtol=1e-4)
    np.testing.assert_allclose(result[:, 3], expected[:, 3], atol=1e-4)
    assert result[0, 3] == 0.0


# ---- what does not exist ---------------------------------------------------------------------


@pytest.mark.parametrize(
    ("motion", "change", "missing"),
    [
        # At rest at f / k_a = 8 mm, short of the gap.
        ("closing", {"f": 8 * 0.045}, [1, 2, 3]),
        # It swings to the gap, but there is no closed position to travel beyond, or to open from.
        ("closing", {"f": 0.44}, [3]),
        ("opening", {"f": 0.44}, [1, 2, 3]),
        # At 5.6 mm at the touch; at 5.3 mm at the separation, and then 0.6 mm beyond 0: never 6 mm.
        ("closing", {"L": 3.0}, [2]),
        ("opening", {"L": 2.0}, [2]),
        # With 1 mm more of gap it travels them.
        ("closing", {"L": 4.0}, []),
        ("opening", {"L": 3.0}, []),
        # So slow that at 60 ms it is millimetres from rest, on its way there.
        ("closing", {"gamma_a": 2.5}, [3]),
        ("opening", {"gamma_a": 2.5}, [3]),
    ],
)
def test_what_does_not_exist_is_nan(motion, change, missing):
    """The wipe is that of the formula, also where it is negative."""
    theta = changed(**change)
    row = evaluate(CLOSING if motion == "closing" else OPENING, theta, motion)[0]
    assert np.flatnonzero(np.isnan(row)).tolist() == missing
    _, k_a, k_b, _, _, f, gap = theta[0]
    assert row[0] == pytest.approx((f - k_a * gap) / (k_a + k_b))
    stroke = evaluate(["stroke"], theta, motion).item()
    assert np.isnan(stroke) if row[0] < 0 else stroke == pytest.approx(gap + row[0])


# ---- names -----------------------------------------------------------------------------------


def test_names_of_each_source():
    for motion, names in (("closing", CLOSING), ("opening", OPENING)):
        assert not any(check_quantity(name, motion) for name in (*NAMES, *names))
        assert not any(check_quantity(name, motion, of="change") for name in NAMES)
        assert check_quantity("reaction_time", motion, of="record") is None
        for name in (*NAMES, "spring_compression"):
            assert name in check_quantity(name, motion, of="record")
    assert check_quantity("touch_time", "opening")
    assert check_quantity("speed", "closing")
    assert check_quantity("stroke", "", of="change")


def test_known_values():
    assert check_fact(13.0, 0.1) is None
    assert all(check_fact(*wrong) for wrong in ((-13.0, 0.1), (13.0, 0.0), (13.0, 0.001)))


def test_errors():
    for names, theta, motion, words in (
        (["f", "speed"], MEDIANS[None], "closing", "speed is not"),
        ([], MEDIANS[None], "sideways", "unknown motion"),
        (["f"], changed(L=np.nan), "closing", "the first is L = nan in row 0"),  # not simulated
        (["f"], MEDIANS, "closing", r"shape \(n, 7\)"),
    ):
        with pytest.raises(ValueError, match=words):
            evaluate(names, theta, motion)
