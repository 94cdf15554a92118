"""Put the trend of a source into one store, with its changes."""

import numpy as np

from breaker.decisions import complete, join
from breaker.posterior import choose
from breaker.stores import describe, open_store, save
from breaker.workflow import start

log = start(snakemake)
source = snakemake.wildcards.source
trend = join([open_store(file).load() for file in snakemake.input.trends])
result = complete(trend, snakemake.params.wear_model, source)
if single := snakemake.input.get("medians"):
    # What a single operation indicates, drawn beside the trend; there is none of both motions.
    medians = choose(open_store(single[0]), "corrected").rename(output="parameter")["median"]
    medians = medians.reindex(operation=trend.operation, parameter=trend.parameter)
    result = result.assign(median=(("operation", "parameter"), np.asarray(medians.values)))

log.info("%s: %d changes", source, result.sizes["change"])
save(describe(result, f"trend of {source}, all operations"), snakemake.output[0])
