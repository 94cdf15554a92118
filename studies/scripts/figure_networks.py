"""Draw all networks of one motion side by side."""

import pandas as pd

from breaker.figures.style import save
from breaker.workflow.jobs import start
from studies.networks.figures import networks

start(snakemake)
figure = networks(pd.read_csv(snakemake.input.table), motion=snakemake.wildcards.motion)
save(figure, snakemake.output[0])
