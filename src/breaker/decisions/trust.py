"""How far the model can be trusted on a drive: as a table, and in a sentence."""

from collections.abc import Sequence

import numpy as np
import pandas as pd
import xarray as xr

from breaker.decisions.wording import in_percent

__all__ = ["beyond_family", "trust_in_limits", "trust_sentence", "trust_table", "untold"]

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
    """Return the sentence of the first page, from what ``trust_table`` returns.

    Example:
        >>> sizes = dict(zip(_SIZES, [0.3, 0.4, 0.5, 0.6, 2.0]))
        >>> one = {"kind": "difference", "name": "opening end"} | sizes
        >>> table = pd.DataFrame([one]).assign(half_width=0.1, half_width_if_right=0.1)
        >>> trust_sentence(table)
        'Trust: the drive differs from the model by up to 0.4 mm, as drives of the family do.'
    """
    sizes = table[table.kind == "difference"]
    if (sizes.family_99 == 0.0).all():
        return "Trust: the model is taken for right; whether it is was not asked."
    if sizes.drive_median.isna().all():
        return "Trust: unknown."
    largest = f"up to {sizes.drive_median.max():.2g} mm"
    if unlike := beyond_family(table):
        where = f"more than 99 % of drives of the family do: {', '.join(unlike)}"
        said = f"{where}. No interval can be relied on"
    else:
        said = "as drives of the family do"
    loss = _loss(table[table.kind == "limit"])
    return f"Trust: the drive differs from the model by {largest}, {said}.{loss}"


def beyond_family(table: pd.DataFrame) -> list[str]:
    """Return the phases in which a drive differs from the model more than the family does."""
    sizes = table[table.kind == "difference"]
    return sizes.name[sizes.drive_5 > sizes.family_99].tolist()


def _loss(limits: pd.DataFrame) -> str:
    """Say which limit loses most; nothing if none loses anything that can be seen."""
    factor = (limits.half_width / limits.half_width_if_right).fillna(0.0)
    if not (factor > 1.05).any():
        return ""
    row = limits.loc[factor.idxmax()]
    return (
        f" This costs {row['name']} most: {row.quantity} {_known_to(row.half_width, row.unit)} "
        f"instead of {_known_to(row.half_width_if_right, row.unit)}."
    )


def _known_to(half_width: float, unit: str) -> str:
    return f"±{half_width:.2g}" + ("" if unit in ("", "1") else f" {unit}")


def untold(judged: xr.Dataset) -> list[list[str]]:
    """Return the limits that cannot be told after each operation, with their probability."""
    unknown, names = judged.state.values == "unknown", judged.limit.values
    told = []
    for row, probability in zip(unknown, judged.level_probability.values, strict=True):
        each = ((names[j], probability[j]) for j in np.flatnonzero(row))
        told.append([f"{n} ({in_percent(p) if p == p else 'nothing known'})" for n, p in each])
    return told


def trust_in_limits(
    judged: xr.Dataset, left: xr.Dataset, named: Sequence[str], table: pd.DataFrame
) -> list[str]:
    """Return how far each row of the decisions can be trusted, ``(o,)``.

    How well the quantities of its limit are known, half a 90 % interval; limits that cannot be
    told; phases in which the drive is unlike the family.

    Args:
        judged: What ``judge`` returns.
        left: What ``remaining`` returns, for the same operations.
        named: Limit of each row, empty without one, ``(o,)``.
        table: What ``trust_table`` returns.
    """
    halves = (left.value.sel(quantile=0.95) - left.value.sel(quantile=0.05)) / 2.0
    halves = halves.transpose("operation", "part").values
    of, quantities = left.part_limit.values, left.part_quantity.values
    units = left.part_unit.values
    unlike = [f"unlike the family: {', '.join(w)}" for w in [beyond_family(table)] if w]
    told = []
    for i, (name, doubts) in enumerate(zip(named, untold(judged), strict=True)):
        parts = [k for k in np.flatnonzero(of == name) if np.isfinite(halves[i, k])]
        known = [f"{quantities[k]} {_known_to(halves[i, k], units[k])}" for k in parts]
        cannot = [f"cannot tell: {', '.join(doubts)}"] if doubts else []
        told.append("; ".join([*([", ".join(known)] if known else []), *cannot, *unlike]))
    return told
