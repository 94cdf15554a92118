"""Checks of posteriors on simulated records whose truth is known.

Ranks of the truth with simultaneous bands, z-scores, contraction and recovery. Arrays go in, arrays
and tables come out; also the table of the numbers that the texts of the project state.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach(
    __name__,
    submod_attrs={
        "calibration": [
            "Verdict",
            "calibration_p_values",
            "coverage",
            "family_p_value",
            "ranks",
            "verdict",
        ],
        "comparison": [
            "VERDICTS",
            "exactness_words",
            "examples",
            "identifiability_words",
            "percent",
            "plus_minus",
            "reached",
        ],
        "diagnostics": [
            "Recovery",
            "Scores",
            "correlation",
            "pointwise_band",
            "recovery",
            "scores",
        ],
        "network_table": ["row"],
        "numbers": ["numbers_of_all", "numbers_of_decisions", "numbers_of_motion"],
        "qualities": ["quality", "words"],
    },
)
