"""Set the drives of a fleet side by side: table, picture and page."""

from pathlib import Path

import xarray as xr

from breaker.common.document import html_page
from breaker.common.text import save_frame
from breaker.common.zarr_store import open_store
from breaker.figures.reports import fleet
from breaker.figures.style import save
from breaker.model.prior import Prior
from breaker.prognosis.drive_document import DriveDocument
from breaker.prognosis.fleet_page import fleet_document
from breaker.prognosis.ranking import fleet_table, learn_types, type_table
from breaker.workflow.jobs import start

log = start(snakemake)
params, output = snakemake.params, snakemake.output
chunks = [open_store(each).load() for each in snakemake.input.chunks]
drives = xr.concat(chunks, "drive")
types = learn_types(drives, Prior.from_settings(params.prior))
table, learned = fleet_table(drives, types), type_table(types)
log.info("%d drives of %d types, %d odd", len(table), len(types), (table.odd != "").sum())

save_frame(table, output.table, digits=6)
save_frame(learned, output.types, digits=6)
documents = map(DriveDocument.from_json, drives.document.values)
named = [(each.breaker, each.phase) for each in documents]
save(fleet(table, named, types), output.figure)
document, figure = fleet_document(table, learned), Path(output.figure).read_bytes()
page = html_page(document, [figure], alt="the fleet")
Path(output.page).write_text(page, encoding="utf-8")
