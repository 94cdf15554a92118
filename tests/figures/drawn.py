"""What tests of figures read from a drawn figure."""


def assert_drawn(figure):
    """Every text can be laid out, with its mathematics, and no panel is empty."""
    figure.canvas.draw()
    for axis in figure.axes:
        names_rows = axis.yaxis.get_ticks_position() == "right"
        assert axis.has_data() or axis.texts or names_rows or not axis.axison


def line_of(axis, colour, marker=None):
    """The first line of a colour, and of a marker where one is given."""
    lines = [line for line in axis.lines if line.get_color() == colour]
    return next(line for line in lines if marker is None or line.get_marker() == marker)
