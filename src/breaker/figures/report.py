"""Pages of a test report: first what is measured, in tables, then the curves of all channels."""

from collections.abc import Iterator, Sequence
from textwrap import wrap

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from breaker.documents.parts import Remark, Section, Table, tone_of, words_in
from breaker.drive.answers.picture_data import Marked, Panel
from breaker.drive.answers.test_report import Report
from breaker.figures import style
from breaker.figures.overlay import difference

_WIDTH, _HEIGHT = 8.27, 11.69  # inches, A4
_POINTS = 72.0  # in an inch
_MARGIN = 40.0  # points
_EDGE = _MARGIN / _POINTS  # inches
_ROOM = _WIDTH * _POINTS - 2 * _MARGIN  # points
_LETTER = 0.6  # width of one over its size, on average
_SIZES = (5.2, 7.6)  # points, of letters in tables
_NOTE = 6.6  # points, of letters in notes
_PAGES, _SCALES = 2, (1.0, 0.93, 0.86, 0.8)  # that are wanted, and how small letters get for them
_GAP = 1.9  # letters between columns
_LEADING = 1.42  # of lines, over the size of letters
_LINES = 1.2  # the same within a cell
_TONES = {"good": "#1B7837", "bad": style.WARNING, "doubt": "#B35806", "faint": "#777777"}
_CHANNELS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
_PANELS = {False: 4, True: 3}  # on a page, without and with a reference
_TALLEST, _PANEL_LEAST = 3.6, 1.7  # inches, of a panel
_NAME = 28  # letters of a channel's name
_LEGEND = 0.19  # inches, of a line of the legend
_KEYS_WIDE = 118  # letters in a line of the legend
_KEYS = (
    "▼ first motion   ● touch or parting, measured   ○ by the model   ■ points of speeds   "
    "- - rests"
)


class _Sheet:
    """Pages that are written from above, each begun where the one before is full."""

    def __init__(self, scale: float = 1.0) -> None:
        self.scale = scale
        self.pages: list[list[dict]] = [[]]  # texts, as ``Figure.text`` takes them
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

    def paragraph(self, text: str, size: float, **look: object) -> None:
        """Write a text in lines, and go on below it."""
        for line in wrap(text, int(_ROOM / (size * _LETTER))):
            self.room(size * _LEADING)
            self.write(_MARGIN, line, size, **look)
            self.y += size * _LEADING

    def part(self, part: Section | Table | Remark | str) -> None:
        """Write a part of a document with its title and notes."""
        if isinstance(part, str | Remark):
            self.paragraph(words_in(part), _SIZES[1] * self.scale)
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
            size, places = _columns(table, self.scale)
            head = [_stacked(each) for each in table.head]
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
            self.paragraph(note, _NOTE * self.scale, color="#555555")
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


