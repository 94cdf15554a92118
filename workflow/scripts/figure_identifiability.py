"""Draw how well a curve determines each parameter, and how much of it posteriors reach."""

from breaker.figures.identifiability import identifiability
from breaker.mechanism import is_logarithmic, prior_sds
from breaker.stores import open_store
from breaker.validation import contraction, reached
from breaker.workflow import start

start(snakemake)
params = snakemake.params
files = snakemake.input
limit, amortised, corrected = (
    open_store(files[name]) for name in ("limit", "amortised", "corrected")
)
corrected = corrected.isel(curve=corrected.resolved.values)  # of the others, no width is known
names = amortised.output.values
scale = {
    "prior_sd": prior_sds(names, params.prior, params.onset_sd),
    "log": is_logarithmic(names),
}
sources = {
    "amortised": amortised.draws.values,
    "corrected": corrected.draws.values,
}
found = {name: contraction(draws, **scale) for name, draws in sources.items() if len(draws)}
figure = identifiability(
    reached({"limit": limit.contraction.values} | found, names),
    motion=snakemake.wildcards.motion,
)
figure.savefig(snakemake.output[0])
