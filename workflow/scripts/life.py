"""Follow a drive in its own curves, and judge its limits."""

from breaker.model.limits import from_list
from breaker.model.quantities import speeds_of
from breaker.prognosis.life import Life
from breaker.records.curves import open_curves
from breaker.workflow.jobs import start

UNUSED = ("travel", "measured_reason", "remarks")  # which a long life has much of

log = start(snakemake)
params = snakemake.params
life = Life(
    from_list(params.limits, params.motions, speeds_of(params.speeds)),
    params,
    events=params.events,
    conditions=params.conditions,
)
life.update({m: open_curves(snakemake.input[m], without=UNUSED) for m in params.motions})
count, noticed = life.forecast.sizes["operation"], life.forecast.noticed.values.tolist()
log.info("%d operations, family %s, changes at %s", count, life.forecast.attrs["family"], noticed)
names = ("limits", "speeds", "trend", "seed")
life.save(snakemake.output[0], **{name: params[name] for name in names})
