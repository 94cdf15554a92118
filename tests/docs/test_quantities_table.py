"""The table of quantities in docs/method.md has each of the catalogue, its unit and its meaning."""

from pathlib import Path

from breaker.model.quantities import OF_STROKE, quantities, speeds_of

PAGE = Path(__file__).parents[2] / "docs" / "method.md"
TITLE = "## Quantities: one word, one meaning"


def rows_of(text):
    """Cells of the rows below the title, by name."""
    section = text.split(TITLE)[1].split("\n## ")[0]
    rows = [line.strip("|").split("|") for line in section.splitlines() if line.startswith("|")]
    return {cells[0].strip(" `"): [each.strip() for each in cells[1:]] for cells in rows[2:]}


def said(each):
    """The meaning, after the word that sentences have for it, where the meaning lacks it."""
    word = getattr(each, "word", "")
    return each.meaning if word in each.meaning else f"{word}: {each.meaning}"


def test_the_table_has_every_quantity_as_the_catalogue_has_it():
    known = list(quantities(speeds_of(OF_STROKE)).values())
    rows = rows_of(PAGE.read_text(encoding="utf-8"))
    assert [*rows] == [*(each.name for each in known), "simultaneity"]
    for each in known:
        unit, meaning, how, elsewhere = rows[each.name]
        assert (unit, meaning) == (each.unit, said(each)), each.name
        of = getattr(each, "of", "")
        assert how == ("measured" if "record" in of else "inferred"), each.name
        assert elsewhere


def test_a_row_that_the_catalogue_denies_is_found():
    text = PAGE.read_text(encoding="utf-8").replace("| `stroke` | mm |", "| `stroke` | cm |")
    assert rows_of(text)["stroke"][0] != quantities()["stroke"].unit
