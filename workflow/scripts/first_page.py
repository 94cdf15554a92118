"""Write the first page: sentences, the table of limits and the picture, in one file."""

import json
from pathlib import Path

import pandas as pd

from breaker.common.document import Document, Table, html_page
from breaker.common.numerals import in_digits
from breaker.workflow.jobs import start

SHOWN = ["limit", "state", "of", "quantity", "new", "now_5", "now", "now_95", "bound", "unit"]
SHOWN += ["p_exceeded", "certain", "operations_left_5", "operations_left", "operations_left_95"]

log = start(snakemake)
files = snakemake.input
first, *others = json.loads(Path(files.words).read_text(encoding="utf-8"))["sentences"]
limits = pd.read_csv(files.limits)[SHOWN]
texts = limits.map(lambda cell: in_digits(cell, 4) if isinstance(cell, float) else str(cell))
rows = texts.mask(limits.isna(), "").to_numpy().tolist()
table = Table([name.replace("_", " ") for name in SHOWN], rows)
page, picture = Document(first, summary=others, parts=[table]), Path(files.figure).read_bytes()
Path(snakemake.output[0]).write_text(html_page(page, [picture]), encoding="utf-8")
