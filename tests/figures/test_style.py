"""The one style: colours that stay apart, settings left alone, names, and what is in files."""

from itertools import combinations

import matplotlib as mpl
import numpy as np
import pytest
import xarray as xr
from matplotlib import font_manager
from matplotlib.colors import to_rgb
from matplotlib.text import Text

from breaker.diagnosis.curves import phase_colours
from breaker.figures import panels, style

POSTERIORS = {
    name: getattr(style, name)
    for name in ("AMORTISED", "CORRECTED", "WARNING", "MEASURED", "PRIOR", "REFERENCE", "MODEL")
}
# Colours that stand in one figure, and those of them that have to stay apart from all others.
OUTPUTS = {name: output.colour for name, output in panels.OUTPUTS.items()}
PALETTES = {
    "parameters": (OUTPUTS, OUTPUTS),
    "states": (panels.STATES, panels.STATES),
    "posteriors": (POSTERIORS, ("AMORTISED", "CORRECTED")),
}

# Machado, Oliveira & Fernandes 2009, severity 1.0: what a deficient eye sees, in linear RGB.
SIGHT = {
    "normal": np.eye(3),
    "protanopia": [
        [0.152286, 1.052583, -0.204868],
        [0.114503, 0.786281, 0.099216],
        [-0.003882, -0.048116, 1.051998],
    ],
    "deuteranopia": [
        [0.367322, 0.860646, -0.227968],
        [0.280085, 0.672501, 0.047413],
        [-0.011820, 0.042940, 0.968881],
    ],
    "tritanopia": [
        [1.255528, -0.076749, -0.178779],
        [-0.078411, 0.930809, 0.147602],
        [0.004733, 0.691367, 0.303900],
    ],
}


def lab(colour, sight):
    """CIELAB of a colour as it is seen, from sRGB with white point D65."""
    rgb = np.array(to_rgb(colour))
    linear = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    seen = np.clip(np.asarray(sight) @ linear, 0.0, 1.0)
    to_xyz = [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]]
    x, y, z = np.cbrt(np.maximum(to_xyz @ seen / [0.9505, 1.0, 1.089], 1e-9))
    return np.array([116 * y - 16, 500 * (x - y), 200 * (y - z)])


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


def test_phases_have_the_colours_of_their_names():
    """Those of another system, or of none, have colours that differ."""
    red, amber, blue = phase_colours("RYB").values()
    assert phase_colours("bca") == {"b": amber, "c": blue, "a": red}
    assert to_rgb(red)[0] > 0.7 > to_rgb(blue)[0]
    lines = phase_colours(["L3", "L1", "L2"])
    assert [*lines.values()] == [phase_colours("UVW")[item] for item in "WUV"]
    assert lines["L2"] == "#000000"
    assert [*phase_colours("RST").values()] == [red, amber, blue]
    for others in (["Travel 1", "R"], [""]):
        assert len({*phase_colours(others).values()} - {red}) == len(others)


def test_settings_are_left_alone_and_not_taken_over():
    @style.styled
    def draw():
        figure, (axis,) = panels.panels(1)
        axis.set_xlabel("x")
        return figure

    with mpl.rc_context({"font.size": 31.0, "axes.grid": False, "figure.dpi": 40}):
        before = dict(mpl.rcParams)
        figure = draw()
        assert dict(mpl.rcParams) == before
    assert figure.axes[0].xaxis.label.get_size() < 12
    assert figure.dpi == 150


def test_names_of_limits_are_no_mathematics():
    data = xr.Dataset({}, {"limit": [r"50_\$ or $x^{ <b>`*ü"], "operation": [1, 2]})
    figure, (axis,) = panels.limit_panels(data, ["f below 1"], height=2.0)
    figure.canvas.draw()  # mathematics would raise
    assert axis.get_title("left").startswith(r"50 \\$ or \$x^{ <b>`*ü")


# ---- files ---------------------------------------------------------------------------------------


@style.styled
def titled(name):
    figure = style.new_figure(4.0, 3.0)
    axis = figure.subplots()
    axis.plot([0.0, 1.0])
    axis.set_title(style.literal(name), weight="bold")
    return figure


def test_signs_that_no_font_has_are_in_the_log(monkeypatch, caplog):
    """On a machine that has the fonts of matplotlib alone."""
    own = [item for item in font_manager.fontManager.ttflist if item.name not in style.OTHER_FONTS]
    monkeypatch.setattr(font_manager.fontManager, "ttflist", own)
    for name, count in (("Ω Выкл مفتاح", 0), ("$x 开关", 1)):
        caplog.clear()
        assert style.encoded(titled(name), "png")
        assert (len(caplog.messages) > 0) == count


@pytest.mark.parametrize("form", ["png", "svg", "pdf", "jpg"])
def test_a_file_has_no_date_and_no_hidden_sign(form):
    drawn = titled("L1\u202e\u200b\x1b")
    content = style.encoded(drawn, form)
    assert not [date for date in (b"<dc:date>", b"/CreationDate") if date in content]
    assert r"L1\u202e\u200b\x1b" in [item.get_text() for item in drawn.findobj(Text)]
