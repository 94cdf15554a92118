"""What a picture of an answer shows of one record, beside the answer itself."""

import numpy as np
import xarray as xr

from breaker.mechanism import NAMES, QUANTITIES, evaluate
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
        The records with a posterior, dims ``operation``, ``draw`` and ``shown``, the parameters and
        the wipe, with ``shown_symbol``, ``shown_unit`` and ``shown_meaning``: ``values_shown`` and
        ``prior_shown (draw, shown)``. Of the first of them over ``time``, mm: ``record``,
        ``median``, ``lower`` and ``upper`` of its predictions, ``residual`` and ``left_out`` as in
        ``with_trust``, and ``family_lower`` and ``family_upper`` of what the model leaves out of
        drives of the family with these parameters; and ``switching (draw)``, the time of touch or
        parting, ms. Without a posterior there are no operations.
    """
    there = answer.isel(operation=np.isfinite(answer.draws.values).all(axis=(1, 2)))
    there = there.isel(operation=slice(most))
    if not there.sizes["operation"]:
        return there
    draws = there.draws.values.astype(np.float64)
    theta, wipe = draws[..., : len(NAMES)], there.quantity_draws.sel(quantity=["wipe"]).values
    prior = model.prior.sample(draws.shape[1], generator(seed, "prior draws"))
    prior_wipe = evaluate(["wipe"], prior, model.motion)
    about = [QUANTITIES[name] for name in (*NAMES, "wipe")]
    onset = draws[0, :, len(NAMES)] if model.sensor.infers_onset else 0.0
    switching = evaluate([_SWITCHING[model.motion]], theta[0], model.motion)[:, 0] + onset
    mm = {"unit": "mm"}
    return (
        there[["p_value", "misfit", "prior_p_value", "far_from_prior", "file"]]
        .assign(
            values_shown=(("operation", "draw", "shown"), np.concatenate([theta, wipe], axis=-1)),
            prior_shown=(("draw", "shown"), np.concatenate([prior, prior_wipe], axis=-1)),
            switching=("draw", switching, {"unit": "ms"}),
            **{
                n: ("time", each, mm)
                for n, each in _curves(there.isel(operation=0), model, seed).items()
            },
        )
        .assign_coords(
            time=model.sensor.times,
            shown=[each.name for each in about],
            shown_symbol=("shown", [each.symbol for each in about]),
            shown_unit=("shown", [each.unit for each in about]),
            shown_meaning=("shown", [each.meaning for each in about]),
        )
    )


def _curves(one: xr.Dataset, model: Model, seed: int) -> dict[str, np.ndarray]:
    """Curves of a record, ``(t,)``, mm."""
    values, record = (one[name].values.astype(np.float64) for name in ("draws", "travel"))
    predicted = predict(model, record[None], values[None], seed=seed).isel(curve=0)
    mean = np.broadcast_to(model.shift(values), (len(values), record.size)).mean(axis=0)
    known = model.sensor.discrepancy
    spread = _SD * known.sd if known is not None else np.zeros_like(mean)
    return {
        **{name: predicted[name].values for name in ("median", "lower", "upper")},
        **{"record": record, "residual": one.residual.values, "left_out": one.left_out.values},
        **{"family_lower": mean - spread, "family_upper": mean + spread},
    }
