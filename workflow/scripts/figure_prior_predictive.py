"""Draw curves of the prior with three operations of the endurance test (Fig. 3)."""

import numpy as np

from breaker.common.zarr_store import open_store
from breaker.figures.predictive import prior_predictive
from breaker.figures.style import save
from breaker.paper.validation import prior_check
from breaker.records.curves import open_curves
from breaker.workflow.jobs import start

log = start(snakemake)
prior, curves = open_store(snakemake.input.prior), None
check = prior_check(prior.travel.values, prior.travel.values[:0])
if snakemake.input.curves:  # empty for the user's simulator
    curves = open_curves(snakemake.input.curves)
    curves = curves.isel(operation=np.flatnonzero(curves.accepted.values))
    check = prior_check(prior.travel.values, curves.travel.values)
    # Three operations, from the first to the last.
    chosen = np.unique(np.linspace(0, curves.sizes["operation"] - 1, 3).astype(int))
    curves = curves.isel(operation=chosen)
save(prior_predictive(prior, check, curves, motion=snakemake.wildcards.motion), snakemake.output[0])
