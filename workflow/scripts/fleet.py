"""Write the table of a fleet, as CSV and as a page."""

from pathlib import Path

from breaker.common.document import html_page
from breaker.common.text import save_frame
from breaker.prognosis.fleet_table import fleet_document, fleet_table, read_results
from breaker.workflow.jobs import start

log = start(snakemake)
chunks = [Path(file).read_text(encoding="utf-8") for file in snakemake.input.chunks]
table = fleet_table([drive for text in chunks for drive in read_results(text)])
log.info("%d drives: %s", len(table), table.state.value_counts().to_dict())
save_frame(table, snakemake.output.table, digits=6)
page = html_page(fleet_document(table))
Path(snakemake.output.page).write_text(page, encoding="utf-8")
