"""A life in the drive's own curves, followed to decisions.

Records become coordinates in units of the drive's own scatter; one tracker follows these and
whatever is measured; networks of a family read off what has changed since new. From the followed
life come one record per limit and operation and, by when to service, a decision; tables hold these,
and words are rendered from the tables.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach(
    __name__,
    submod_attrs={
        "coordinates": ["Coordinates"],
        "events": ["Event"],
        "followed": ["follow_curves", "follow_life"],
        "forecast": ["Forecast", "Future"],
        "path": ["Block", "Change", "Path"],
        "readout": ["Readout", "name_set"],
        "series": ["Motion", "Series", "series_of"],
        "tracker": ["Tracker"],
        # Decisions.
        "dates": ["days_per_operation"],
        "states": ["STATES", "standing"],
        "tables": [
            "CHANGES",
            "DECISIONS",
            "LIMITS",
            "change_table",
            "decide",
            "limit_table",
            "operation_metadata",
        ],
        "words": [
            "about",
            "headline",
            "in_percent",
            "limit_words",
            "opening",
            "since_new",
            "span",
            "trust",
        ],
    },
)
