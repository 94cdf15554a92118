"""Write what the report opens on."""

import json
from pathlib import Path

import pandas as pd

from breaker.prognosis.page import opening
from breaker.workflow.jobs import start

log = start(snakemake)
words = json.loads(Path(snakemake.input.words).read_text(encoding="utf-8"))
picture = Path(snakemake.input.figure).read_bytes()
page = opening(words["sentences"], pd.DataFrame(words["limits"]), picture)
Path(snakemake.output[0]).write_text(page, encoding="utf-8")
