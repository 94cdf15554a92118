"""Simulate drives of the family, new and worn, as one part of its bank."""

from breaker.common.randomness import generator
from breaker.common.zarr_store import describe, save
from breaker.family.bank import simulate_family
from breaker.family.drive_family import Family
from breaker.model.prior import Prior
from breaker.workflow.jobs import start

log = start(snakemake)
params = snakemake.params

rng = generator(params.seed, "family", params.part)
family = Family(Prior.from_settings(params.prior), params.family)
bank = simulate_family(family, params.drives, rng)
log.info("%d drives; %d drawn again, as a curve has no shape", bank.drive.size, bank.drawn_again)
bank = describe(bank, "drives of the family", prior=params.prior, family=params.family)
save(bank.assign_attrs(seed=params.seed, part=params.part), snakemake.output[0])
