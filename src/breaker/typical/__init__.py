"""The prior of a type of breaker, from records of some of its breakers.

Each breaker is fitted by itself, its spread among breakers is estimated, and medians and log-sds of
a prior follow, with checks of them and the lines of configuration that hold them.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach(
    __name__,
    submod_attrs={
        "checks": ["Finding", "check_fitted"],
        "fits": ["Fit", "fit_breaker"],
        "fitted": ["FittedPrior", "fit_type", "precision_of", "reference_of", "room_for_wear"],
        "recorded": ["Recorded", "read_breakers"],
        "spread": ["Spread", "find_spread"],
        "writing": ["overlay_of", "overlay_text", "report"],
    },
)
