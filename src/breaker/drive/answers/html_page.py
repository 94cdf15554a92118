"""A report as one page of HTML that needs nothing beside it."""

from base64 import b64encode
from collections.abc import Sequence
from html import escape

from breaker.drive.answers.report_tables import Cell, Table
from breaker.drive.answers.test_report import Report

_STYLE = """
body { font: 14px "DejaVu Sans", Arial, sans-serif; max-width: 60em; margin: 2em auto; }
table { border-collapse: collapse; margin: 0.4em 0; }
th, td { padding: 0.15em 0.7em; text-align: right; border-bottom: 1px solid #ddd; }
th:first-child, td:first-child { text-align: left; }
.good { color: #1b7837; } .bad { color: #b2182b; font-weight: bold; }
.doubt { color: #b35806; } .faint { color: #777; }
.note { color: #555; font-size: 12px; margin: 0.1em 0; } img { width: 100%; }
"""


def report_page(report: Report, pictures: Sequence[bytes], title: str = "Test report") -> str:
    """Return a report as HTML, with pictures as PNG in it.

    >>> "<h1>Test report</h1>" in report_page(Report([], [], Cell("pass"), [], []), [])
    True
    """
    plate = "".join(f"<tr><td>{escape(k)}</td><td>{escape(v)}</td></tr>" for k, v in report.plate)
    images = (b64encode(each).decode("ascii") for each in pictures)
    return "\n".join(
        [
            '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">',
            '<meta name="generator" content="breaker report">',
            f"<title>{title}</title>\n<style>{_STYLE}</style>\n</head>\n<body>",
            f"<h1>{title}</h1>\n<table>{plate}</table>",
            *(f'<p class="bad">{escape(each)}</p>' for each in report.warnings),
            f'<p class="{report.verdict.tone}">{escape(report.verdict.text)}</p>',
            *map(_table, report.tables),
            *(f'<img alt="curves" src="data:image/png;base64,{each}">' for each in images),
            "</body>\n</html>\n",
        ]
    )


def _table(table: Table) -> str:
    head = "".join(f"<th>{_lines(each)}</th>" for each in table.head)
    rows = "".join(f"<tr>{''.join(map(_cell, row))}</tr>\n" for row in table.rows)
    notes = "".join(f'<p class="note">{escape(each)}</p>\n' for each in table.notes)
    grid = f"<table>\n<tr>{head}</tr>\n{rows}</table>\n" if table.rows else ""
    return f"<h2>{escape(table.title)}</h2>\n{grid}{notes}"


def _cell(cell: Cell) -> str:
    return f'<td class="{cell.tone}">{_lines(cell.text)}</td>'


def _lines(text: str) -> str:
    return escape(text).replace("\n", "<br>")
