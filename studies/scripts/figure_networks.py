"""Draw all networks of one motion side by side."""

import pandas as pd

from breaker.workflow import start
from studies.networks.figures import networks

start(snakemake)
figure = networks(pd.read_csv(snakemake.input.table), motion=snakemake.wildcards.motion)
figure.savefig(snakemake.output[0])
