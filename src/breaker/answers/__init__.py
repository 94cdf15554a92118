"""What one call infers of the records of one drive: judged, in words, as tables, trees and JSON.

Networks of a family of drives infer the parameters of each operation; all else is measured. Where
limits are given, they are judged by both.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach(
    __name__,
    submod_attrs={
        "answer": ["FACTS", "Answer", "Given"],
        "inferred": ["infer_drive"],
        "judgement": ["judged"],
        "operations": ["read_operations"],
        "changed": ["VERDICT_WORDS", "Compared", "changes", "compare", "measured_changes"],
        "drawn": ["Curve", "Shown", "shown"],
        "trees": ["tree"],
        "documents": ["document", "table_of"],
        "visited": ["visits_document", "visits_in_words"],
        "words": ["in_words"],
    },
)
