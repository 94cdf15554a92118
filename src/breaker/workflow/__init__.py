"""What rules and scripts share: configuration, the start of a job, stores, the code of a step.

Read by Snakemake before every job, so light to import: no torch, numba or xarray until needed.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach(
    __name__,
    submod_attrs={
        "code": ["modules_of"],
        "configuration": ["ConfigurationError", "chosen_network", "load", "merge", "read"],
        "jobs": ["start"],
        "stores": ["describe", "save"],
    },
)
