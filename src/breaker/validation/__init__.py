"""Checks of posteriors on simulated records whose truth is known.

Ranks of the truth with simultaneous bands, z-scores, contraction and recovery. Arrays go in, arrays
and tables come out; also the table of the numbers that the texts of the project state.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach(
    __name__,
    submod_attrs={
        "bands": ["calibration_p_values"],
        "calibration": [
            "Calibration",
            "coverage",
            "family_p_value",
            "judge_draws",
            "judge_ranks",
            "ranks",
        ],
        "comparison": [
            "KNOWLEDGE",
            "exactness_words",
            "examples",
            "identifiability_words",
            "percent",
            "plus_minus",
            "reached",
        ],
        "diagnostics": [
            "PriorCheck",
            "Recovery",
            "Scores",
            "contraction",
            "contraction_words",
            "correlation",
            "pairs_words",
            "prior_check",
            "recovery",
            "recovery_words",
            "scores",
        ],
        "evolution": ["blocks_of", "held", "moved", "truth_in_blocks"],
        "numbers": [
            "MotionResults",
            "numbers_of_all",
            "numbers_of_life",
            "numbers_of_motion",
        ],
        "tables": [
            "family_quality",
            "parameters_of",
            "quality",
            "quality_words",
            "with_width",
        ],
    },
)
