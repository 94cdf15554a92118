"""Measured records: from the files of an instrument to curves on the time grid of the model.

Finds the operation number of a file, reads and checks its columns, and rejects it with a reason if
it cannot be used. Finds landmarks of a record: first motion, main motion, raw operating time.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach(
    __name__,
    submod_attrs={
        "acceptance": ["check_folder", "checked_text"],
        "bends": ["seen_touch", "speed_along"],
        "files": ["RejectedCurveError", "printable", "read_bytes"],
        "listing": ["ENDINGS", "fingerprint", "list_operations", "record_files"],
        "inspection": ["InspectedMotion", "InspectionError", "Proposal", "inspect_file"],
        "manifest": ["ABOUT", "MANIFEST", "Operation", "known_about"],
        "proposal": ["propose_manifest"],
        "export": ["write_curve"],
        "wording": ["overlay_of", "report_of"],
        "reader": ["open_curves", "read_curves", "require_any"],
        "landmarks": ["main_motion", "raw_time"],
        "settings": ["FORMAT", "TO_MM", "TO_MS", "complete"],
    },
)
