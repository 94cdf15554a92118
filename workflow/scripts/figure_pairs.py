"""Draw prior, posterior and truth of one simulated curve, pair by pair (Fig. 7)."""

import numpy as np

from breaker.common.zarr_store import open_store
from breaker.figures.pairs import pairs
from breaker.figures.panels import SOURCES
from breaker.figures.style import save
from breaker.model.parameters import is_logarithmic
from breaker.paper.validation import correlation, parameters_of, regions
from breaker.workflow.jobs import start

start(snakemake)
wildcards = snakemake.wildcards
source = wildcards.get("source") or wildcards.motion
# The first record, whichever it is: the seed chose it, nobody else.
case = parameters_of(open_store(snakemake.input.validation)).isel(curve=0)
prior = open_store(snakemake.input.prior)
names = case.output.values

columns = np.concatenate([prior.parameters.values, prior.onset.values[:, None]], axis=1)
figure = pairs(
    case,
    columns[:, : len(names)],
    about=f"{SOURCES[source]}: {snakemake.params.subject}",
    correlation=correlation(case.draws.values, log=is_logarithmic(names)),
    regions=regions(case.draws.values),
)
save(figure, snakemake.output[0])
