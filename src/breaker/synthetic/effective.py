"""Effective values of the stand-in: the model's parameters that fit its curves best.

A richer mechanism has no true value of the model's parameters. Its *effective* values are the
posterior mode given its noise-free curve: what an exact inference would find, free of noise. The
prior is part of it, for some directions are hardly identified and would run away without it.
"""

from collections.abc import Sequence

import numpy as np
import xarray as xr
from scipy.optimize import least_squares

from breaker.mechanism import NAMES, outputs
from breaker.mechanism import travel as model_travel
from breaker.model import Prior, Sensor, jacobian
from breaker.records import main_motion
from breaker.synthetic.rigs import Rig

__all__ = ["effective_values", "fit"]


def fit(
    prior: Prior, sensor: Sensor, motion: str, curve: np.ndarray, start: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Fit the model to a curve by its posterior mode, the zero integrated.

    Args:
        prior: Prior of the parameters.
        sensor: Grid and errors of the model's sensor.
        motion: "closing" or "opening".
        curve: Travel, ``(t,)``, mm.
        start: Standardised outputs to start from, ``(q,)``.

    Returns:
        Standardised outputs at the mode, ``(q,)``, and what is left of the curve after the model
        and its most probable zero, ``(t,)``, mm.

    Raises:
        RuntimeError: If the fit does not converge.
    """
    p, t = len(NAMES), len(curve)

    def unpack(z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        onset = sensor.onset_sd * z[p:] if sensor.infers_onset else np.zeros(1)
        return prior.destandardise(z[None, :p]), onset

    def model(z: np.ndarray) -> np.ndarray:
        theta, onset = unpack(z)
        return model_travel(theta, sensor.times, motion, onset=onset).travel[0]

    def residual(z: np.ndarray) -> np.ndarray:
        return np.concatenate([sensor.whiten(model(z) - curve), z])

    def slopes(z: np.ndarray) -> np.ndarray:
        slope = jacobian(prior, sensor, motion, *unpack(z))[0]
        return np.vstack([sensor.whiten(slope.T).T, np.eye(z.size)])

    # Within 6 prior sd, so that no step leaves what the simulator can do.
    found = least_squares(residual, start, slopes, bounds=(-6.0, 6.0), xtol=1e-8, max_nfev=200)
    if not found.success:
        raise RuntimeError(f"the fit of a {motion} curve did not converge: {found.message}")
    left = curve - model(found.x)
    share = t * sensor.zero_sd**2 / (sensor.noise_sd**2 + t * sensor.zero_sd**2)
    return found.x, left - share * left.mean()


def effective_values(
    rig: Rig, prior: Prior, sensor: Sensor, motion: str, operations: Sequence[int]
) -> xr.Dataset:
    """Return the effective values at stages of the rig's life, without its scatter and noise.

    Returns:
        Dataset over ``stage`` (coordinate ``operation``) and ``output``: ``effective`` in physical
        units; ``setting (stage, worn)``, the rig's own worn settings; and what the model leaves of
        the curve, in noise sd: ``main_largest`` and ``main_rms`` in the main motion,
        ``end_largest`` after it.
    """
    names = [output.name for output in outputs(sensor.infers_onset)]
    worn = list(rig.settings["wear"]["change"])
    z, rows = np.zeros(len(names)), []
    for operation in operations:
        mechanism = rig.worn(operation, scatter=False)
        curve = mechanism.travel(motion, sensor.times)
        z, left = fit(prior, sensor, motion, curve, z)
        main = main_motion(curve, sensor.times, motion)
        size = np.abs(left) / sensor.noise_sd
        rows.append(
            {
                "effective": np.append(
                    prior.destandardise(z[: len(NAMES)]), sensor.onset_sd * z[len(NAMES) :]
                ),
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
        attrs={"motion": motion},
    )
