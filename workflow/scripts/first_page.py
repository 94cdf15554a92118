"""Write what the report opens on."""

from pathlib import Path

import pandas as pd

from breaker.decisions import opening
from breaker.stores import open_store
from breaker.workflow import start

log = start(snakemake)
found = snakemake.input
page = opening(
    open_store(found.verdict), pd.read_csv(found.decisions), Path(found.figure).read_bytes()
)
Path(snakemake.output[0]).write_text(page, encoding="utf-8")
