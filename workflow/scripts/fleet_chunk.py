"""Estimate some breakers of a fleet, one after the other."""

from breaker.common.zarr_store import describe, save
from breaker.prognosis.examination import examine, stored
from breaker.prognosis.members import members_of
from breaker.records.folder import list_fleet
from breaker.workflow.jobs import start

log = start(snakemake)
params, config = snakemake.params, dict(snakemake.params.items())
chosen = {key: params.endurance[key] for key in ("phase", "events")}
rows = list_fleet(params.folder, breakers=params.breakers, **chosen)
examined = []
for member in members_of(rows, params.motions, params.endurance["format"]):
    examined.append(examine(member, config, params.types))
    document = examined[-1].document
    log.info("%s %s: %s by %s", member.breaker, member.phase, document.state, document.how)
save(describe(stored(examined), "breakers", source=params.source), snakemake.output[0])
