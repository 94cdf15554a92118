"""What rules and scripts of the workflow share: configuration and start of a job.

Also which modules a script depends on, so that a change runs the right steps again. Snakemake
imports this room before every job, so it imports torch and numba only when they are used.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach(
    __name__,
    submod_attrs={
        "code": ["modules_of"],
        "configuration": ["check", "chosen_network", "load", "merge", "read"],
        "jobs": ["missing_packages", "set_threads", "start"],
        "magnitudes": ["UNLIKE"],
        "operations": ["chunks_of", "recorded_source"],
        "sources": ["ConfigurationError", "refuse"],
    },
)
