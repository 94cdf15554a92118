"""Follow a drive in its own curves, and judge its limits."""

import numpy as np

from breaker.mechanism import from_list, speeds_of
from breaker.records import open_curves
from breaker.stores import describe, save
from breaker.wear import Event, follow_curves
from breaker.workflow import start

UNUSED = ("travel", "measured_sd", "measured_reason", "remarks")  # which a long life has much of

log = start(snakemake)
params = snakemake.params
life = follow_curves(
    {m: open_curves(snakemake.input[m], without=UNUSED) for m in params.motions},
    from_list(params.limits, params.motions, speeds_of(params.speeds)),
    params,
    events=Event.by_operation(params.events, params.more_events),
    temperatures=params.temperatures,
)
count, noticed = life.sizes["operation"], np.array(life.noticed).tolist()
log.info("%d operations, family %s, changes at %s", count, life.attrs["family"], noticed)
names = ("limits", "speeds", "wear_model", "seed")
save(describe(life, "life", **{name: params[name] for name in names}), snakemake.output[0])
