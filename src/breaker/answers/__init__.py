"""What one call answers: of the records of a drive, of its visits, and of a type of breaker.

Networks of a family of drives infer the parameters of each operation; all else is measured. Where
limits are given, they are judged by both; words, tables, trees and JSON render the answer. The
prior of a type comes from records of some of its breakers, each fitted by itself.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach(
    __name__,
    submod_attrs={
        "alike": ["judged_today", "unlike"],
        "answer": ["FACTS", "Answer", "Given"],
        "between": ["compared"],
        "identity": ["swapped"],
        "stated": ["date_in", "date_of", "dates_in_words"],
        "inferred": ["infer_drive", "infer_means"],
        "judgement": ["judged"],
        "operations": ["read_operations"],
        "pages": ["report_page"],
        "poles": ["PoleFile", "operations_of_poles", "phases_in_names"],
        "tables": ["Cell", "Table"],
        "reported": ["Report", "report_of"],
        "overlays": ["TOLERANCE", "Overlay", "overlaid"],
        "changed": [
            "VERDICT_WORDS",
            "changes",
            "compare",
            "measured_changes",
            "mechanism_changes",
        ],
        "drawn": ["Curve", "Marked", "Panel", "Shown", "shown"],
        "trees": ["tree"],
        "documents": ["document", "table_of"],
        "visited": ["differ_in_words", "visits_document", "visits_in_words", "visits_said"],
        "words": ["in_words"],
        # The prior of a type.
        "checks": ["check_fitted"],
        "cursors": ["explained"],
        "fitted": [
            "DESIGN",
            "SWINGING",
            "FittedPrior",
            "fit_type",
            "precision_of",
            "reference_of",
            "swings_back",
            "wear_allowance",
        ],
        "recorded": ["Recorded", "list_breakers", "read_breakers"],
        "spread": ["Fit", "Spread", "find_spread", "fit_breaker"],
        "writing": ["overlay_of", "overlay_text", "report"],
    },
)
