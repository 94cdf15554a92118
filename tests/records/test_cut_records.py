"""Records that end early have a right, wide or no stroke."""

import numpy as np
import pytest

from breaker.records.measurements import measure_curve
from tests.raws import swinging


@pytest.mark.parametrize("rate", [5.0, 20.0, 40.0])
@pytest.mark.parametrize("stroke", [13.5, 150.0])
def test_a_record_that_is_cut_has_no_wrong_stroke(stroke, rate):
    """Cut from half of the way to a duration after it: 40 cuts, of which none may be off by more
    than five sds and 2 %.
    """
    rng = np.random.default_rng([5, int(stroke), int(rate)])
    duration, reported = 12.0 * (stroke / 13.5) ** 0.7, 0
    for until in np.linspace(0.5, 2.0, 40):
        time = np.arange(0.0, duration * (1.0 + until), 1.0 / rate)
        noise = stroke * 10.0 ** rng.uniform(-3.2, -2.0)
        way = swinging(time - duration, stroke, duration, rng.choice([0.0, 0.12]))
        try:
            found = measure_curve(time, way + noise * rng.standard_normal(time.size), "closing")
        except ValueError:
            continue
        if not found["stroke"].reason:
            reported += 1
            off = abs(found["stroke"].value - stroke)
            assert off < max(5.0 * found["stroke"].sd, 0.02 * stroke), until
    assert reported >= 5


@pytest.mark.parametrize("creeps", [True, False])
def test_a_creep_that_noise_hides_is_in_the_stated_error(creeps):
    """Of 150 strokes 90 % should be within the interval that says so, of drives at rest, too, whose
    intervals are to stay narrow; without that error, 75 % are of drives that creep.
    """
    rng, held, sds = np.random.default_rng(6), [], []
    for _ in range(150):
        time = np.arange(0.0, rng.uniform(50.0, 75.0), rng.choice([0.1, 0.2, 0.5]))
        way = swinging(time - 20.0, 13.5, 12.0, rng.choice([0.0, 0.08]))
        if creeps:
            lasts, size = rng.uniform(10.0, 20.0), 0.015 * 13.5 * rng.standard_normal()
            way -= size * np.exp(-np.maximum(time - 30.0, 0.0) / lasts) * (way / 13.5)
        noise = rng.choice([0.05, 0.1, 0.2]) * rng.standard_normal(time.size)
        found = measure_curve(time, way + noise, "closing")["stroke"]
        held.append(abs(found.value - 13.5) < 1.645 * found.sd)
        sds.append(found.sd)
    assert np.mean(held) >= 0.85
    assert creeps or np.median(sds) < 0.003 * 13.5
