"""Decisions: how a drive stands to its limits, by when to service, and the first page.

From a followed life to one record per limit and operation; tables hold these, and words are
rendered from the tables.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach(
    __name__,
    submod_attrs={
        "dates": ["days_per_operation"],
        "page": ["opening"],
        "states": ["STATES", "standing"],
        "tables": [
            "CHANGES",
            "DECISIONS",
            "LIMITS",
            "change_table",
            "decide",
            "known_of",
            "limit_table",
        ],
        "wording": ["about", "in_percent", "span"],
        "words": ["headline", "limit_words", "since_new", "trust"],
    },
)
