"""Functions for jobs of the workflow: chunks, logging and checkpoints."""

import logging
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from breaker.common.compiling import set_threads


def checkpoint_of(output: str | Path, ending: str) -> Path:
    """Return the checkpoint file of a job: the path of its output, but in ``checkpoints``.

    Snakemake removes the outputs of a failed job, but not this file.

    >>> checkpoint_of("drive/results/models/closing.safetensors", ".pt").as_posix()
    'drive/checkpoints/models/closing.pt'
    """
    path = Path(output).with_suffix(ending)
    return Path(*("checkpoints" if part == "results" else part for part in path.parts))


def chunks_of(numbers: Iterable[int], size: int) -> dict[str, list[int]]:
    """Sort numbers of operations into chunks by name, one chunk a job: numbers 1 to ``size``, etc.

    Appended operations do not change earlier chunks, and operations of one number are in the same
    chunk in both motions. Empty chunks are left out, repeated numbers count once, and number 0 is
    in the chunk of number 1.

    >>> chunks_of([1, 2, 3, 4, 11], size=3)
    {'000': [1, 2, 3], '001': [4], '003': [11]}
    """
    chunks: dict[str, list[int]] = {}
    for number in sorted(set(numbers)):
        chunks.setdefault(f"{max(number - 1, 0) // size:03d}", []).append(number)
    return chunks


def start(job: object) -> logging.Logger:
    """Set up the job of an object ``snakemake``, with the threads of its rule.

    Messages and an uncaught exception go to the rule's log file and to stderr.
    """
    file = logging.FileHandler(job.log[0], mode="w", encoding="utf-8")
    handlers = [file, logging.StreamHandler(sys.stderr)]
    form = f"%(asctime)s {job.rule}: %(message)s"
    logging.basicConfig(level=logging.INFO, format=form, datefmt="%H:%M:%S", handlers=handlers)
    sys.excepthook = _log_exception
    set_threads(job.threads)
    return logging.getLogger("breaker")


def _log_exception(kind: type[BaseException], error: BaseException, trace: Any) -> None:
    about = kind.__name__, error
    logging.getLogger("breaker").error("%s: %s", *about, exc_info=(kind, error, trace))
