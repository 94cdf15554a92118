"""Draw what the prior holds possible beside three operations of the endurance test (Fig. 3)."""

import numpy as np

from breaker.common.zarr_store import open_store
from breaker.figures.predictive import prior_predictive
from breaker.figures.style import save
from breaker.paper.validation import prior_check
from breaker.reading.records.curve_reader import open_curves
from breaker.workflow.jobs import start

log = start(snakemake)
prior = open_store(snakemake.input.prior)
measured = open_curves(snakemake.input.curves)
measured = measured.isel(operation=np.flatnonzero(measured.accepted.values))

# Three operations, from the first to the last.
chosen = np.unique(np.linspace(0, measured.sizes["operation"] - 1, 3).astype(int))
figure = prior_predictive(
    prior,
    prior_check(prior.travel.values, measured.travel.values),
    measured.isel(operation=chosen),
    motion=snakemake.wildcards.motion,
)
save(figure, snakemake.output[0])
