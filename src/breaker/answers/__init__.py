"""What one call infers of the records of one drive: judged, in words, as tables, trees and JSON.

An *answer* is the dataset of a motion that ``posterior.infer_exactly`` returns, with the quantities
an engineer knows, how far the model can be wrong, and the limits beside the parameters.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach(
    __name__,
    submod_attrs={
        "judgement": ["with_limits", "with_quantities", "with_trust"],
        "operations": ["Record", "read_operations"],
        "changed": ["VERDICT_WORDS", "Compared", "changes", "compare", "measured_changes"],
        "drawn": ["shown"],
        "trees": ["tree"],
        "plain": ["document"],
        "rows": ["table_of"],
        "visited": ["visits_document", "visits_in_words"],
        "words": ["in_words"],
    },
)
