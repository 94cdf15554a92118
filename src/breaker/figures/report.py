"""Pages of a test report: first what is measured, in tables, then the curves of all channels."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from io import BytesIO
from textwrap import wrap

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.image import imread
from matplotlib.lines import Line2D

from breaker.documents.parts import (
    Cell,
    Letterhead,
    Remark,
    Section,
    Table,
    tone_of,
    words_in,
)
from breaker.drive.answers.picture_data import Marked, Panel, PanelLabels
from breaker.drive.answers.test_report import Report
from breaker.figures import style
from breaker.figures.overlay import difference

_WIDTH, _HEIGHT = 8.27, 11.69  # inches, A4
_POINTS = 72.0  # in an inch
_MARGIN = 30.0  # points
_EDGE = _MARGIN / _POINTS  # inches
_ROOM = _WIDTH * _POINTS - 2 * _MARGIN  # points
_LETTER = 0.6  # width of one over its size, on average
_SIZE = 9.0  # points, of letters in tables
_NOTE = 7.5  # points, of letters in notes
_GAP = 1.3  # letters between columns
_BOLD = 1.15  # width of a bold letter, in others
_NARROW = 8  # letters of a column whose cells are not broken into lines
_LOGO = 34.0  # points, height
_SIGN = 150.0, 60.0  # points, width of a line to sign, and room above it
_REMARKS = 42.0  # points, room for remarks by hand
_LEADING = 1.42  # of lines, over the size of letters
_LINES = 1.2  # the same within a cell
_TONES = {"good": "#1B7837", "bad": style.WARNING, "doubt": "#B35806", "faint": "#777777"}
_CHANNELS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
_PANELS = {False: 4, True: 3}  # on a page, without and with a reference
_TALLEST, _PANEL_LEAST = 3.6, 1.7  # inches, of a panel
_NAME = 28  # letters of a channel's name
_LEGEND = 0.19  # inches, of a line of the legend
_KEYS_WIDE = 118  # letters in a line of the legend


class _Sheet:
    """Pages that are written from above, each begun where the one before is full."""

    def __init__(self) -> None:
        self.pages: list[list[dict]] = [[]]  # texts, as ``Figure.text`` takes them, and lines
        self.y = _MARGIN

    def room(self, height: float) -> None:
        """Begin a page where a height, points, is not left on this one."""
        if self.y + height > _HEIGHT * _POINTS - _MARGIN - 12.0:
            self.pages.append([])
            self.y = _MARGIN

    def write(self, x: float, text: str, size: float, below: float = 0.0, **look: object) -> None:
        """Write a text at a place of the line, or so many points below that."""
        place = {"x": x / (_WIDTH * _POINTS), "y": 1.0 - (self.y + below) / (_HEIGHT * _POINTS)}
        look = {"s": style.literal(text), "fontsize": size, "va": "top"} | look
        self.pages[-1].append(place | look)

    def line(self, begin: float, end: float) -> None:
        """Draw a line from left to right."""
        y = 1.0 - self.y / (_HEIGHT * _POINTS)
        ends = begin / (_WIDTH * _POINTS), end / (_WIDTH * _POINTS)
        self.pages[-1].append({"line": (ends, (y, y))})

    def paragraph(self, text: str, size: float, **look: object) -> None:
        """Write a text in lines, and go on below it."""
        for line in wrap(text, int(_ROOM / (size * _LETTER))):
            self.room(size * _LEADING)
            self.write(_MARGIN, line, size, **look)
            self.y += size * _LEADING

    def part(self, part: Section | Table | Remark | str) -> None:
        """Write a part of a document with its title and notes."""
        if isinstance(part, str | Remark):
            self.paragraph(words_in(part), _SIZE)
            return
        self.room(70.0)
        self.paragraph(part.title, 9.0, weight="bold")
        if isinstance(part, Section):
            for each in part.parts:
                self.part(each)
        else:
            self._table(part)

    def _table(self, table: Table) -> None:
        """Write a table; its head again where a page ends in it."""
        if table.rows:
            table, size, places = _fitted(table)
            head = table.head
            if head:
                self._row(head, size, places, weight="bold")
            for row in table.rows:
                if isinstance(row, str | Remark):
                    self.paragraph(words_in(row), size)
                    continue
                before = len(self.pages)
                self.room(_height(row, size))
                if head and len(self.pages) > before:
                    self._row(head, size, places, weight="bold")
                self._row(row, size, places)
        self.y += 2.0
        for note in table.notes:
            self.paragraph(note, _NOTE, color="#555555")
        self.y += 7.0

    def _row(self, row: Sequence[str], size: float, places: Sequence[float], **look) -> None:
        for k, (cell, at) in enumerate(zip(row, places, strict=True)):
            tone = tone_of(cell)
            own = {"color": _TONES[tone]} if tone else {}
            own |= {"weight": "bold"} if tone == "bad" else {}
            own |= {"ha": "left" if k == 0 else "right"}
            for line, text in enumerate(cell.split("\n")):
                below = size * (1.0 + _LINES * line)
                self.write(at, text, size, below=below, va="baseline", **(look | own))
        self.y += _height(row, size)


def _height(row: Sequence[str], size: float) -> float:
    lines = max(cell.count("\n") + 1 for cell in row)
    return size * (_LEADING + _LINES * (lines - 1)) + (2.0 if lines > 1 else 0.0)


def _fitted(table: Table) -> tuple[Table, float, list[float]]:
    """A table whose cells are broken into lines until it fits a page, the size of its letters, and
    where its columns are: the first begins, the others end there.
    """
    lines = ([style.shortened(line, _NAME) for line in e.split("\n")] for e in table.head)
    head = [Cell("\n".join(each), "bad") for each in lines]
    rows = [row for row in table.rows if not isinstance(row, str | Remark)]
    whole = [[*column] for column in zip(*rows, *([head] if head else []), strict=True)]
    columns, widths = [*whole], [*map(_width, whole)]
    most = _ROOM / (_SIZE * _LETTER) - _GAP * (len(widths) - 1)
    open_ones = {k for k, width in enumerate(widths) if width > _NARROW}
    while sum(widths) > most and open_ones:
        k = max(open_ones, key=widths.__getitem__)
        wide = widths[k]
        bold = _BOLD if any(tone_of(each) == "bad" for each in columns[k]) else 1.0
        broken = [_broken(each, int(wide / bold) - 1) for each in whole[k]]
        if (narrower := _width(broken)) < wide:
            columns[k], widths[k] = broken, narrower
        if not _NARROW < narrower < wide:
            open_ones.discard(k)
    letters = max(sum(widths) + _GAP * (len(widths) - 1), 1.0)
    size = min(_ROOM / (letters * _LETTER), _SIZE)
    broken = list(zip(*columns, strict=True))
    head, cells = ([*map(str, broken.pop())] if head else ()), iter(broken)
    every = [row if isinstance(row, str | Remark) else next(cells) for row in table.rows]
    wide = [width * size * _LETTER for width in widths]
    gap = (_ROOM - sum(wide)) / max(1, len(widths) - 1)
    gap = min(max(gap, 0.0), 4.0 * _GAP * size * _LETTER)
    places, end = [_MARGIN], _MARGIN + wide[0]
    for each in wide[1:]:
        end += gap + each
        places.append(end)
    return replace(table, head=head, rows=every), size, places


def _width(cells: Sequence[str]) -> float:
    """Letters of the longest line of some cells, as wide as those that are not bold."""
    wide = ((text, _BOLD if tone_of(text) == "bad" else 1.0) for text in cells)
    return max(factor * len(line) for text, factor in wide for line in text.split("\n"))


def _broken(text: str, most: int) -> Cell:
    """A cell in lines of so many letters, where blanks allow."""
    look = {"break_long_words": False, "break_on_hyphens": False}
    lines = (wrap(line, most, **look) or [""] for line in text.split("\n"))
    return Cell("\n".join(line for some in lines for line in some), tone_of(text))


def pages(report: Report) -> Iterator[Figure]:
    """Draw the pages of a report, one after the other: A4, upright."""
    sheet = _sheet(report)
    drawn = _parts(report.panels)
    free = _HEIGHT - (sheet.y + _MARGIN) / _POINTS
    joined = bool(drawn) and free > _PANEL_LEAST * len(drawn[0]) + 1.0
    total = len(sheet.pages) + len(drawn) - joined
    name = ", ".join(v for _, v in report.plate[:3] if tone_of(v) != "faint")  # whose it is
    parts = [(texts, (), 0.0) for texts in sheet.pages] + [((), each, 0.0) for each in drawn]
    if joined:
        last = len(sheet.pages) - 1
        parts[last : last + 2] = [(sheet.pages[last], drawn[0], sheet.y / _POINTS)]
    for number, part in enumerate(parts, start=1):
        foot = report.labels.page.format(number=number, total=total)
        figure = _page(*part, report.labels, f"{name} · {foot}")
        if number == 1 and report.letterhead:
            _logo(figure, report.letterhead)
        yield figure


def _sheet(report: Report) -> _Sheet:
    """All that is written."""
    sheet, around = _Sheet(), report.letterhead
    if around and around.company:
        right = {"ha": "right", "weight": "bold"}
        below = _LOGO + 4.0 if around.logo else 0.0
        sheet.write(_MARGIN + _ROOM, around.company, 9.0, below=below, **right)
    sheet.paragraph(report.title, 15.0, weight="bold")
    sheet.y += 4.0 + (_LOGO if around and around.logo else 0.0)
    _plate(sheet, report.plate)
    *warnings, verdict = report.summary
    for each in warnings:
        sheet.paragraph(each, 9.0, weight="bold", color=_TONES[tone_of(each)])
    color = _TONES.get(tone_of(verdict), "black")
    sheet.paragraph(verdict, 10.0, weight="bold", color=color)
    sheet.y += 6.0
    for part in report.parts:
        sheet.part(part)
    if around:
        _sign(sheet, around)
    return sheet


def _sign(sheet: _Sheet, around: Letterhead) -> None:
    """Remarks, and lines to sign."""
    sheet.room(_REMARKS + 12.0 + (_SIGN[1] + 12.0) * bool(around.signatures))
    sheet.paragraph("Remarks", 9.0, weight="bold")
    top = sheet.y
    for line in around.remarks.splitlines():
        sheet.paragraph(line, _SIZE)
    sheet.y = max(sheet.y, top + _REMARKS)
    if around.signatures:
        sheet.y += _SIGN[1] - 12.0
        step = _ROOM / max(len(around.signatures), 2)
        for k, each in enumerate(around.signatures):
            x = _MARGIN + k * step
            sheet.line(x, x + min(_SIGN[0] * 1.5, step - 12.0))
            sheet.write(x, each, 8.0, below=2.0)
        sheet.y += 16.0


def _logo(figure: Figure, around: Letterhead) -> None:
    """The logo in the upper right corner of a page."""
    if not around.logo:
        return
    image = imread(BytesIO(around.logo), format="png")
    high, wide = image.shape[:2]
    width = min(_LOGO * wide / high, 0.4 * _ROOM)
    height = width * high / wide
    page = _WIDTH * _POINTS, _HEIGHT * _POINTS
    box = (page[0] - _MARGIN - width) / page[0], 1.0 - (_MARGIN - 6.0 + height) / page[1]
    axis = figure.add_axes((*box, width / page[0], height / page[1]))
    axis.imshow(image)
    axis.set_axis_off()
    axis.set_in_layout(False)


def _plate(sheet: _Sheet, plate: Sequence[tuple[str, str]]) -> None:
    """The nameplate in two columns."""
    half = -(-len(plate) // 2)
    most = int(_ROOM / 2 / (8.0 * _LETTER)) - 18
    for left, right in zip(plate[:half], [*plate[half:], ("", "")][:half], strict=True):
        sheet.room(12.0)
        for k, (name, value) in enumerate((left, right)):
            x = _MARGIN + k * _ROOM / 2
            short = value if len(value) <= most else f"{value[: most - 1]}…"
            sheet.write(x, name, 8.0, color=_TONES["faint"])
            sheet.write(x + 85.0, short, 8.0)
        sheet.y += 12.0
    sheet.y += 6.0


def curve_pages(report: Report) -> Iterator[Figure]:
    """Draw the pages of curves alone."""
    for part in _parts(report.panels):
        yield _page((), part, 0.0, report.labels)


def _parts(panels: Sequence[Panel]) -> list[Sequence[Panel]]:
    """Panels by page."""
    most = _PANELS[any(each.overlays for each in panels)]
    return [panels[k : k + most] for k in range(0, len(panels), most)]


def _foot(figure: Figure, text: str) -> None:
    look = {"fontsize": 7.0, "color": _TONES["faint"], "ha": "center", "va": "bottom"}
    short = style.literal(style.shortened(text, 100))
    figure.text(0.5, 0.5 * _MARGIN / (_HEIGHT * _POINTS), short, **look)


@style.styled
def _page(
    texts: Sequence[dict],
    panels: Sequence[Panel],
    below: float,
    labels: PanelLabels,
    foot: str = "",
) -> Figure:
    """Draw texts, and panels below each other so many inches from the upper edge."""
    figure = Figure(figsize=(_WIDTH, _HEIGHT), layout="constrained" if panels else None)
    for each in texts:
        if "line" in each:
            figure.add_artist(Line2D(*each["line"], color="black", lw=0.6))
        else:
            figure.text(**each)
    if panels:
        _curves(figure, panels, max(below, _EDGE), labels)
    _foot(figure, foot)
    return figure


def _curves(figure: Figure, panels: Sequence[Panel], top: float, labels: PanelLabels) -> None:
    """Draw panels below each other, each with its marks, contacts and coils, and differences."""
    phases = list(dict.fromkeys(each.phase for panel in panels for each in panel.curves))
    colours = {phase: _CHANNELS[k % len(_CHANNELS)] for k, phase in enumerate(phases)}
    below = any(each.overlays for each in panels)
    free = _HEIGHT - top - _EDGE - _legend(figure, colours, labels, below=below)
    used = min(free, _TALLEST * (1.5 if below else 1.0) * len(panels)) / _HEIGHT
    box = (_EDGE / _WIDTH, 1.0 - top / _HEIGHT - used, 1.0 - 2 * _EDGE / _WIDTH, used)
    figure.get_layout_engine().set(rect=box)
    drawn = [(panel, draw) for panel in panels for draw in _drawings(panel)]
    ratios = [_SHARES[draw] for _, draw in drawn]
    axes = list(figure.subplots(len(drawn), 1, height_ratios=ratios, squeeze=False).flat)
    for k, (axis, (panel, draw)) in enumerate(zip(axes, drawn, strict=True)):
        draw(axis, panel, colours, labels)
        if draw is not _panel:
            axis.sharex(axes[k - 1])
        if k + 1 == len(drawn) or drawn[k + 1][1] is _panel:
            axis.set_xlabel(labels.time, fontsize=8)
        axis.tick_params(labelsize=7.5)
        axis.yaxis.label.set_size(8.0)


def _drawings(panel: Panel) -> list:
    """What is drawn of a panel, from above."""
    beside = any(each.beside for each in panel.curves)
    return [_panel, *([_beside] * beside), *([_below] * bool(panel.overlays))]


def _legend(figure: Figure, colours: dict[str, str], labels: PanelLabels, *, below: bool) -> float:
    """Draw the legend at the foot of a page, and return its height, inches."""
    named = (style.shortened(phase or labels.record, _NAME) for phase in colours)
    names = [style.literal(each) for each in named]
    keys = [style.line_key(*each) for each in zip(names, colours.values(), strict=True)]
    keys += [style.line_key(labels.reference, style.PRIOR, lw=2.4)] if below else []
    columns = max(1, _KEYS_WIDE // (max(map(len, [*names, labels.reference])) + 7))
    look = {"fontsize": 8.0, "loc": "lower center", "ncols": columns}
    figure.legend(handles=keys, bbox_to_anchor=(0.5, 1.1 * _EDGE / _HEIGHT + 0.012), **look)
    marks = "\n".join(labels.marks)
    figure.text(0.5, 0.95 * _EDGE / _HEIGHT, marks, fontsize=7.5, ha="center", va="bottom")
    return _LEGEND * (3 - -len(keys) // columns)


def _panel(axis: Axes, panel: Panel, colours: dict[str, str], labels: PanelLabels) -> None:
    for each in panel.overlays:
        _reference(axis, panel, each)
    for each in panel.curves:
        _marked(axis, each, colours[each.phase])
    axis.set_title(style.within(panel.title, _WIDTH - 1.0, 9.0), loc="left", fontsize=9)
    axis.set_ylabel(labels.travel)
    axis.margins(x=0)


def _beside(axis: Axes, panel: Panel, colours: dict[str, str], labels: PanelLabels) -> None:
    """Contacts, dashed, and coils, as shares of their ranges."""
    for each in panel.curves:
        for kind, share in each.beside.items():
            dashed = "--" if kind == "contact" else "-"
            axis.plot(each.time, share, color=colours[each.phase], lw=0.9, ls=dashed)
    axis.set(ylim=(-0.08, 1.08), yticks=(0.0, 1.0), ylabel=labels.beside)
    axis.margins(x=0)


def _reference(axis: Axes, panel: Panel, overlay) -> None:
    """The good record where the channel's own would be."""
    own = next(each for each in panel.curves if each.phase == overlay.phase)
    sign = 1.0 if panel.motion == "closing" else -1.0
    at, way = overlay.time + own.moves[0], own.rests[0] + sign * overlay.good
    axis.plot(at, way, color=style.PRIOR, lw=2.4, zorder=1)


