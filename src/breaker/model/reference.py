"""The reference drive: the model of the shipped defaults, from which those of other sizes follow.

Its prior and sensor are in the header of the shipped model file, and so is what the model leaves
out; neither needs torch.
"""

import json

import numpy as np
from safetensors import safe_open

from breaker.model.discrepancy import Discrepancy
from breaker.model.joint import Model
from breaker.shipped import model_file

__all__ = ["reference_model"]


def reference_model(motion: str, scale: float = 1.0) -> Model:
    """Return the joint model of the reference drive.

    Args:
        motion: "closing" or "opening".
        scale: Scale of what the model leaves out.

    Example:
        >>> reference_model("closing").sensor.samples
        151
    """
    with safe_open(str(model_file(motion)), framework="numpy") as file:
        settings = json.loads(file.metadata()["settings"])
        parts = [file.get_tensor(f"discrepancy.{name}") for name in ("mean", "slopes", "factor")]
    left_out = Discrepancy(*(each.astype(np.float64) for each in parts))
    return Model.from_settings(settings, left_out if scale else None, scale)
