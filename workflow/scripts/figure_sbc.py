"""Draw the calibration of one motion (Fig. 4)."""

from breaker.figures.validation import sbc
from breaker.stores import open_store
from breaker.validation import judge_draws, parameters_of
from breaker.workflow import start

log = start(snakemake)
source = snakemake.params.get("motions") or snakemake.wildcards.motion
data = parameters_of(open_store(snakemake.input.validation))

figure = sbc(
    judge_draws(data.draws.values, data.truth.values),
    data.output.values,
    motion=source,
    subject=snakemake.params.subject,
)
figure.savefig(snakemake.output[0])
