"""Draw z-score against contraction of one motion (Fig. 5)."""

from breaker.figures.validation import contraction
from breaker.mechanism import is_logarithmic, prior_sds
from breaker.stores import open_store
from breaker.validation import scores
from breaker.workflow import start

log = start(snakemake)
params = snakemake.params
data = open_store(snakemake.input.validation)
limit = open_store(snakemake.input.limit)
names = data.output.values

judged = scores(
    data.draws.values,
    data.truth.values,
    prior_sd=prior_sds(names, params.prior, params.onset_sd),
    log=is_logarithmic(names),
)
figure = contraction(
    judged,
    names,
    motion=snakemake.wildcards.motion,
    limit=limit.contraction.mean("curve").values,
    setting=params.setting,
)
figure.savefig(snakemake.output[0])
