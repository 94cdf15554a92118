"""Put all operations of one motion into two stores and one tidy table: by network and family."""

import pandas as pd

from breaker.common.zarr_store import save
from breaker.paper.validation import intervals, table
from breaker.records.curves import open_curves
from breaker.workflow.jobs import start

log = start(snakemake)
tables = []
for by in snakemake.output.keys() - {"table"}:
    result = open_curves(snakemake.input[by])
    if "median" not in result:
        result = result.assign(intervals(result.draws.values))
    save(result, snakemake.output[by])
    rows = table(result)
    rows.insert(1, "posterior", by)
    tables.append(rows)
    known = result.accepted & ~result.misfit
    log.info("%s: %d of %d operations fit", by, known.sum(), result.sizes["operation"])
rows = pd.concat(tables).sort_values("operation", kind="stable", ignore_index=True)
rows.to_csv(snakemake.output.table, index=False, float_format="%.6g")
