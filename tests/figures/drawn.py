"""What tests of figures read from a drawn figure: words, lines and colours."""


def assert_drawn(figure):
    """Every text can be laid out, with its mathematics, and no panel is empty."""
    figure.canvas.draw()
    for axis in figure.axes:
        names_rows = axis.yaxis.get_ticks_position() == "right"
        assert axis.has_data() or axis.texts or names_rows or not axis.axison


def words(figure):
    """All texts of a figure that are not ticks."""
    texts = [text.get_text() for legend in figure.legends for text in legend.get_texts()]
    for axis in figure.axes:
        texts += [axis.get_title(loc) for loc in ("left", "center", "right")]
        texts += [axis.get_xlabel(), axis.get_ylabel()]
        if axis.get_legend() is not None:
            texts += [text.get_text() for text in axis.get_legend().get_texts()]
    notes = [text.get_text() for text in figure.artists]
    return "\n".join([figure.get_suptitle(), *notes, *texts])


def line_of(axis, colour, marker=None):
    """The first line of a colour, and of a marker where one is given."""
    lines = [line for line in axis.lines if line.get_color() == colour]
    return next(line for line in lines if marker is None or line.get_marker() == marker)
