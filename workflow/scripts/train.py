"""Train the posterior of one motion on its bank."""

from breaker.common.randomness import generator
from breaker.common.zarr_store import describe, save
from breaker.networks.training import Checkpoint, Trainer, choose_device, fingerprint
from breaker.paper.bank import open_bank
from breaker.paper.posterior import Posterior
from breaker.paper.training import (
    OnlineRows,
    Rows,
    convergence,
    freeze_inputs,
    held_out_log_density,
    records,
    split,
)
from breaker.workflow.jobs import checkpoint_of, start

log = start(snakemake)
params, motion, output = snakemake.params, snakemake.wildcards.motion, snakemake.output
training, seed = params.training, params.seed
settings = ("seed", "model", "prior", "sensor", "network", "training", "bank")
made_from = {key: params[key] for key in settings} | {"motion": motion}

bank = open_bank(snakemake.input.shards)
counts = training["validation_curves"], training["held_out_curves"]
part, validation, unseen = split(bank.sizes["curve"], *counts)
curves = bank.isel(curve=part)
device = choose_device(training["device"])
posterior = Posterior(made_from, seed=seed)
freeze_inputs(posterior, curves, generator(seed, "components", motion))
posterior.to(device)
online = params.bank["online"]
rows = OnlineRows(posterior, device) if online else Rows.of(curves, posterior, device)
del curves
trainer = Trainer(
    network=posterior,
    rows=rows,
    validation=Rows.of(bank.isel(curve=validation), posterior, device),
    settings=training,
    seed=seed,
    checkpoint=Checkpoint(
        checkpoint_of(output.model, ".pt"), fingerprint(made_from, snakemake.input.code)
    ),
)
history = trainer.run()

unseen = bank.isel(curve=unseen)
measured = records(posterior.eval(), unseen, seed)
solver = convergence(posterior, measured, seed)
density, error = held_out_log_density(posterior, measured, unseen)
log.info(
    "%s: best EMA weights at step %d; %d solver steps for draws and %d for the density; "
    "held-out log density %.3f +- %.3f",
    motion,
    trainer.best_step,
    posterior.solver_steps,
    posterior.density_solver_steps,
    density,
    error,
)
history = history.assign_attrs(held_out_log_density=density, held_out_log_density_se=error)
save(describe(history, f"loss of {motion}", **made_from), output.history)
save(describe(solver, f"solver of {motion}", **made_from), output.solver)
posterior.save(output.model)
trainer.checkpoint.file.unlink(missing_ok=True)
