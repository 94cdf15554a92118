"""Compare the network's density with the exact posterior, curve by curve."""

from breaker.common.zarr_store import describe, open_store, save
from breaker.paper.correction import judge
from breaker.paper.posterior import Posterior
from breaker.paper.validation import summary
from breaker.workflow.jobs import start

log = start(snakemake)
posterior = Posterior.load(snakemake.input.model, own_functions=True)
data = open_store(snakemake.input.validation).isel(curve=slice(snakemake.params.curves)).load()
corrected = open_store(snakemake.input.corrected)

judged = judge(posterior, data, corrected)
table = summary(judged, corrected)
log.info("%s", ", ".join(f"{key} {value:.4g}" for key, value in table.iloc[0, 1:].items()))
title = f"the {posterior.motion} network against the exact posterior"
save(describe(judged, title, model=posterior.settings), snakemake.output.store)
table.to_csv(snakemake.output.table, index=False, float_format="%.5g")
