"""What every job of the workflow does first: logging and threads."""

import logging
import sys
from types import TracebackType

__all__ = ["start"]


def start(job: object) -> logging.Logger:
    """Set up a job of Snakemake and return its logger.

    Messages go to the rule's log file and to stderr, an uncaught exception too. A job computes on
    as many threads as its rule has: Snakemake tells the linear algebra by the environment, numba
    is told here, where a script has imported it.

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
        logger.error("%s: %s", kind.__name__, error, exc_info=(kind, error, trace))

    sys.excepthook = log_exception
    if "numba" in sys.modules:
        numba = sys.modules["numba"]
        numba.set_num_threads(min(job.threads, numba.config.NUMBA_NUM_THREADS))
    return logger
