"""Put all inferred operations of one motion into one store and one tidy table."""

from breaker.inference import table
from breaker.jobs import start
from breaker.measurement import open_curves
from breaker.stores import save

log = start(snakemake)
motion = snakemake.wildcards.motion

result = open_curves(snakemake.input.chunks)
save(result, snakemake.output.store)
table(result).to_csv(snakemake.output.table, index=False, float_format="%.6g")
log.info("%d operations of %s", result.sizes["operation"], motion)
