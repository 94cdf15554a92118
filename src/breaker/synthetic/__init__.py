"""Simulated drives whose truth is known, to test everything else.

A family of drives that are richer than the model, what the model leaves out of them, and the
simulated endurance test, one of them, which wears out and writes CSV files; simulated lives until
failure with scores for change points, and control charts beside them; and drives of the family on
which trends and alarms are judged.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach(
    __name__,
    submod_attrs={
        "calibration": ["WIDENINGS", "calibrate"],
        "control_charts": ["directed"],
        "detectors": ["compare_detectors", "of_records", "score_alarms"],
        "dialects": ["ANGLES", "DIALECTS", "Dialect"],
        "drive": ["Drive", "Elements", "Stop"],
        "evaluation": ["follow_lives"],
        "failure_times": ["true_lives"],
        "family": ["Family"],
        "family_bank": ["shapes", "simulate_family"],
        "family_training": ["members_of", "open_family", "rows_of", "sample_rows"],
        "high_voltage": ["CHANNELS", "HIGH_VOLTAGE", "write_exports"],
        "judged": ["Reading", "family_of"],
        "judged_lives": ["judge_lives"],
        "judged_power": ["judge_power"],
        "judged_scores": ["score_lives", "score_power"],
        "learning": ["ensemble", "learn"],
        "measuring": ["measure_drives", "own_quantities"],
        "rigs": ["Rig"],
        "round_trip": ["through_files"],
        "scores": ["score"],
        "truth": ["truth_of"],
        "watching": ["Watch"],
    },
)
