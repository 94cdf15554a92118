"""Compute what each error of a record costs, what the model leaves out among them."""

from breaker.model import Model, open_discrepancy, seed_integer
from breaker.stores import describe, save
from breaker.synthetic import contraction_by_error
from breaker.workflow import start

log = start(snakemake)
params, motion = snakemake.params, snakemake.wildcards.motion

settings = {"prior": params.prior, "sensor": params.sensor, "motion": motion}
model = Model.from_settings(settings, open_discrepancy(snakemake.input.discrepancy, motion))
cost = contraction_by_error(model, params.curves, seed_integer(params.seed, "cost", motion))
settings = {key: params[key] for key in ("seed", "prior", "sensor", "curves")}
save(describe(cost, f"contraction error by error, {motion}", **settings), snakemake.output[0])
