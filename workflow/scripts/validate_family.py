"""Draw from the posteriors of held-out drives, whose state and changes are known."""

from breaker.common.randomness import generator
from breaker.common.zarr_store import describe, open_store, save
from breaker.family.networks import open_network
from breaker.family.training_rows import rows_of, sample_rows
from breaker.shipped import model_file
from breaker.workflow.jobs import start

log = start(snakemake)
params, kind, source = snakemake.params, snakemake.wildcards.kind, snakemake.wildcards.source
bank = open_store(snakemake.input.drives)
network = open_network(snakemake.input.network or model_file(params.family, kind))
rng = generator(params.seed, "validation of the family", kind, source)
data = sample_rows(network, rows_of(kind, bank, network), source, params.draws, rng)
log.info("%s of %s: %d drives, %d withheld", kind, source, data.sizes["curve"], data.withheld)
save(describe(data, f"{kind} of held-out drives", source=source), snakemake.output[0])
