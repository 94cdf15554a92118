"""numpy, loaded as it is first used.

The plan of the workflow is made where nothing but Snakemake is installed, of modules that name
numpy and of which it uses what needs none. They take ``np`` from here.
"""

from typing import TYPE_CHECKING, Any


class _Numpy:
    def __getattr__(self, name: str) -> Any:
        import numpy

        value = getattr(numpy, name)
        setattr(self, name, value)  # found at once from now on
        return value


if TYPE_CHECKING:
    import numpy as np
else:
    np = _Numpy()
