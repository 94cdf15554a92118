"""How far the model can be trusted on a drive: as a table, and in a sentence."""

from collections.abc import Sequence

import numpy as np
import pandas as pd
import xarray as xr

__all__ = ["trust_sentence", "trust_table"]

_PLACES = {"start": "at the start", "main motion": "in the main motion", "end": "at the end"}
_SIZES = ["drive_5", "drive_median", "drive_95", "family_median", "family_99"]
_WIDTHS = ["half_width", "half_width_if_right"]


def trust_table(parts: Sequence[xr.Dataset]) -> pd.DataFrame:
    """Return how far the drive is from the model, and what each limit loses to it.

    Args:
        parts: What ``wear.trust_in`` returns, of each source that limits are read from.

    Returns:
        Columns ``kind``, ``name``, ``quantity`` and ``unit``. Rows of kind "difference", one per
        phase of a motion, have quantiles of the root mean square of the difference from the model:
        of the drive, ``drive_5``, ``drive_median`` and ``drive_95``, and of drives of the family,
        ``family_median`` and ``family_99``. Rows of kind "limit", one per part of a limit, have
        half the 90 % interval of its quantity in the first operations, ``half_width``, and the same
        if the model were right, ``half_width_if_right``.
    """
    rows = []
    for data in parts:
        drive = data.drive.sel(quantile=[0.05, 0.5, 0.95]).transpose("phase", "quantile").values
        family = data.family.sel(quantile=[0.5, 0.99]).transpose("phase", "quantile").values
        for phase, *sizes in zip(data.phase.values, drive, family, strict=True):
            values = dict(zip(_SIZES, np.concatenate(sizes), strict=True))
            rows.append({"kind": "difference", "name": str(phase), "unit": "mm"} | values)
    for data in parts:
        for k in range(data.sizes["part"]):
            one = data.isel(part=k)
            named = {"name": one.part_limit.item(), "quantity": one.part_quantity.item()}
            widths = {name: one[name].item() for name in _WIDTHS}
            rows.append({"kind": "limit", "unit": one.part_unit.item()} | named | widths)
    return pd.DataFrame(rows, columns=["kind", "name", "quantity", "unit", *_SIZES, *_WIDTHS])


def trust_sentence(table: pd.DataFrame) -> str:
    r"""Return the sentence of the first page, from what ``trust_table`` returns.

    Example:
        >>> sizes = dict(zip(_SIZES, [0.3, 0.4, 0.5, 0.6, 2.0]))
        >>> one = {"kind": "difference", "name": "opening end"} | sizes
        >>> table = pd.DataFrame([one]).assign(half_width=0.1, half_width_if_right=0.1)
        >>> print(trust_sentence(table).replace(", as", ",\nas"))
        Trust: opening differs from the model by 0.4 mm at the end,
        as drives of the family do (0.6).
    """
    sizes = table[table.kind == "difference"]
    if (sizes.family_99 == 0.0).all():
        return "Trust: the model is taken for right; whether it is was not asked."
    if sizes.drive_median.isna().all():
        return "Trust: unknown."
    motions = sizes.name.str.split(" ", n=1, expand=True)
    told = [
        _difference(str(motion), sizes[motions[0] == motion].assign(phase=motions[1]))
        for motion in motions[0].unique()
    ]
    return f"Trust: {'; '.join(told)}.{_loss(table[table.kind == 'limit'])}"


def _difference(motion: str, rows: pd.DataFrame) -> str:
    """Say by how much a motion differs from the model, and whether that is usual."""
    said = [f"{row.drive_median:.2g} mm {_PLACES[row.phase]}" for row in rows.itertuples()]
    usual = ", ".join(f"{each:.2g}" for each in rows.family_median)
    beyond = rows[rows.drive_5 > rows.family_99]
    than = "as drives of the family do"
    if len(beyond):
        than = f"{_and([_PLACES[each] for each in beyond.phase])} more than drives of the family do"
    return f"{motion} differs from the model by {_and(said)}, {than} ({usual})"


def _loss(limits: pd.DataFrame) -> str:
    """Say which limit loses most; nothing if none loses anything that can be seen."""
    factor = (limits.half_width / limits.half_width_if_right).fillna(0.0)
    if not (factor > 1.05).any():
        return ""
    row = limits.loc[factor.idxmax()]
    unit = "" if row.unit == "1" else f" {row.unit}"
    return (
        f" This costs {row['name']} most: {row.quantity} is known to ±{row.half_width:.2g}{unit}, "
        f"not to ±{row.half_width_if_right:.2g}{unit} (90 %)."
    )


def _and(words: Sequence[str]) -> str:
    *first, last = words
    return f"{', '.join(first)} and {last}" if first else last
