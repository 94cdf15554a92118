"""From files of an instrument to records on the model's grid, or to a named reason why not.

Which operation a file is, its columns as numbers, its checks, and landmarks of a record: first
motion, main motion, raw operating time. Knows nothing of the model of the drive.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach(
    __name__,
    submod_attrs={
        "files": ["csv_files", "list_curves"],
        "reader": ["open_curves", "read_curves", "require_any", "write_curve"],
        "landmarks": ["main_motion", "raw_time"],
    },
)
