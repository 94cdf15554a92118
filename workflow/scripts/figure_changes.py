"""Draw the changes of the parameters since new, over the operations of a life."""

from breaker.common.zarr_store import open_store
from breaker.figures.changes import changes
from breaker.figures.style import save
from breaker.workflow.jobs import start

log = start(snakemake)
life, truth = open_store(snakemake.input.life).load(), None
if snakemake.input.truth:
    values = open_store(snakemake.input.truth).value.load()
    new = {"operation": slice(None, life.asked.values[0])}  # until the reference is full
    truth = 100.0 * (values / values.sel(new).mean("operation") - 1.0)
save(changes(life, truth), snakemake.output[0])
