"""Train a network on the drives of a family: of their state, or of its changes."""

from pathlib import Path

import numpy as np

from breaker.family import write_network
from breaker.model import generator
from breaker.posterior import (
    FamilyNetwork,
    FamilyRows,
    Trainer,
    choose_device,
    fingerprint,
)
from breaker.stores import describe, save
from breaker.synthetic import members_of, open_family, rows_of
from breaker.workflow import start

log = start(snakemake)
params, kind, output = snakemake.params, snakemake.wildcards.kind, snakemake.output
settings, seed = params.networks, params.seed
made_from = {
    **{key: params[key] for key in ("seed", "prior", "networks")},
    "kind": kind,
    "drives": params.family,
}

bank, held_out = open_family(snakemake.input.shards, settings["training"]["held_out_curves"])
rows = rows_of(kind, bank)
rows.freeze(generator(seed, "family", kind, "scales"))
device = choose_device(settings["training"]["device"])
network = FamilyNetwork(settings["network"], kind, *rows.sizes, atoms=rows.atoms, seed=seed)
aside = len(rows) - settings["training"]["validation_curves"]
trainer = Trainer(
    posterior=network.to(device),
    rows=FamilyRows(np.arange(aside), rows.rows, device),
    validation=FamilyRows(np.arange(aside, len(rows)), rows.rows, device),
    settings=settings["training"],
    seed=seed,
    checkpoint=Path(params.checkpoint),
    fingerprint=fingerprint(made_from, snakemake.input.code),
)
history = trainer.run()
frozen = rows.frozen
if kind == "levels":
    frozen["members"] = members_of(held_out, frozen["bases"], generator(seed, "family members"))
log.info("%s: best weights at step %d, loss %.3f", kind, trainer.best_step, trainer.best_loss)
save(describe(history, f"loss of {kind}", **made_from), output.history)
weights = {name: each.detach().cpu().numpy() for name, each in network.state_dict().items()}
write_network(output.network, made_from | {"family": params.family["name"]}, weights, frozen)
trainer.checkpoint.unlink(missing_ok=True)
