"""Simulated drives whose truth is known, to test everything else.

The simulated endurance test (a mechanism richer than the model, which wears out and writes CSV
files), simulated lives until failure with scores for change points, and control charts beside them.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach(
    __name__,
    submod_attrs={
        "drive": ["Drive", "Elements", "Stop"],
        "evaluation": ["follow_lives"],
        "failure_times": ["failures"],
        "family": ["Family"],
        "learning": ["ensemble", "learn"],
        "rigs": ["Rig", "truth_of"],
        "round_trip": ["through_files"],
        "scores": ["score"],
    },
)