def _stacked(text: str) -> str:
    """A head of a column, a long one in lines."""
    lines = (wrap(style.shortened(line, _NAME), _NAME // 2) for line in text.split("\n"))
    return "\n".join(line for part in lines for line in part)


def _height(row: Sequence[str], size: float) -> float:
    lines = max(cell.count("\n") + 1 for cell in row)
    return size * (_LEADING + _LINES * (lines - 1)) + (2.0 if lines > 1 else 0.0)


def _columns(table: Table, scale: float) -> tuple[float, list[float]]:
    """Size of letters, and where columns are: the first begins, the others end there."""
    cells = [row for row in table.rows if not isinstance(row, str | Remark)]
    cells += [[_stacked(each) for each in table.head]] if table.head else []
    widths = [
        max(len(line) for text in column for line in text.split("\n"))
        for column in zip(*cells, strict=True)
    ]
    letters = sum(widths) + _GAP * (len(widths) - 1)
    size = min(max(_ROOM / (letters * _LETTER), _SIZES[0]), _SIZES[1] * scale)
    wide = [width * size * _LETTER for width in widths]
    gap = (_ROOM - sum(wide)) / max(1, len(widths) - 1)
    gap = min(max(gap, 0.0), 4.0 * _GAP * size * _LETTER)
    places, end = [_MARGIN], _MARGIN + wide[0]
    for each in wide[1:]:
        end += gap + each
        places.append(end)
    return size, places


def pages(report: Report) -> Iterator[Figure]:
    """Draw the pages of a report, one after the other: A4, upright; two where they hold it."""
    for scale in _SCALES:
        sheet = _sheet(report, scale)
        drawn = _parts(report.panels)
        free = _HEIGHT - (sheet.y + _MARGIN) / _POINTS
        total = len(sheet.pages) + len(drawn)
        joined = total > _PAGES and bool(drawn) and free > _PANEL_LEAST * len(drawn[0]) + 1.0
        total -= joined
        if total <= _PAGES:
            break
    name = ", ".join(v for _, v in report.plate[:3] if v != "not stated")  # whose it is
    parts = [(texts, (), 0.0) for texts in sheet.pages] + [((), each, 0.0) for each in drawn]
    if joined:
        last = len(sheet.pages) - 1
        parts[last : last + 2] = [(sheet.pages[last], drawn[0], sheet.y / _POINTS)]
    for number, part in enumerate(parts, start=1):
        yield _page(*part, f"{name} · page {number} of {total}")


def _sheet(report: Report, scale: float) -> _Sheet:
    """All that is written, with letters of tables and notes at a scale."""
    sheet = _Sheet(scale)
    sheet.paragraph(report.title, 15.0, weight="bold")
    sheet.y += 4.0
    _plate(sheet, report.plate)
    *warnings, verdict = report.summary
    for each in warnings:
        sheet.paragraph(each, 8.5, weight="bold", color=_TONES[tone_of(each)])
    color = _TONES.get(tone_of(verdict), "black")
    sheet.paragraph(verdict, 9.5, weight="bold", color=color)
    sheet.y += 6.0
    for part in report.parts:
        sheet.part(part)
    return sheet


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
        yield _page((), part, 0.0)


def _parts(panels: Sequence[Panel]) -> list[Sequence[Panel]]:
    """Panels by page."""
    most = _PANELS[any(each.overlays for each in panels)]
    return [panels[k : k + most] for k in range(0, len(panels), most)]


def _foot(figure: Figure, text: str) -> None:
    look = {"fontsize": 7.0, "color": _TONES["faint"], "ha": "center", "va": "bottom"}
    short = style.literal(style.shortened(text, 100))
    figure.text(0.5, 0.5 * _MARGIN / (_HEIGHT * _POINTS), short, **look)


@style.styled
def _page(texts: Sequence[dict], panels: Sequence[Panel], below: float, foot: str = "") -> Figure:
    """Draw texts, and panels below each other so many inches from the upper edge."""
    figure = Figure(figsize=(_WIDTH, _HEIGHT), layout="constrained" if panels else None)
    for each in texts:
        figure.text(**each)
    if panels:
        _curves(figure, panels, max(below, _EDGE))
    _foot(figure, foot)
    return figure


def _curves(figure: Figure, panels: Sequence[Panel], top: float) -> None:
    """Draw panels below each other, each with its marks and differences."""
    phases = list(dict.fromkeys(each.phase for panel in panels for each in panel.curves))
    colours = {phase: _CHANNELS[k % len(_CHANNELS)] for k, phase in enumerate(phases)}
    below = any(each.overlays for each in panels)
    free = _HEIGHT - top - _EDGE - _legend(figure, colours, below)
    used = min(free, _TALLEST * (1.5 if below else 1.0) * len(panels)) / _HEIGHT
    box = (_EDGE / _WIDTH, 1.0 - top / _HEIGHT - used, 1.0 - 2 * _EDGE / _WIDTH, used)
    figure.get_layout_engine().set(rect=box)
    ratios = [r for each in panels for r in ([1.7, 1.0] if each.overlays else [2.7])]
    axes = list(figure.subplots(len(ratios), 1, height_ratios=ratios, squeeze=False).flat)
    left = iter(axes)
    for panel in panels:
        last = axis = next(left)
        _panel(axis, panel, colours)
        if panel.overlays:
            last = next(left)
            last.sharex(axis)
            _below(last, panel, colours)
        last.set_xlabel("time of the record (ms)", fontsize=8)
    for axis in axes:
        axis.tick_params(labelsize=7.5)
        axis.yaxis.label.set_size(8.0)


def _legend(figure: Figure, colours: dict[str, str], below: bool) -> float:
    """Draw the legend at the foot of a page, and return its height, inches."""
    names = [style.literal(style.shortened(phase or "record", _NAME)) for phase in colours]
    keys = [style.line_key(*each) for each in zip(names, colours.values(), strict=True)]
    keys += [style.line_key("reference", style.PRIOR, lw=2.4)] if below else []
    columns = max(1, _KEYS_WIDE // (max(map(len, [*names, "reference"])) + 7))
    look = {"fontsize": 8.0, "loc": "lower center", "ncols": columns}
    figure.legend(handles=keys, bbox_to_anchor=(0.5, 1.1 * _EDGE / _HEIGHT), **look)
    figure.text(0.5, 0.95 * _EDGE / _HEIGHT, _KEYS, fontsize=7.5, ha="center", va="bottom")
    return _LEGEND * (2 - -len(keys) // columns)


def _panel(axis: Axes, panel: Panel, colours: dict[str, str]) -> None:
    for each in panel.overlays:
        _reference(axis, panel, each)
    for each in panel.curves:
        _marked(axis, each, colours[each.phase])
    axis.set_title(style.within(panel.title, _WIDTH - 1.0, 9.0), loc="left", fontsize=9)
    axis.set_ylabel(style.TRAVEL)
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


def _below(axis: Axes, panel: Panel, colours: dict[str, str]) -> None:
    """Differences from the good record, and in words where they are too large."""
    begins = {each.phase: each.moves[0] for each in panel.curves}
    difference(axis, panel.overlays, colours, begins)
    left = [each for each in panel.overlays if each.leaves]
    first = min(left, key=lambda each: each.leaves[0]) if left else panel.overlays[0]
    name = f"{first.phase}: " if first.phase and left else ""
    look = {"color": style.WARNING if left else "black", "loc": "left", "fontsize": 8}
    axis.set_title(style.within(name + first.words, _WIDTH - 1.0, 8.0), **look)
