"""Draw from the posteriors of held-out drives, whose state and changes are known."""

from breaker.family import open_network
from breaker.model import generator
from breaker.stores import describe, open_store, save
from breaker.synthetic import rows_of, sample_rows
from breaker.workflow import start

log = start(snakemake)
params, kind, source = snakemake.params, snakemake.wildcards.kind, snakemake.wildcards.source
bank = open_store(snakemake.input.drives)
network = open_network(snakemake.input.network)
rng = generator(params.seed, "validation of the family", kind, source)
data = sample_rows(network, rows_of(kind, bank, network), source, params.draws, rng)
log.info("%s of %s: %d drives, %d withheld", kind, source, data.sizes["curve"], data.withheld)
save(describe(data, f"{kind} of held-out drives", source=source), snakemake.output[0])
