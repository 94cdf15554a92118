"""Files of instruments: which of them is which operation, and the columns of numbers in them.

Finds the records of a folder, by its table of operations or by names that leave no doubt. Reads
texts, workbooks, COMTRADE and labelled arrays as the settings say, or says file, line and reason.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach(
    __name__,
    submod_attrs={
        "cells": ["EVENTS", "event_words"],
        "columns": ["Columns"],
        "dates": ["dates_of", "earlier"],
        "described": ["Description", "Part"],
        "formats": ["ENDINGS", "format_of", "is_text", "read_columns", "understood"],
        "grids": ["is_store"],
        "guards": ["RejectedCurveError", "printable", "read_bytes"],
        "lines": ["Lines", "cells_of"],
        "lexicon": ["LABELS", "SHARE_OF_STROKE", "STATED", "SYSTEMS", "TELLING"],
        "listing": [
            "fingerprint",
            "list_breakers",
            "list_fleet",
            "list_known",
            "list_once",
            "list_operations",
            "record_files",
        ],
        "manifest": [
            "ABOUT",
            "FILL_IN",
            "MANIFEST",
            "SWITCHING",
            "Operation",
            "metadata_names",
            "read_manifest",
        ],
        "motions": ["MOTION_OF", "motion_of", "motions_in"],
        "names": ["is_travel_name", "label_of", "split_unit", "unit_of"],
        "naming": ["natural"],
        "numbers": ["LARGEST_NUMBER", "MISSING", "is_number", "strict_numbers"],
        "opened": ["Files", "Opened", "as_opened"],
        "outgoing": ["on_terminal", "save_frame", "table_text", "wrapped"],
        "phases": [
            "COLUMN_PHASE",
            "IN_FILE",
            "LISTED",
            "PHASE",
            "channel_of",
            "listed_in",
            "phase_in",
        ],
        "preamble": ["Preamble", "preamble_of"],
        "printed": ["Printed"],
        "rates": ["RATES"],
        "proposal": ["propose_manifest"],
        "settings": ["FORMAT", "TO_MM", "TO_MS", "complete", "lacking"],
        "shown": ["MOST_COLUMNS", "Labelled", "check_size"],
        "spelling": ["bare", "usual_spelling"],
        "words": ["any_of", "by_words", "holds", "says"],
    },
)
