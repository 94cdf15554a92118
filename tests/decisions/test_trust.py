"""How far the model can be trusted: a table and a sentence, of sizes made up for it."""

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from breaker.decisions.trust import beyond_family, trust_sentence, trust_table
from breaker.mechanism.parameters import MOTIONS

PHASES = ("start", "main motion", "end")
QUANTILES = [0.05, 0.5, 0.95, 0.99]
DRIVE = {"closing": [0.4, 0.2, 1.1], "opening": [0.1, 0.25, 0.6]}
FAMILY = {"closing": [0.5, 0.3, 1.0], "opening": [0.2, 0.3, 0.7]}
WIDTHS = [("slow", "touch_time", "ms", 0.12, 0.03), ("rubbed", "mu", "1", 0.2, 0.1)]


def trust_of(motions, drive=1.0, family=1.0, widths=WIDTHS):
    """Medians of the tables above; the quantiles beside them are 0.8, 1.2 and 1.5 times as much."""
    spread = np.array([0.8, 1.0, 1.2, 1.5])
    sizes = [np.concatenate([table[m] for m in motions]) for table in (DRIVE, FAMILY)]
    names, quantities, units, half, right = zip(*widths, strict=True)
    return xr.Dataset(
        {
            "drive": (("phase", "quantile"), drive * sizes[0][:, None] * spread),
            "family": (("phase", "quantile"), family * sizes[1][:, None] * spread),
            "half_width": ("part", np.array(half)),
            "half_width_if_right": ("part", np.array(right)),
        },
        {
            "phase": [f"{motion} {each}" for motion in motions for each in PHASES],
            "quantile": QUANTILES,
            "part_limit": ("part", list(names)),
            "part_quantity": ("part", list(quantities)),
            "part_unit": ("part", list(units)),
        },
    )


def test_table_has_a_row_per_phase_and_per_part_of_a_limit():
    together = trust_table([trust_of(MOTIONS)])
    assert together.kind.tolist() == ["difference"] * 6 + ["limit"] * 2
    row = together[together.name == "opening end"].iloc[0]
    np.testing.assert_allclose(
        row[["drive_5", "drive_median", "drive_95"]].astype(float), [0.48, 0.6, 0.72]
    )
    np.testing.assert_allclose(row[["family_median", "family_99"]].astype(float), [0.7, 1.05])
    assert row.unit == "mm"
    limit = together.iloc[-2]
    assert limit[["name", "quantity", "unit"]].tolist() == ["slow", "touch_time", "ms"]
    assert limit[["half_width", "half_width_if_right"]].tolist() == [0.12, 0.03]
    apart = trust_table(
        [trust_of(["closing"], widths=WIDTHS[:1]), trust_of(["opening"], widths=WIDTHS[1:])]
    )
    pd.testing.assert_frame_equal(apart, together)


def test_sentence_of_a_usual_drive():
    """At most two lines of the page, of 120 characters."""
    said = trust_sentence(trust_table([trust_of(MOTIONS)]))
    assert said == (
        "Trust: the drive differs from the model by up to 1.1 mm, as drives of the family do. "
        "This costs slow most: touch_time ±0.12 ms instead of ±0.03 ms."
    )
    assert len(said) < 2 * 120
    free = trust_of(["opening"], widths=[("rubbed", "mu", "1", 0.1, 0.1)])
    said = trust_sentence(trust_table([free]))
    assert said.endswith("by up to 0.6 mm, as drives of the family do.")
    unitless = trust_of(["opening"], widths=WIDTHS[1:])
    assert "mu ±0.2 instead of ±0.1." in trust_sentence(trust_table([unitless]))


def test_sentence_of_a_drive_beyond_the_family():
    """The lower ends of start and end, 0.32 and 0.88, are above 0.3 and 0.6 of the family."""
    unusual = trust_of(["closing"])
    unusual["family"][0] *= 0.4
    unusual["family"][2] *= 0.4
    table = trust_table([unusual])
    assert beyond_family(table) == ["closing start", "closing end"]
    said = trust_sentence(table)
    assert "1.1 mm, more than 99 % of drives of the family do: closing start, closing end" in said
    assert "No interval can be relied on." in said
    assert len(said) < 2 * 120


@pytest.mark.parametrize(
    ("size", "said"),
    [
        (0.0, "Trust: the model is taken for right; whether it is was not asked."),
        (np.nan, "Trust: unknown."),
    ],
)
def test_sentence_without_a_difference(size, said):
    nothing = [(*name, np.nan, np.nan) for *name, _, _ in WIDTHS]
    data = trust_of(MOTIONS, drive=size, family=size, widths=nothing)
    assert trust_sentence(trust_table([data])) == said
