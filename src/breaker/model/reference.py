"""The reference drive: the model of the shipped defaults, from which those of other sizes follow.

Its prior and sensor are in the header of the shipped model file, and so is what the model leaves
out; neither needs torch.
"""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from breaker.mechanism import Size
from breaker.model.joint import Model
from breaker.model.saved import open_model
from breaker.shipped import model_file

__all__ = ["configured_model", "reference_model"]


def reference_model(motion: str, scale: float = 1.0) -> Model:
    """Return the joint model of the reference drive.

    Args:
        motion: "closing" or "opening".
        scale: Scale of what the model leaves out.

    Example:
        >>> reference_model("closing").sensor.samples
        151
    """
    with open_model(model_file(motion), remedy="install the package again") as saved:
        left_out = saved.discrepancy if scale else None
        return Model.from_settings(saved.settings, left_out, scale)


def configured_model(config: Mapping, motion: str) -> Model:
    """Return the joint model of a configuration, with the learned error of the reference drive.

    The learned error is scaled by the section ``size``, put on the times of the configuration's
    sensor, and known by the parameters as its prior standardises them.

    Args:
        config: The configuration: ``prior``, ``sensor``, ``size`` and ``endurance.discrepancy``.
        motion: "closing" or "opening".
    """
    own = Model.from_settings({**config, "motion": motion})
    scale, size = config["endurance"]["discrepancy"], Size(**config.get("size", {}))
    if not scale:
        return own
    reference = reference_model(motion, scale).sized(size)
    known, times = reference.sensor.discrepancy, reference.sensor.times

    def on_grid(rows: np.ndarray) -> np.ndarray:
        return np.stack([np.interp(own.sensor.times, times, row) for row in rows])

    mean = np.interp(own.sensor.times, times, known.mean)
    left_out = replace(known, mean=mean, slopes=on_grid(known.slopes), factor=on_grid(known.factor))
    ratio = own.prior.log_sds / reference.prior.log_sds
    offset = reference.prior.standardise(own.prior.medians)
    return own.leaving_out(left_out.known_as(np.diag(ratio), offset))
