"""Examine some breakers of a fleet, one after the other."""

from pathlib import Path

from breaker.common.plain_values import to_json
from breaker.prognosis.fleet import drives_of, examine
from breaker.records.folder import list_fleet
from breaker.workflow.jobs import start

log = start(snakemake)
params, config = snakemake.params, dict(snakemake.params.items())
rows = list_fleet(params.folder, breakers=params.breakers, phase=params.endurance["phase"])
results = []
for drive in drives_of(rows, params.motions, params.endurance["format"]):
    results.append(examine(drive, config, params.types))
    log.info("%s %s: %s", drive.breaker, drive.phase, results[-1].state)
Path(snakemake.output[0]).write_text(to_json(results), encoding="utf-8")
