"""Put the quality of one motion's posteriors into a table: one row an output and posterior."""

import pandas as pd

from breaker.common.zarr_store import open_store
from breaker.paper.validation import quality, scale_of
from breaker.workflow.jobs import start

log = start(snakemake)
amortised, corrected, limit, reader = (
    open_store(snakemake.input[name]) for name in ("validation", "corrected", "limit", "reader")
)

tables = []
for posterior, data, files in (("amortised", amortised, reader), ("corrected", corrected, None)):
    table = quality(
        data,
        files,
        limit.contraction.mean("curve").values,
        **scale_of(amortised),
    )
    log.info(
        "%s: %d of %d outputs calibrated, z-score sd %.3f to %.3f, largest shortfall %.3f",
        posterior,
        table.calibrated.sum(),
        len(table),
        table.z_sd.min(),
        table.z_sd.max(),
        table.shortfall.max(),
    )
    table.insert(0, "posterior", posterior)
    tables.append(table)
pd.concat(tables).to_csv(snakemake.output[0], index=False, float_format="%.5g")
