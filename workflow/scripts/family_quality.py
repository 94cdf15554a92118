"""Put the quality of the networks of a family into a table, one row an output."""

from pathlib import Path

import pandas as pd

from breaker.common.zarr_store import open_store
from breaker.paper.validation import family_quality
from breaker.workflow.jobs import start

log = start(snakemake)
tables = []
for store in (*snakemake.input.levels, *snakemake.input.changes):
    kind, source = Path(store).stem.split("_")
    tables.append(
        family_quality(open_store(store), log=kind == "levels").assign(network=kind, motions=source)
    )
table = pd.concat(tables)
log.info("90 %% intervals hold %.3f to %.3f", table.coverage_90.min(), table.coverage_90.max())
table.to_csv(snakemake.output[0], index=False, float_format="%.5g")
