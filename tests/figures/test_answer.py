"""The picture of an answer."""

import numpy as np
import pytest
import xarray as xr
from matplotlib.text import Text

from breaker.figures.answer import answer
from breaker.figures.style import WARNING

NAMES = ("mu", "k_a", "k_b", "gamma_a", "gamma_b", "f", "L", "wipe")


def part(motion, records=2, *, misfit=False, far=False, draws=60):
    rng = np.random.default_rng(1)
    time = np.linspace(-2.0, 58.0, 31)
    curve = rng.normal(size=31)
    curves = ("record", "median", "lower", "upper", "residual", "left_out")
    curves += ("family_lower", "family_upper")
    values = 1.0 + 0.1 * rng.random((records, draws, len(NAMES)))
    return xr.Dataset(
        {
            **{name: ("time", curve) for name in curves},
            "values_shown": (("operation", "draw", "shown"), values),
            "prior_shown": (("draw", "shown"), 1.0 + rng.random((draws, len(NAMES)))),
            "switching": ("draw", 10.0 + rng.random(draws)),
            "p_value": ("operation", np.full(records, 1e-9 if misfit else 0.4)),
            "misfit": ("operation", np.full(records, misfit)),
            "prior_p_value": ("operation", np.full(records, 1e-9 if far else 0.4)),
            "far_from_prior": ("operation", np.full(records, far)),
            "file": ("operation", [f"day/{motion}_{i}$.csv" for i in range(records)]),
        },
        coords={
            "time": time,
            "shown": list(NAMES),
            **{
                f"shown_{name}": ("shown", [f"{name} {each}" for each in NAMES])
                for name in ("symbol", "unit", "meaning")
            },
        },
    )


def titles(figure):
    return [axis.get_title(loc="left") for axis in figure.axes]


@pytest.mark.parametrize("motions", [["closing"], ["closing", "opening"]])
def test_each_motion_has_its_record_and_each_parameter_its_panel(motions):
    figure = answer({motion: part(motion) for motion in motions})
    assert len(figure.axes) == 2 * len(motions) + len(NAMES)
    for motion in motions:
        assert any(each.startswith(f"{motion} in {motion}_0") for each in titles(figure))
    assert " and ".join(f"2 {motion}s" for motion in motions) in figure.get_suptitle()


@pytest.mark.parametrize(
    ("doubts", "words", "colour"),
    [
        ({}, "fits the model, p = 0.4", "black"),
        ({"misfit": True}, "does NOT fit the model, p = 1e-09", WARNING),
        ({"far": True}, "does NOT fit the prior, p = 1e-09", WARNING),
        ({"misfit": True, "far": True}, "does NOT fit the model, p = 1e-09", WARNING),
    ],
)
def test_a_single_file_names_the_picture_and_a_misfit_is_red(doubts, words, colour):
    figure = answer({"closing": part("closing", 1, **doubts)})
    assert "closing_0" in figure.get_suptitle()
    (title,) = (each for each in figure.axes[0].findobj(Text) if words in each.get_text())
    assert title.get_color() == colour


def test_a_contact_that_never_touches_has_no_mark():
    data = part("closing", 1)
    data["switching"][:] = np.nan
    figure = answer({"closing": data})
    assert not figure.axes[0].texts
    assert "touch at" in answer({"closing": part("closing")}).axes[0].texts[0].get_text()


def test_motions_without_a_posterior_are_left_out():
    nothing = part("opening").isel(operation=[])
    assert len(answer({"closing": part("closing"), "opening": nothing}).axes) == 2 + len(NAMES)
