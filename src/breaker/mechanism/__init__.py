"""The drive: its seven parameters, exact travel curves, derived quantities, and limits on them.

Parameters have names, units and an order. Curves come from the matrix exponential, without a step
error; touch time, speeds and wipe are computed from them. No sensor and no inference here.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach(
    __name__,
    submod_attrs={
        "compiling": ["compiled"],
        "conditions": [
            "HURRYING",
            "PRESSED",
            "PRESSING",
            "RELEASING",
            "pressed",
            "pressed_half_space",
            "rate_bound",
            "why_not_pressed",
        ],
        "curves": ["Motion", "blocks", "rest_position", "sensitivity", "too_fast", "travel"],
        "limits": ["Limit", "entries_of_type", "from_list"],
        "numerals": ["in_digits", "in_p"],
        "parameters": [
            "FORCE",
            "GAP",
            "MOTIONS",
            "NAMES",
            "ONSET",
            "PARAMETERS",
            "Parameter",
            "is_logarithmic",
            "outputs",
            "prior_sds",
            "split",
        ],
        "quantities": [
            "QUANTITIES",
            "Quantity",
            "check_fact",
            "check_quantity",
            "evaluate",
            "quantities_of",
        ],
        "sources": ["SOURCES", "Reader"],
        "size": ["UNIT", "Size", "powers"],
        "speeds": ["EVENTS", "SPEEDS", "Point", "Speed", "speeds_of"],
    },
)
