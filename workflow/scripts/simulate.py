"""Simulate operations of one motion from the prior, for a bank or a predictive check."""

from breaker.common.randomness import generator
from breaker.common.zarr_store import describe, save
from breaker.paper.bank import simulate
from breaker.paper.joint_model import Model
from breaker.workflow.jobs import start

start(snakemake)
params, motion = snakemake.params, snakemake.wildcards.motion

# One bank serves sensors with any noise and zero.
sensor = {**params.grid, "onset_sd": params.onset_sd, "noise_sd": 1.0, "zero_sd": 0.0}
model = Model.from_settings({**dict(params.items()), "sensor": sensor, "motion": motion})
bank = simulate(model, params.curves, generator(params.seed, *params.purpose, motion))
settings = {key: params[key] for key in ("model", "prior", "grid", "onset_sd")}
bank = describe(bank, f"{motion} simulated from the prior", **settings)
save(bank.assign_attrs(seed=params.seed, purpose=list(params.purpose)), snakemake.output[0])
