"""The condition of the drive at single operations: how probably each limit is exceeded.

From the posterior of the operation alone, with its correlations: of the motion that a limit is
about, and of both motions together where they agree. What came before is for trends.
"""

from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr
from tqdm import tqdm

from breaker.decisions.fusion import APART, Fused, Pair, fuse
from breaker.mechanism import NAMES, Limit, evaluate
from breaker.model import Model, generator

__all__ = ["agreement", "align", "condition", "usable"]


def align(parts: Sequence[xr.Dataset], operations: np.ndarray) -> xr.Dataset:
    """Return the operations of given numbers of one motion, from chunks that hold them.

    Numbers that no chunk has are there as missing values, not accepted.
    """
    whole = xr.concat(parts, dim="operation", join="exact", combine_attrs="override")
    whole = whole.sel(operation=whole.operation.isin(operations))
    kept = whole[["travel", "draws", "accepted", "resolved", "log_evidence"]]
    flags = ("accepted", "resolved")
    filled = kept.reindex(
        operation=operations, fill_value={name: False for name in flags} | {"travel": np.nan}
    )
    return filled.assign({name: filled[name].astype(bool) for name in flags})


def usable(data: xr.Dataset) -> np.ndarray:
    """Say which operations have an exact posterior, ``(o,)``; the best so far does not count."""
    found = np.isfinite(data.draws.values).all(axis=(1, 2))
    return data.accepted.values & data.resolved.values & found


def condition(
    models: Mapping[str, Model],
    data: Mapping[str, xr.Dataset],
    limits: Sequence[Limit],
    correction: Mapping,
    seed: int,
) -> xr.Dataset:
    """Judge operations by their own posteriors.

    Args:
        models: Joint model of each motion.
        data: What ``align`` returns, of each motion, for the same operations.
        limits: Limits of these motions.
        correction: The section ``correction`` of the configuration.
        seed: Seed of the configuration.

    Returns:
        Dataset over ``operation``, ``limit`` and ``evidence``, "own" (of the limit's motion) and
        "both": ``probability`` and ``marginal`` that a limit is exceeded, nan where there is no
        posterior, and ``undefined``. Of the operations: ``log_agreement``, ``apart``, ``agree``,
        ``why_not_fused``, and ``median (operation, parameter)`` of both motions together.
    """
    operations = next(iter(data.values())).operation.values
    present = {motion: usable(each) for motion, each in data.items()}
    fused = _fuse_all(models, data, present, correction, seed)
    draws = {m: np.asarray(d.draws.values, dtype=np.float64) for m, d in data.items()}
    both = np.stack([each.draws for each in fused])
    sources = {
        "own": [
            (draws[limit.motion][..., : len(NAMES)], present[limit.motion]) for limit in limits
        ],
        "both": [(both, np.isfinite(both).all(axis=(1, 2)))] * len(limits),
    }
    shape = (len(operations), len(limits), len(sources))
    found = {name: np.full(shape, np.nan) for name in ("probability", "marginal", "undefined")}
    for k, of_limits in enumerate(sources.values()):
        for j, (limit, (values, there)) in enumerate(zip(limits, of_limits, strict=True)):
            exceedance = _exceedance(limit, values[there])
            for name, each in zip(found, exceedance, strict=True):
                found[name][there, j, k] = each
    log_agreement = np.array([each.log_agreement for each in fused])
    return xr.Dataset(
        {name: (("operation", "limit", "evidence"), each) for name, each in found.items()}
        | {
            "log_agreement": ("operation", log_agreement),
            "apart": ("operation", np.array([each.apart for each in fused])),
            "agree": ("operation", log_agreement > 0),
            "why_not_fused": ("operation", np.array([each.reason for each in fused], dtype=str)),
            "median": (("operation", "parameter"), np.quantile(both, 0.5, axis=1)),
        },
        coords={
            "operation": operations,
            "limit": [limit.name for limit in limits],
            "words": ("limit", [limit.words for limit in limits]),
            "evidence": list(sources),
            "parameter": list(NAMES),
        },
    )


def _exceedance(limit: Limit, draws: np.ndarray):
    """Probabilities of a limit for draws ``(o, d, p)``, three arrays ``(o,)``."""
    o, d, p = draws.shape
    values = evaluate(limit.quantities, draws.reshape(-1, p), limit.motion)
    return limit.exceedance(values.reshape(o, d, len(limit.parts)))


def _fuse_all(
    models: Mapping[str, Model],
    data: Mapping[str, xr.Dataset],
    present: Mapping[str, np.ndarray],
    correction: Mapping,
    seed: int,
) -> list[Fused]:
    first = next(iter(data.values()))
    nothing = np.full((first.sizes["draw"], len(NAMES)), np.nan)
    result = []
    operations = first.operation.values
    for i in tqdm(range(len(operations)), desc="fusing", mininterval=5, unit="operation"):
        if len(models) < 2 or not all(there[i] for there in present.values()):
            result.append(Fused(nothing, np.nan, np.nan, "not both motions are there"))
            continue
        records = {m: data[m].travel.values[i].astype(np.float64) for m in models}
        draws = {m: data[m].draws.values[i].astype(np.float64) for m in models}
        evidence = float(sum(data[m].log_evidence.values[i] for m in models))
        rng = generator(seed, "fusion", int(operations[i]))
        result.append(fuse(Pair(models), records, draws, evidence, correction, rng))
    return result


def agreement(condition: xr.Dataset, baseline: int) -> float:
    """Return the share of the first operations in which both motions agree; nan if none tells."""
    first_ones = condition.isel(operation=slice(0, baseline))
    far = first_ones.apart.values >= APART
    tells = np.isfinite(first_ones.log_agreement.values) | far
    return float(first_ones.agree.values[tells].mean()) if tells.any() else float("nan")
