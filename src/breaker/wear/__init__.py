"""A life in the drive's own curves: the path of its wear, changes of it, and how long it may go on.

Records become coordinates in units of the drive's own scatter; one tracker follows these and
whatever is measured; networks of a family read off what has changed since new.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach(
    __name__,
    submod_attrs={
        "coordinates": ["Coordinates"],
        "events": ["Event"],
        "followed": ["follow_life"],
        "forecast": ["Forecast", "Future"],
        "path": ["KINDS", "Block", "Change", "Path"],
        "readout": ["Readout", "name_set"],
        "series": ["Motion", "Series", "series_of"],
        "tracker": ["Tracker"],
    },
)
