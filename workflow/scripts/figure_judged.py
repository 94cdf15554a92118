"""Draw how often the truth of judged rigs is where it should be, and faults are noticed."""

import pandas as pd

from breaker.figures.judged import judged
from breaker.workflow import start

log = start(snakemake)
tables = [pd.read_csv(snakemake.input[kind]) for kind in ("lives", "faults")]
judged(*tables).savefig(snakemake.output[0])
