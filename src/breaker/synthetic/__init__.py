"""Simulated drives whose truth is known, to test everything else.

A family of drives that are richer than the model, and the simulated endurance test, one of them,
which wears out and writes CSV files.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach(
    __name__,
    submod_attrs={
        "dialects": ["ANGLES", "DIALECTS", "Dialect"],
        "drive": ["Drive", "Elements", "Stop"],
        "failure_times": ["failures", "true_lives"],
        "family": ["Family"],
        "family_bank": ["shapes", "simulate_family"],
        "family_networks": ["train_network"],
        "family_training": ["open_family", "rows_of", "sample_rows"],
        "rigs": ["Rig"],
        "round_trip": ["through_files"],
        "truth": ["truth_of"],
    },
)
