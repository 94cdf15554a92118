"""Draw how early the model and other detectors find changes, over their false alarms."""

import pandas as pd

from breaker.figures.detectors import detectors
from breaker.workflow import start

log = start(snakemake)
table = pd.read_csv(snakemake.input.detectors)
detectors(table, **snakemake.params).savefig(snakemake.output[0])
