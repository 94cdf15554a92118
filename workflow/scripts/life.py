"""Estimate the trend of a drive over its life, and judge its limits."""

from breaker.common.zarr_store import describe, save
from breaker.model.limits import from_list
from breaker.model.quantities import speeds_of
from breaker.prognosis.life import follow
from breaker.records.curves import open_curves
from breaker.workflow.jobs import start

UNUSED = ("travel", "measured_reason", "remarks")  # large variables of a long life

log = start(snakemake)
params = snakemake.params
life = follow(
    {m: open_curves(snakemake.input[m], without=UNUSED) for m in params.motions},
    from_list(params.limits, params.motions, speeds_of(params.speeds)),
    params,
    events=params.events,
    conditions=params.conditions,
)
count, noticed = life.sizes["operation"], life.noticed.values.tolist()
log.info("%d operations, family %s, changes at %s", count, life.attrs["family"], noticed)
settings = {name: params[name] for name in ("limits", "speeds", "trend", "seed")}
save(describe(life, "life", **settings), snakemake.output[0])
