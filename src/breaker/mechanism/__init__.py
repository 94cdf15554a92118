"""The drive itself: its seven parameters, exact travel curves, and what is read from them.

Parameters with names, units and order; curves and their derivatives without a step error;
quantities such as touch time and speed; limits on them. Knows nothing of sensors or inference.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach(
    __name__,
    submod_attrs={
        "arguments": ["blocks"],
        "curves": ["Motion", "rest_position", "travel"],
        "limits": ["Limit", "from_list"],
        "parameters": [
            "MOTIONS",
            "NAMES",
            "ONSET",
            "PARAMETERS",
            "Parameter",
            "is_logarithmic",
            "outputs",
            "prior_sds",
            "split",
        ],
        "quantities": ["evaluate"],
        "sensitivities": ["sensitivity"],
    },
)
