"""How a drive changes over its operations: one pass of Bayesian lines and change points.

The first operations give the reference; then levels, slopes, changes and the remaining life
follow operation by operation, from a state that is stored and gone on from.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach(
    __name__,
    submod_attrs={
        "lifetime": ["remaining_life"],
        "series": ["likelihood"],
        "trend": ["Follower", "Series", "State", "series_of"],
    },
)
