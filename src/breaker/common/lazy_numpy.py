"""numpy, loaded as it is first used: the plan of the workflow is made where it is not installed."""

from typing import TYPE_CHECKING, Any


class _Numpy:
    def __getattr__(self, name: str) -> Any:
        import numpy

        vars(self)[name] = found = getattr(numpy, name)  # found at once from now on
        return found


if TYPE_CHECKING:
    import numpy as np
else:
    np = _Numpy()
