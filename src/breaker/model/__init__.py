"""The joint probability model of a drive and its record: prior, mechanism and sensor.

``Model`` combines the three and evaluates their exact joint density. Banks of simulated curves,
the Fisher information of a record, and Gaussian approximations of its likelihood follow from it.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach(
    __name__,
    submod_attrs={
        "bank": ["Bank", "open_bank", "simulate"],
        "fisher": ["limit_over_prior", "linearise"],
        "joint": ["Model"],
        "plausibility": ["distance", "excess", "principal_components"],
        "prior": ["Prior"],
        "randomness": ["generator", "seed_integer", "systematic"],
        "saved": ["ModelFileError", "SavedModel", "open_model", "write_model"],
        "sensor": ["Sensor", "grid"],
    },
)
