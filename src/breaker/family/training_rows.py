"""A bank of a family of drives, rows of it, and draws of networks for held-out drives."""

from collections.abc import Sequence
from dataclasses import fields
from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr

from breaker.common.zarr_store import open_store
from breaker.family.change_network import Changes, plausible_wear
from breaker.family.change_rows import ChangeRows
from breaker.family.level_network import Levels
from breaker.family.level_rows import BankRows, LevelRows
from breaker.model.parameters import NAMES
from breaker.paper.calibration import coverage, judge_ranks, ranks


def rows_of(kind: str, bank: xr.Dataset, like: Levels | Changes | None = None) -> BankRows:
    """Return rows of "levels" or "changes", scaled as those that a network was trained on."""
    frozen = {} if like is None else {each.name: getattr(like, each.name) for each in fields(like)}
    return {each.kind: each for each in (LevelRows, ChangeRows)}[kind](bank, frozen)


def sample_rows(
    network: Levels | Changes,
    rows: BankRows,
    source: str,
    draws: int,
    rng: np.random.Generator,
    **sensor,
) -> xr.Dataset:
    """Draw from the posteriors of one record of each motion of each drive.

    Args:
        rows: Drives, in the scales of the network.
        source: Which motions there are: "closing", "opening" or "both".
        sensor: As of the ``unscaled`` of the rows.

    Returns:
        ``draws (curve, draw, output)`` and ``truth (curve, output)``: parameters, or their changes
        in percent, and events, in durations. What is exactly 0 has a random order, by a jitter of
        a billionth of a scale. Changes beyond any wear are left out; ``withheld`` counts them.
    """
    n = len(rows)
    motions = np.tile([source != "opening", source != "closing"], (n, 1))
    x, y, there, units = rows.unscaled(np.arange(n), rng, motions=motions, **sensor)
    told = there.any(axis=0)
    x, y, units = (each[(there == told).all(axis=1)] for each in (x, y, units))
    features = network.network.features(x)
    values = np.stack(
        [network.network.sample(each[None], told, draws, rng)[0] for each in features]
    )
    values = network.centre + network.scale * values
    kept = np.ones(len(values), dtype=bool)
    if rows.kind == "changes":
        kept = plausible_wear(values[..., : len(NAMES)])
    values, y, units = values[kept], y[kept], units[kept]

    def physical(outputs: np.ndarray, units: np.ndarray) -> np.ndarray:
        jitter = 1e-9 * network.scale * rng.standard_normal(outputs.shape)
        return rows.physical(outputs + units + np.array(rows.atoms) * jitter)[..., told]

    return xr.Dataset(
        {
            "draws": (("curve", "draw", "output"), physical(values, units[:, None])),
            "truth": (("curve", "output"), physical(y, units)),
        },
        {"output": np.array(rows.names)[told]},
        {"withheld": int((~kept).sum())},
    )


def open_family(shards: Sequence[str | Path], held_out: int) -> tuple[xr.Dataset, xr.Dataset]:
    """Read the shards of a bank, and set its last drives aside.

    Raises:
        ValueError: If that leaves no drives to train on.
    """
    bank = xr.concat([open_store(each) for each in shards], dim="drive", combine_attrs="override")
    rest = bank.sizes["drive"] - held_out
    if rest <= 0:
        raise ValueError(
            f"the bank has {rest + held_out} drives, and {held_out} are held out: none is left to "
            "train on; raise family.drives"
        )
    return bank.isel(drive=slice(rest)), bank.isel(drive=slice(rest, None))


def family_quality(data: xr.Dataset, *, log: bool) -> pd.DataFrame:
    """Judge a network of a family on held-out drives: one row an output.

    Args:
        data: What ``sample_rows`` returns.
        log: Whether parameters are judged by their logarithms.

    Returns:
        Columns ``output``, ``calibration_p`` and ``calibrated``, all outputs together at 99 %,
        ``coverage_90``, ``contraction`` (1 - mean square error of the posterior mean over the
        variance of the truth, nan where that does not vary), ``rms_error`` and ``half_width``, the
        median half width of 90 % intervals; both in the scale that an output is judged in.
    """
    draws, truth = data.draws.values.copy(), data.truth.values.copy()
    logs = log & np.isin(data.output.values, NAMES)
    for values in (draws, truth):
        values[..., logs] = np.log(values[..., logs])
    found = ranks(draws, truth)
    judged = judge_ranks(found, data.sizes["draw"], alpha=0.01)
    error = draws.mean(axis=1) - truth
    low, high = np.quantile(draws, [0.05, 0.95], axis=1)
    spread = truth.var(axis=0)
    spread[spread < 1e-12] = np.nan  # round-off of what does not vary
    return pd.DataFrame(
        {
            "output": data.output.values,
            "calibration_p": judged.p_values,
            "calibrated": ~judged.outside,
            "coverage_90": coverage(found, data.sizes["draw"], levels=[0.9])[0],
            "contraction": 1.0 - np.square(error).mean(axis=0) / spread,
            "rms_error": np.sqrt(np.square(error).mean(axis=0)),
            "half_width": np.median(high - low, axis=0) / 2.0,
        }
    )
