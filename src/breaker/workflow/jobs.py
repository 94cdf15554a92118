"""What every job of the workflow does first: logging and threads. The command line shares it.

And what must be installed before the first job.
"""

import importlib.util
import logging
import os
import sys
from types import TracebackType

from breaker import DISTRIBUTION

_VARIABLES = (
    "OMP_NUM_THREADS",
    "OPENBLAS_NUM_THREADS",
    "MKL_NUM_THREADS",
    "VECLIB_MAXIMUM_THREADS",
    "NUMEXPR_NUM_THREADS",
)
_PACKAGES = (
    *("charset_normalizer", "jinja2", "jsonschema", "matplotlib", "numba", "numcodecs"),
    *("numpy", "pandas", "safetensors", "scipy", "snakemake", "torch", "tqdm", "xarray", "yaml"),
    *("PIL", "zarr"),
)
# Those of an extra that is smaller than that of the workflow.
_EXTRAS = {
    "networks": {"torch"},
    "stores": {"numcodecs", "pandas", "xarray", "zarr"},
    "fast": {"numba"},
}


def missing_packages(*found: str) -> str:
    """Return which packages are missing and the remedy, or nothing where all are there.

    Args:
        found: Names of packages that an import did not find, if it is known; else all that the
            workflow needs are looked for.
    """
    missing = found or tuple(name for name in _PACKAGES if importlib.util.find_spec(name) is None)
    if not missing:
        return ""
    fit = (extra for extra, has in _EXTRAS.items() if has.issuperset(missing))
    extra = next(fit, "workflow")
    return (
        f"missing in the environment of {sys.executable}: {', '.join(missing)}. Run `pip install "
        f'"{DISTRIBUTION}[{extra}]"`, or `make environment` in the project\'s folder'
    )


def start(job: object) -> logging.Logger:
    """Set up a job of Snakemake and return its logger.

    Messages go to the rule's log file and to stderr, an uncaught exception too. A job computes on
    as many threads as its rule has.

    Args:
        job: The object ``snakemake`` of a script.
    """
    handlers = [
        logging.FileHandler(job.log[0], mode="w", encoding="utf-8"),
        logging.StreamHandler(sys.stderr),
    ]
    form = f"%(asctime)s {job.rule}: %(message)s"
    logging.basicConfig(level=logging.INFO, format=form, datefmt="%H:%M:%S", handlers=handlers)
    logger = logging.getLogger("breaker")

    def log_exception(
        kind: type[BaseException], error: BaseException, trace: TracebackType | None
    ) -> None:
        if issubclass(kind, KeyboardInterrupt):
            logger.error("interrupted")
        else:
            logger.error("%s: %s", kind.__name__, error, exc_info=(kind, error, trace))

    sys.excepthook = log_exception
    set_threads(job.threads)
    return logger


def set_threads(count: int) -> None:
    """Compute on as many threads from now on: torch, numba and the linear algebra.

    What is loaded already is told so, what is loaded later reads it from the environment. The
    linear algebra of numpy reads it when numpy is loaded, and never again: call this before, as
    the command line does. (Snakemake sets the same variables for its jobs.) Threads that wait for
    each other on a busy machine are slower than one alone, up to five times.

    >>> set_threads(1)
    >>> os.environ["OMP_NUM_THREADS"]
    '1'
    """
    for name in _VARIABLES:
        os.environ[name] = str(count)
    if "numba" in sys.modules:
        numba = sys.modules["numba"]
        numba.set_num_threads(min(count, numba.config.NUMBA_NUM_THREADS))
    else:
        os.environ["NUMBA_NUM_THREADS"] = str(count)
    # Last: numba starts its threads when it is told, which sets those of OpenMP, and so of torch.
    if "torch" in sys.modules:
        sys.modules["torch"].set_num_threads(count)
