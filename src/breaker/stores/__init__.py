"""Zarr stores: the attributes of every result, how it is written, opened and verified.

Also how any file that a command writes appears: whole or not at all. Every room that keeps results
uses it, so it depends on none.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach(
    __name__,
    submod_attrs={
        "store": ["StoreError", "describe", "open_store", "save"],
        "replacing": ["whole"],
    },
)
