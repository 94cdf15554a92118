"""Write the table of a fleet, as CSV and as a page."""

from pathlib import Path

from breaker.common.document import Document, Table, html_page
from breaker.prognosis.fleet_table import fleet_table, read_results
from breaker.workflow.jobs import start

SHOWN = ["breaker", "phase", "type", "last", "state", "limit", "service_by_date", "most_changed"]
SHOWN += ["change", "most_different", "difference", "differs", "remarks"]

log = start(snakemake)
chunks = [Path(file).read_text(encoding="utf-8") for file in snakemake.input.chunks]
table = fleet_table([drive for text in chunks for drive in read_results(text)])
log.info("%d drives: %s", len(table), table.state.value_counts().to_dict())
table.to_csv(snakemake.output.table, index=False, float_format="%.6g")
texts = table[SHOWN].map(lambda cell: f"{cell:.3g}" if isinstance(cell, float) else str(cell))
rows = texts.mask(table[SHOWN].isna(), "").to_numpy().tolist()
head = [name.replace("_", " ") for name in SHOWN]
page = html_page(Document("Fleet", parts=[Table(head, rows)]))
Path(snakemake.output.page).write_text(page, encoding="utf-8")
