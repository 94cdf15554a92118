"""Draw what to do about a drive, and how each limit stands."""

import json
from pathlib import Path

from breaker.common.zarr_store import open_store
from breaker.figures.style import save
from breaker.figures.verdict import verdict
from breaker.workflow.jobs import start

log = start(snakemake)
life, standing = (open_store(snakemake.input[name]).load() for name in ("life", "standing"))
words = json.loads(Path(snakemake.input.words).read_text(encoding="utf-8"))
save(verdict(life, standing, words["sentences"]), snakemake.output[0])
