"""A fleet: many breakers of a few types, each answered as one alone is, and set side by side.

Each breaker's records are inferred and compared, or its life is followed. What breakers of a type
have in common is learned from all of them, so that an odd one stands out; and all are ranked by
what is due.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach(
    __name__,
    submod_attrs={
        "chunks": ["breaker_chunks"],
        "drives": ["stored"],
        "examined": ["Examined", "examine"],
        "members": ["Member", "members_of"],
        "page": ["fleet_page"],
        "ranked": ["FLEET", "fleet_table", "learn_types", "type_table"],
        "states": ["DIFFERENT", "FLEET_STATES"],
        "types": ["Drawn", "TypeOfBreaker", "learn_type"],
    },
)
