"""Draw z-score against contraction of one motion (Fig. 5)."""

from breaker.figures.validation import contraction
from breaker.mechanism import is_logarithmic, prior_sds
from breaker.stores import open_store
from breaker.validation import parameters_of, scores
from breaker.workflow import start

log = start(snakemake)
source = snakemake.params.get("motions") or snakemake.wildcards.motion
params = snakemake.params
data = parameters_of(open_store(snakemake.input.validation))
limit = snakemake.input.get("limit")  # none is known of a family
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
    motion=source,
    limit=open_store(limit).contraction.mean("curve").values if limit else None,
    setting=params.get("setting", ""),
)
figure.savefig(snakemake.output[0])
