"""Effective values of the stand-in: the model's parameters that fit its curves best.

A richer mechanism has no true value of the model's parameters. Its *effective* values are the
posterior mode given its noise-free curve: what an exact inference would find, free of noise. The
prior is included, because some directions are hardly identified and would diverge without it.
"""

from collections.abc import Sequence

import numpy as np
import xarray as xr

from breaker.mechanism import NAMES
from breaker.model import Model, information, pool
from breaker.records import main_motion
from breaker.synthetic.rigs import Rig

__all__ = ["effective_values", "fit"]

_CONVERGED = 1e-3  # prior sd: a longer step to the mode is no fit


def fit(model: Model, curve: np.ndarray, start: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Fit the model to a curve by its posterior mode, the zero integrated.

    Args:
        model: Joint model of the motion.
        curve: Travel, ``(t,)``, mm.
        start: Standardised outputs to start from, ``(q,)``.

    Returns:
        Standardised outputs at the mode, ``(q,)``, and what is left of the curve after the model
        and its most probable zero, ``(t,)``, mm.

    Raises:
        RuntimeError: If the fit does not converge.
    """
    p, q, sensor = len(NAMES), len(start), model.sensor
    alone, onset = {model.motion: curve[None]}, np.append(start, 0.0)[p : p + 1]
    z = pool({model.motion: model}, alone, start[:p], {model.motion: onset})
    found = information(model, curve[None], z[None], onset)
    step = np.linalg.solve(np.eye(p) + found.matrix[0], found.slope[0] - z)
    if not np.abs(step).max() < _CONVERGED:
        raise RuntimeError(f"the fit of a {model.motion} curve did not converge")
    z = np.append(z, found.onset)[:q]
    left = curve - model.curves(model.destandardise(z[None]))[0]
    explained = sensor.samples * sensor.zero_sd**2
    return z, left - explained / (sensor.noise_sd**2 + explained) * left.mean()


def effective_values(rig: Rig, model: Model, operations: Sequence[int]) -> xr.Dataset:
    """Return the effective values at stages of the rig's life, without its scatter and noise.

    Returns:
        Dataset over ``stage`` (coordinate ``operation``) and ``output``: ``effective`` in physical
        units; ``setting (stage, worn)``, the rig's own worn settings; and what the model leaves of
        the curve, in noise sd: ``main_largest`` and ``main_rms`` in the main motion,
        ``end_largest`` after it.
    """
    sensor, names = model.sensor, model.names
    worn = list(rig.settings["wear"]["change"])
    z, rows = np.zeros(len(names)), []
    for operation in operations:
        mechanism = rig.worn(operation, scatter=False)
        curve = mechanism.travel(model.motion, sensor.times)
        z, left = fit(model, curve, z)
        main = main_motion(curve, sensor.times, model.motion)
        size = np.abs(left) / sensor.noise_sd
        rows.append(
            {
                "effective": model.destandardise(z),
                "setting": [getattr(mechanism, name) for name in worn],
                "main_largest": size[main].max(),
                "main_rms": np.sqrt(np.square(size[main]).mean()),
                "end_largest": size[~main].max(),
            }
        )
    dims = {"effective": ("stage", "output"), "setting": ("stage", "worn")}
    return xr.Dataset(
        {
            name: (dims.get(name, "stage"), np.array([row[name] for row in rows]))
            for name in rows[0]
        },
        coords={
            "operation": ("stage", list(operations)),
            "output": ("output", names),
            "worn": ("worn", worn),
        },
        attrs={"motion": model.motion},
    )
