"""Draw how early the model and other detectors find changes, over their false alarms."""

import pandas as pd

from breaker.figures.detectors import detectors
from breaker.workflow import start

log = start(snakemake)
table = pd.read_csv(snakemake.input.detectors)
params = snakemake.params
figure = detectors(table, lives=params.lives, alarm_level=params.alarm_level)
figure.savefig(snakemake.output[0])
