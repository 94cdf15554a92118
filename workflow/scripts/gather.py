"""Put all operations of one motion, with both posteriors, into one store and one tidy table."""

from breaker.files import save_frame
from breaker.posterior import stack_posteriors, table_of_both
from breaker.records import open_curves
from breaker.stores import save
from breaker.workflow import start

log = start(snakemake)
motion = snakemake.wildcards.motion

result = stack_posteriors(
    open_curves(snakemake.input.inferred), open_curves(snakemake.input.corrected)
)
save(result, snakemake.output.store)
save_frame(table_of_both(result), snakemake.output.table, digits=6)
log.info(
    "%d operations of %s, %d resolved", result.sizes["operation"], motion, result.resolved.sum()
)
