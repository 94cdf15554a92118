"""Draw the parameters over the operations of the endurance test, as changes since new (Fig. 10)."""

from breaker.figures.evolution import evolution
from breaker.figures.style import save
from breaker.posterior import select_posterior
from breaker.stores import open_store
from breaker.workflow import start

log = start(snakemake)
life, singles, truth = open_store(snakemake.input.life).load(), {}, None
new = {"operation": slice(None, life.asked.values[0])}  # until the reference is full
for file in snakemake.input.singles:
    inferred = select_posterior(open_store(file), snakemake.params.posterior)
    values = inferred["median"].load().rename(output="parameter")
    singles[inferred.motion] = 100.0 * (values / values.sel(new).median("operation") - 1.0)
if snakemake.input.truth:
    values = open_store(snakemake.input.truth).value.load()
    truth = 100.0 * (values / values.sel(new).mean("operation") - 1.0)
save(evolution(life, truth, singles), snakemake.output[0])
