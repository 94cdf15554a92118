"""Write what the report opens on."""

from pathlib import Path

from breaker.decisions import DECISIONS, opening, read_table
from breaker.stores import open_store
from breaker.workflow import start

log = start(snakemake)
found = snakemake.input
page = opening(
    open_store(found.verdict),
    read_table(found.decisions, DECISIONS),
    Path(found.figure).read_bytes(),
)
Path(snakemake.output[0]).write_text(page, encoding="utf-8")
