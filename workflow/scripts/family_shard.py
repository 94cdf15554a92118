"""Simulate drives of the family, new and worn, as one shard of its bank."""

from breaker.model import Prior, generator
from breaker.stores import describe, save
from breaker.synthetic import Family, simulate_family
from breaker.workflow import start

log = start(snakemake)
params, shard = snakemake.params, int(snakemake.wildcards.shard)

settings = params.family
every, more = divmod(settings["drives"], settings["shards"])
rng = generator(params.seed, "family", shard)
family = Family(Prior.from_settings(params.prior), settings)
bank = simulate_family(family, every + (shard < more), rng)
log.info(
    "%d drives; %d drawn again, of which a curve has no shape", bank.drive.size, bank.drawn_again
)
bank = describe(bank, "drives of the family", prior=params.prior, family=settings)
save(bank.assign_attrs(seed=params.seed, shard=shard), snakemake.output[0])
