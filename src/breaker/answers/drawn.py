"""What a picture of an answer shows of one record, beside the answer itself."""

import numpy as np
import xarray as xr

from breaker.mechanism import NAMES, evaluate
from breaker.model import Model, generator
from breaker.posterior import predict

__all__ = ["shown"]

_SWITCHING = {"closing": "touch_time", "opening": "part_time"}
_SD = 1.96  # of a normal, half its 95 % interval


def shown(answer: xr.Dataset, model: Model, *, seed: int, most: int = 30) -> xr.Dataset:
    """Return what is drawn of a motion: its first record in detail, the posterior of all.

    Args:
        answer: Of a motion, with quantities and trust.
        model: Its joint model.
        seed: Seed of predictions and of draws of the prior.
        most: Records of which draws are shown.

    Returns:
        The records with a posterior, dims ``operation``, ``draw``, ``output``, with ``draws`` and
        ``prior (draw, parameter)``; of the first of them over ``time``, mm: ``record``, ``median``,
        ``lower`` and ``upper`` of its predictions, ``residual`` and ``left_out`` as in
        ``with_trust``, and ``family_lower`` and ``family_upper`` of what the model leaves out of
        drives of the family with these parameters; and ``switching (draw)``, the time of touch or
        parting, ms. Without a posterior there are no operations.
    """
    there = answer.isel(operation=np.isfinite(answer.draws.values).all(axis=(1, 2)))
    there = there.isel(operation=slice(most))
    if not there.sizes["operation"]:
        return there
    first = there.isel(operation=0)
    values = first.draws.values.astype(np.float64)
    record = first.travel.values.astype(np.float64)
    predicted = predict(model, record[None], values[None], seed=seed).isel(curve=0)
    mean = np.broadcast_to(model.shift(values), (len(values), record.size)).mean(axis=0)
    known = model.sensor.discrepancy
    spread = _SD * (known.sd if known is not None else np.zeros_like(mean))
    theta = values[:, : len(NAMES)]
    onset = values[:, len(NAMES)] if model.sensor.infers_onset else 0.0
    switching = evaluate([_SWITCHING[model.motion]], theta, model.motion)[:, 0] + onset
    rng = generator(seed, "prior draws")
    prior = model.prior.sample(len(values), rng)
    mm = {"unit": "mm"}
    curves = {
        **{name: predicted[name].values for name in ("median", "lower", "upper")},
        **{"record": record, "residual": first.residual.values, "left_out": first.left_out.values},
        **{"family_lower": mean - spread, "family_upper": mean + spread},
    }
    return there.drop_vars("median").assign(
        prior=(("draw", "parameter"), prior),
        switching=("draw", switching, {"unit": "ms"}),
        **{name: ("time", each, mm) for name, each in curves.items()},
    )
