"""Follow a drive in its own curves, and judge its limits."""

import numpy as np

from breaker.common.zarr_store import describe, save
from breaker.model.limits import from_list
from breaker.model.quantities import speeds_of
from breaker.prognosis.life_records import Event
from breaker.prognosis.life_results import follow_curves
from breaker.records.curves import open_curves
from breaker.workflow.jobs import start

UNUSED = ("travel", "measured_reason", "remarks")  # which a long life has much of

log = start(snakemake)
params = snakemake.params
life = follow_curves(
    {m: open_curves(snakemake.input[m], without=UNUSED) for m in params.motions},
    from_list(params.limits, params.motions, speeds_of(params.speeds)),
    dict(params.items()),
    events=Event.by_operation(params.events, params.more_events),
    conditions=params.conditions,
)
count, noticed = life.sizes["operation"], np.array(life.noticed).tolist()
log.info("%d operations, family %s, changes at %s", count, life.attrs["family"], noticed)
names = ("limits", "speeds", "trend", "seed")
save(describe(life, "life", **{name: params[name] for name in names}), snakemake.output[0])
