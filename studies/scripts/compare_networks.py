"""Put all networks of one motion into a table."""

import pandas as pd

from breaker.common.zarr_store import open_store
from breaker.paper.posterior import Posterior
from breaker.workflow.jobs import start
from studies.networks.table import network_row

log = start(snakemake)
inputs = snakemake.input

rows = [
    network_row(
        network,
        Posterior.load(inputs.models[i]),
        open_store(inputs.validations[i]).load(),
        pd.read_csv(inputs.judged[i]),
        open_store(inputs.histories[i]),
        pd.read_csv(inputs.trainings[i], sep="\t"),
    )
    for i, network in enumerate(snakemake.params.networks)
]
table = pd.concat(rows)
log.info("\n%s", table.to_string(index=False))
table.to_csv(snakemake.output[0], index=False, float_format="%.5g")