def _marked(axis: Axes, data: Marked, colour: str) -> None:
    axis.plot(data.time, data.travel, color=colour, lw=1.1)
    look = {"color": colour, "ls": "", "zorder": 4}
    axis.plot(*data.moves, marker="v", ms=6, **look)
    filled = {} if data.timed else {"mfc": "white"}
    axis.plot(*data.switching, marker="o", ms=5, **look, **filled)
    if data.points:
        axis.plot(*zip(*data.points, strict=True), marker="s", ms=3, **look)
    for level in data.rests:
        axis.axhline(level, color=colour, lw=0.6, ls="--", zorder=1)


def _below(axis: Axes, panel: Panel, colours: dict[str, str], labels: PanelLabels) -> None:
    """Differences from the good record, and in words where they are too large."""
    begins = {each.phase: each.moves[0] for each in panel.curves}
    difference(axis, panel.overlays, colours, begins)
    left = [each for each in panel.overlays if each.leaves]
    first = min(left, key=lambda each: each.leaves[0]) if left else panel.overlays[0]
    name = f"{first.phase}: " if first.phase and left else ""
    look = {"color": style.WARNING if left else "black", "loc": "left", "fontsize": 8}
    axis.set_title(style.within(name + first.words, _WIDTH - 1.0, 8.0), **look)
    axis.set_ylabel(labels.difference)


_SHARES = {_panel: 1.7, _beside: 0.6, _below: 1.0}
"""Heights of what is drawn of a panel, beside each other."""
