"""Networks trained on a family of rich drives, read without torch: levels, and changes.

``open_network`` reads one; ``NormalisedRecords`` is what networks see of records.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach(
    __name__,
    submod_attrs={
        "changes": [
            "LEAST_AGREEMENT",
            "ChangeDraws",
            "Changes",
            "agreement_of",
            "change_outputs",
            "plausible_wear",
        ],
        "inputs": [
            "Basis",
            "NormalisedRecords",
            "change_inputs",
            "level_inputs",
            "units_of",
            "without_onset",
        ],
        "means": [
            "SCATTER_DIRECTIONS",
            "Mean",
            "mean_and_change",
            "mean_record",
            "mean_with_scatter",
            "pace_of",
        ],
        "mechanisms": [
            "CHANGE_OF",
            "MECHANISMS",
            "WEARING",
            "mechanism_draws",
            "mechanism_outputs",
        ],
        "measured": ["network_record", "normalise_record", "stored_shape"],
        "levels": ["EVENTS", "LevelDraws", "Levels", "level_outputs", "outputs_there"],
        "membership": ["PARTS", "Match", "Membership", "choose_family", "distances"],
        "network": ["Network"],
        "operations": ["infer_operations"],
        "scatter": ["beside_usual"],
        "saved": ["open_network", "shipped_networks", "trained_on", "write_network"],
    },
)
