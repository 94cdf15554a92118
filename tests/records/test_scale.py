"""From readings to mm: units, ratios, tables and quanta."""

import numpy as np
import pytest

from breaker.common.randomness import generator
from breaker.records.axes import Scale, seen_quantum
from breaker.records.rejections import UnusableError
from breaker.records.settings import complete


def scale(**settings):
    return Scale.from_settings(complete(settings))


def table(tmp_path, text):
    file = tmp_path / "table.csv"
    file.write_text(text, encoding="utf-8")
    return str(file)


@pytest.mark.parametrize(
    ("settings", "expected"),
    [
        ({}, [1.0, 2.0]),
        ({"travel_unit": "cm"}, [10.0, 20.0]),
        ({"travel_unit": "inch", "zero": 1.0, "sign": -1}, [0.0, -25.4]),
        ({"travel_unit": "deg", "ratio": 1.5, "zero": 0.5}, [0.75, 2.25]),
        ({"travel_unit": "V", "ratio": 30.0, "zero": "rest"}, [30.0, 60.0]),
    ],
)
def test_units_and_ratios(settings, expected):
    np.testing.assert_allclose(scale(**settings).travel(np.array([1.0, 2.0])), expected, rtol=1e-15)


def test_a_table_is_followed_smoothly_and_only_forwards(tmp_path):
    """A crank: 150 mm in 60 degrees, known at 13 angles; between them to 0.05 mm."""
    angle = np.linspace(-30.0, 30.0, 13)
    crank = 150.0 * (np.sin(np.deg2rad(angle)) + 0.5)
    rows = "\n".join(f"{a},{mm:.4f}" for a, mm in zip(angle, crank, strict=True))
    read = scale(travel_unit="deg", table=table(tmp_path, f"deg,mm\n{rows}\n"), zero="rest")
    fine = np.linspace(-30.0, 30.0, 1001)
    travel = read.travel(fine)
    assert (np.diff(travel) > 0).all()
    np.testing.assert_allclose(travel, 150.0 * (np.sin(np.deg2rad(fine)) + 0.5), atol=0.05)
    assert np.isnan(read.travel(np.array([0.0, np.nan]))[1])
    falling = scale(travel_unit="V", table=table(tmp_path, "5,0\n1,14\n"))
    np.testing.assert_allclose(falling.travel(np.array([5.0, 3.0, 1.0])), [0.0, 7.0, 14.0])


def test_beyond_a_table_is_no_travel(tmp_path):
    read = scale(travel_unit="V", table=table(tmp_path, "0,0\n5,100\n"))
    reading = np.linspace(0.0, 5.0, 200)
    # Noise at the ends goes on; few samples further out are doubtful; many are refused.
    np.testing.assert_allclose(read.travel(np.append(reading, 5.05))[-1], 101.0)
    assert np.isinf(read.travel(np.append(reading, [5.5, -7.0]))[-2:]).all()
    with pytest.raises(UnusableError):
        read.travel(2.0 * reading)


@pytest.mark.parametrize(
    "text",
    [
        *("", "0,0\n", "0,0\n0,1\n", "0,0\n1,5\n2,4\n", "0,0\n1,nan\n", "0,0,0\n1,5,0\n", None),
    ],
)
def test_a_wrong_table_is_refused_before_any_file(tmp_path, text):
    file = str(tmp_path / "none.csv") if text is None else table(tmp_path, text)
    with pytest.raises(ValueError, match=r"endurance\.format\.table"):
        scale(table=file)


# ---- quantum --------------------------------------------------------------------------------


def motion(step, stroke=14.0):
    time = np.arange(0.0, 76.0, step)
    return stroke / (1.0 + np.exp((22.0 - time) / 1.5))


@pytest.mark.parametrize(
    ("stroke", "quantum"),
    [(4.0, 0.0125), (4.0, 0.3), (14.0, 0.08), (150.0, 0.08), (150.0, 0.3175), (1000.0, 1.0)],
)
@pytest.mark.parametrize("noise", [0.0, 0.3])
def test_a_quantum_is_seen(stroke, quantum, noise):
    """Through print with four digits and a few spikes, with noise below the step."""
    rng = generator(1, "quantum")
    x = motion(0.1, stroke)
    x = quantum * np.round((x + noise * quantum * rng.standard_normal(x.size)) / quantum)
    x[[100, 500]] += rng.standard_normal(2)
    assert seen_quantum(np.round(x, 4)) == pytest.approx(quantum, rel=0.01)


@pytest.mark.parametrize("step", [0.01, 0.1, 0.4, 1.0])
@pytest.mark.parametrize("digits", [3, 12])
def test_fine_readings_have_none(step, digits):
    x = motion(step)
    rng = generator(2, "quantum", str(step))
    for noise in (0.02, 0.1):
        assert seen_quantum(np.round(x + noise * rng.standard_normal(x.size), digits)) < 0.004
