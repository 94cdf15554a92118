"""The judgement of a network of a family: right posteriors pass, narrow and shifted ones do not."""

import numpy as np
import pytest
import xarray as xr

from breaker.validation import family_quality, parameters_of

NAMES = ["f", "L", "later closing"]


def validation(*, width=1.0, shift=0.0):
    """Posteriors N(y, 1 / 2) of 1,000 truths N(0, 1) seen as y with noise of variance 1."""
    rng = np.random.default_rng(3)
    truth = rng.standard_normal((1000, 3))
    seen = truth + rng.standard_normal(truth.shape)
    draws = 0.5 * seen[:, None] + np.sqrt(0.5) * width * rng.standard_normal((1000, 200, 3)) + shift
    both = [np.concatenate([np.exp(a[..., :2]), a[..., 2:]], axis=-1) for a in (draws, truth)]
    dims = ("curve", "draw", "output"), ("curve", "output")
    data = {name: (d, a) for name, d, a in zip(("draws", "truth"), dims, both, strict=True)}
    return xr.Dataset(data, {"output": NAMES})


def test_right_posteriors_pass():
    """All outputs inside the band at 99 %, seed fixed: false alarm 1e-2 once, never again."""
    table = family_quality(validation(), log=True)
    assert table.calibrated.all()
    # 90 % of 1,000: beyond 0.033 from it with a probability of 5e-4 in each of three.
    assert (abs(table.coverage_90 - 0.9) < 0.033).all()
    assert table.contraction.to_numpy() == pytest.approx(0.5, abs=0.1)
    assert table.half_width.to_numpy() == pytest.approx(1.645 * np.sqrt(0.5), rel=0.05)


@pytest.mark.parametrize("fault", [{"width": 0.8}, {"shift": 0.3}])
def test_wrong_posteriors_are_noticed(fault):
    assert not family_quality(validation(**fault), log=True).calibrated.any()


def test_what_does_not_vary_has_no_contraction():
    data = validation()
    data["truth"][:, 2] = 0.0
    assert np.isnan(family_quality(data, log=True).contraction.iloc[2])


def test_figures_show_what_has_a_symbol():
    assert parameters_of(validation()).output.values.tolist() == NAMES[:2]
