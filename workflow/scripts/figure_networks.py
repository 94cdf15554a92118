"""Draw all networks of one motion side by side."""

import pandas as pd

from breaker.figures.networks import networks
from breaker.workflow import start

start(snakemake)
figure = networks(pd.read_csv(snakemake.input.table), motion=snakemake.wildcards.motion)
figure.savefig(snakemake.output[0])
