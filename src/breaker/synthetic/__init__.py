"""Drives whose truth is known: the stand-in of the endurance test, and simulated lives.

A richer mechanism than the model that wears out and writes files; whole lives of the model's own
drives with the scores of what is made of them; records through files and back.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach(
    __name__,
    submod_attrs={
        "effective": ["effective_values"],
        "evaluation": ["follow_lives"],
        "failure_times": ["failures"],
        "rigs": ["Rig"],
        "round_trip": ["through_files"],
        "scores": ["score"],
    },
)
