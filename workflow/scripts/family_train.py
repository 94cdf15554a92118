"""Train a network on the drives of a family: of their state, or of its changes."""

import xarray as xr

from breaker.common.zarr_store import describe, open_store, save
from breaker.family.network_files import write_network
from breaker.family.training import train_network
from breaker.family.training_rows import rows_of
from breaker.networks.training import Checkpoint, fingerprint
from breaker.workflow.jobs import checkpoint_of, start

log = start(snakemake)
params, kind, output = snakemake.params, snakemake.wildcards.kind, snakemake.output
header, file = params.header, checkpoint_of(output.network, ".pt")
settings = {key: header[key] for key in ("network", "training")} | {"device": params.device}

shards = [open_store(path) for path in snakemake.input.shards]
bank = xr.concat(shards, dim="drive", combine_attrs="override")
last = bank.sizes["drive"] - header["training"]["held_out_curves"]
bank, held_out = bank.isel(drive=slice(last)), bank.isel(drive=slice(last, None))
history, weights, frozen = train_network(
    rows_of(kind, bank),
    held_out,
    settings,
    header["seed"],
    workers=snakemake.resources.workers,
    checkpoint=Checkpoint(file, fingerprint(header | settings, snakemake.input.code)),
)
step, loss = history.attrs["best_step"], history.attrs["best_validation_loss"]
log.info("%s: best weights at step %d, loss %.3f", kind, step, loss)
save(describe(history, f"loss of {kind}", **header), output.history)
write_network(output.network, header, weights, frozen)
file.unlink(missing_ok=True)
