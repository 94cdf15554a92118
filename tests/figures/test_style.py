"""The one style: colours that stay apart, settings left alone, names, and cells of operations."""

from itertools import combinations

import matplotlib as mpl
import numpy as np
import pytest
import xarray as xr
from PIL import Image

from breaker.figures import style
from breaker.figures.marks import COLOURS
from tests.figures.drawn import SIGHT, lab

POSTERIORS = {
    name: getattr(style, name)
    for name in ("AMORTISED", "CORRECTED", "WARNING", "MEASURED", "PRIOR", "REFERENCE", "MODEL")
}
# Colours that stand in one figure, and those of them that have to stay apart from all others.
OUTPUTS = {name: each.colour for name, each in style.OUTPUTS.items()}
PALETTES = {
    "parameters": (OUTPUTS, OUTPUTS),
    "states": (COLOURS, COLOURS),
    "posteriors": (POSTERIORS, ("AMORTISED", "CORRECTED")),
}


@pytest.mark.parametrize("sight", SIGHT)
@pytest.mark.parametrize("palette", PALETTES)
def test_colours_stay_apart(palette, sight):
    """15 CIELAB units, six times a just noticeable difference; the closest pair of the palette of
    Okabe and Ito is 16 apart."""
    colours, chosen = PALETTES[palette]
    seen = {name: lab(colour, SIGHT[sight]) for name, colour in colours.items()}
    pairs = [pair for pair in combinations(colours, 2) if {*pair} & {*chosen}]
    distances = {(a, b): np.linalg.norm(seen[a] - seen[b]) for a, b in pairs}
    assert {pair: distance for pair, distance in distances.items() if distance < 15} == {}


def test_settings_are_left_alone_and_not_taken_over():
    @style.styled
    def draw():
        figure, (axis,) = style.panels(1)
        axis.set_xlabel("x")
        return figure

    with mpl.rc_context({"font.size": 31.0, "axes.grid": False, "figure.dpi": 40}):
        before = dict(mpl.rcParams)
        figure = draw()
        assert dict(mpl.rcParams) == before
    assert figure.axes[0].xaxis.label.get_size() < 12
    assert figure.dpi == 150


def test_names_of_limits_are_no_mathematics():
    name = r"50_\$ or $x^{ <b>`*ü"
    data = xr.Dataset({}, {"limit": [name], "operation": [1, 2]})
    figure, (axis,) = style.limit_panels(data, ["f below 1"], height=2.0)
    figure.canvas.draw()  # mathematics would raise
    assert axis.get_title("left") == (r"50 \\$ or \$x^{ <b>`*ü: closing force $f$ below 1")


def test_spans_end_halfway_to_the_neighbours():
    operation = np.array([1, 3, 5, 6, 7, 9])
    assert style.edges(operation).tolist() == [0, 2, 4, 5.5, 6.5, 8, 10]
    assert style.edges(np.array([4])).tolist() == [3.5, 4.5]
    inside = np.array([True, False, True, True, False, True])
    assert style.spans(operation, inside) == [(0, 2), (4, 6.5), (8, 10)]
    assert style.spans(operation, np.zeros(6, dtype=bool)) == []


def test_a_saved_figure_is_light_and_keeps_its_colours(tmp_path):
    figure, (axis,) = style.panels(1)
    across = np.linspace(0, 1, 400)
    axis.scatter(across, across**2, c=across, cmap="viridis", alpha=0.3)
    figure.savefig(tmp_path / "full.png")
    style.save(figure, tmp_path / "light.png")
    full, light = (Image.open(tmp_path / f"{name}.png") for name in ("full", "light"))
    far = np.abs(np.asarray(full.convert("RGB"), int) - np.asarray(light.convert("RGB"), int))
    assert light.size == full.size
    assert far.mean() < 1
    assert far.max() < 90
    assert (tmp_path / "light.png").stat().st_size < 0.6 * (tmp_path / "full.png").stat().st_size
