"""Trends of the parameters over the operations, changes of wear, and the remaining life.

The first operations give the reference. Bayesian online change-point detection with straight lines
follows, one operation after another; its state is stored, so that later operations continue it.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach(
    __name__,
    submod_attrs={
        "events": ["Event"],
        "hypotheses": ["confirmed"],
        "learned": ["Learned", "by_phase"],
        "lifetime": ["lives_of", "quantiles_of", "remaining_life"],
        "measured": ["follow_measured"],
        "series": ["Series", "likelihood", "series_of"],
        "state": ["State"],
        "steps": ["IN_ROW"],
        "trend": ["Follower"],
        "trust": ["trust_in"],
    },
)
