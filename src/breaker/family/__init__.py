"""Networks trained on a family of rich drives, read without torch: levels, and changes.

``open_network`` reads one; ``Seen`` is a record as they see it.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach(
    __name__,
    submod_attrs={
        "changes": ["APART", "ChangeDraws", "Changes", "agreement_of", "change_outputs", "worn"],
        "inputs": [
            "Basis",
            "Seen",
            "change_inputs",
            "level_inputs",
            "units_of",
            "without_onset",
        ],
        "means": ["SCATTER_DIRECTIONS", "Mean", "see_change", "see_mean"],
        "measured": ["see", "seen_of"],
        "levels": ["EVENTS", "LevelDraws", "Levels", "level_outputs", "outputs_there"],
        "membership": ["PARTS", "Match", "Membership", "choose_family", "distances"],
        "network": ["Network"],
        "saved": ["is_of", "open_network", "write_network"],
    },
)
