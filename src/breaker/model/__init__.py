"""The joint density of a drive's unknowns and its record: prior, mechanism and sensor as one.

``Model`` is what everything above is handed; simulated banks, the information in a record and
the limit of what can be known come from it. All of it exact, in float64.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach(
    __name__,
    submod_attrs={
        "bank": ["open_bank", "simulate"],
        "fisher": ["jacobian", "limit_over_prior"],
        "joint": ["Model"],
        "likelihoods": ["climb", "information", "pool"],
        "plausibility": ["distance", "excess", "principal_components"],
        "prior": ["Prior"],
        "randomness": ["generator", "seed_integer"],
        "sensor": ["Sensor", "grid"],
    },
)
