"""The one style: colours of phases, settings left alone, names, and what is in files."""

import matplotlib as mpl
import pytest
import xarray as xr
from matplotlib.colors import to_rgb
from matplotlib.text import Text

from breaker.diagnosis.curves import phase_colours
from breaker.figures import panels, style


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


@pytest.mark.parametrize("form", ["png", "svg", "pdf", "jpg"])
def test_a_file_has_no_date_and_no_hidden_sign(form):
    drawn = titled("L1\u202e\u200b\x1b")
    content = style.encoded(drawn, form)
    assert not [date for date in (b"<dc:date>", b"/CreationDate") if date in content]
    assert r"L1\u202e\u200b\x1b" in [item.get_text() for item in drawn.findobj(Text)]
