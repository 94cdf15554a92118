"""Draw how conclusions about a few operations move with the model's own error."""

import pandas as pd

from breaker.figures.sensitivity import sensitivity
from breaker.workflow import start

start(snakemake)
figure = sensitivity(
    pd.read_csv(snakemake.input.table),
    motion=snakemake.wildcards.motion,
    misfit_p_value=snakemake.params.misfit_p_value,
)
figure.savefig(snakemake.output[0])
