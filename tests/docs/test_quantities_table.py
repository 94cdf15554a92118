"""The table of quantities in docs/method.md has each of the catalogue, its unit and its meaning."""

import re
from pathlib import Path

import numpy as np

from breaker.drive.simulation.drive_family import Family
from breaker.quantities.catalogue import quantities
from breaker.quantities.moving_mass import MASS_QUANTITIES
from breaker.quantities.speeds import OF_STROKE, speeds_of

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
    known = [*quantities(speeds_of(OF_STROKE)).values(), *MASS_QUANTITIES]
    rows = rows_of(PAGE.read_text(encoding="utf-8"))
    assert [*rows] == [*(each.name for each in known), "simultaneity"]
    for each in known:
        unit, meaning, how, elsewhere = rows[each.name]
        assert (unit, meaning) == (each.unit, said(each)), each.name
        of = getattr(each, "of", "")
        assert how == ("measured" if "record" in of else "inferred"), each.name
        assert elsewhere


def test_times_say_their_zero_and_speeds_their_zone():
    for each in quantities(speeds_of(OF_STROKE)).values():
        if each.unit == "ms":
            zero = "trigger|first motion|release|10 % of the way|from 10 to 90|first contact touch"
            assert re.search(zero, each.meaning), each.name
        assert bool(each.zone) == (each.unit == "m/s")
        assert each.zone in each.meaning


def test_a_row_that_the_catalogue_denies_is_found():
    text = PAGE.read_text(encoding="utf-8").replace("| `stroke` | mm |", "| `stroke` | cm |")
    assert rows_of(text)["stroke"][0] != quantities()["stroke"].unit


def ways_at_contact(drive):
    """Ways of a drive to its closed rest at touch and at parting, over its wipe."""
    time, found = np.append(np.arange(0.0, 150.0, 0.01), 1000.0), []
    for motion in ("closing", "opening"):
        travel, at = drive.operate(motion, time)
        closed = travel[-1] if motion == "closing" else travel[0]
        wipe = abs(travel[-1] - travel[0]) - drive.value("L")
        found.append((closed - np.interp(at, time, travel)) / wipe)
    return found


def test_the_page_states_how_far_ways_at_the_contact_are_from_the_wipe(prior, defaults):
    family, rng = Family(prior, defaults["family"]), np.random.default_rng(3)
    shares = {"elastic": [], "held": [], "sliding": []}
    for _ in range(60):
        drive = family.new(rng)
        shares[drive.elements.contact].append(ways_at_contact(drive))
    text = " ".join(PAGE.read_text(encoding="utf-8").split())
    low, middle, high = np.rint(100.0 * np.nanquantile(shares["elastic"], [0.1, 0.5, 0.9], axis=0))
    held = np.rint(100.0 * np.nanmedian(shares["held"], axis=0))
    assert middle[1] < middle[0] < 100.0
    for said in (
        f"{len(shares['elastic'])} had an elastic contact",
        f"median of {middle[0]:.0f} % of the wipe left (10 to 90 % of drives: {low[0]:.0f} to "
        f"{high[0]:.0f} %), and at parting it had gone {middle[1]:.0f} % of it ({low[1]:.0f} to "
        f"{high[1]:.0f} %)",
        f"Of {len(shares['held'])} held contacts",
        f"were {held[0]:.0f} % and {held[1]:.0f} %",
    ):
        assert said in text
