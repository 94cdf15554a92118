"""Draw what was inferred against the truth, for one motion (Fig. 6)."""

from breaker.figures.validation import recovery as recovery_figure
from breaker.stores import open_store
from breaker.validation import parameters_of, recovery
from breaker.workflow import start

log = start(snakemake)
source = snakemake.params.get("motions") or snakemake.wildcards.motion
data = parameters_of(open_store(snakemake.input.validation))

summary = recovery(data.draws.values, data.truth.values)
figure = recovery_figure(summary, data.output.values, motion=source)
figure.savefig(snakemake.output[0])
