"""The reference drive: the model of the shipped defaults, from which those of other sizes follow.

Its prior and sensor are in the header of the shipped model file, and so is what the model leaves
out; neither needs torch.
"""

from breaker.model.joint import Model
from breaker.model.saved import open_model
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
    with open_model(model_file(motion), remedy="install the package again") as saved:
        left_out = saved.discrepancy if scale else None
        return Model.from_settings(saved.settings, left_out, scale)
