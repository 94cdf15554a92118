"""Measured records: from columns of a file to curves on the time grid of the model.

Puts readings in mm and ms, leaves out samples that no sensor can give, finds the motion asked for
and its landmarks, and says what is doubtful; rejects a record with a reason if it cannot be used.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach(
    __name__,
    submod_attrs={
        "copies": ["is_copy"],
        "edges": ["Contact"],
        "export": ["write_curve"],
        "grid": ["Grid"],
        "landmarks": ["main_motion"],
        "measured": ["Measured", "Reading", "measure_curve"],
        "noise": ["noise_remarks"],
        "places": ["Place", "places_of"],
        "raw": ["Raw", "read_raws", "taken_apart"],
        "reader": ["Record", "open_curves", "read_curves", "read_record"],
        "running": ["filled"],
        "scale": ["Scale"],
        "segments": ["Course"],
        "shape": [
            "SHAPE_STEP",
            "SHAPE_TIMES",
            "Shape",
            "effective_noise",
            "median_units",
            "normalise",
            "shape_of",
        ],
    },
)
