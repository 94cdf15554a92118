"""Follow a drive in its own curves, and judge its limits."""

import numpy as np

from breaker.family import open_network
from breaker.mechanism import from_list, speeds_of
from breaker.records import open_curves
from breaker.shipped import FAMILIES, KINDS, model_file
from breaker.stores import describe, save
from breaker.wear import Event, Future, Readout, Tracker, follow_life, series_of
from breaker.workflow import start

log = start(snakemake)
params, wear_model = snakemake.params, snakemake.params.wear_model
limits = from_list(params.limits, params.motions, speeds_of(params.speeds))
series = series_of(
    {motion: open_curves(snakemake.input[motion]) for motion in params.motions},
    wear_model["reference"],
    followed={
        motion: list(
            dict.fromkeys(
                name
                for limit in limits
                if limit.of == "record" and limit.motion == motion
                for name in limit.quantities
            )
        )
        for motion in params.motions
    },
    events=Event.by_operation(params.events, params.more_events),
    temperatures=params.temperatures,
)
families = [tuple(open_network(model_file(f, kind)) for kind in KINDS) for f in FAMILIES]
readout = Readout.of(
    series,
    families,
    draws=wear_model["draws"],
    seed=params.seed,
    misfit_p_value=params.misfit_p_value,
)
tracker, future = Tracker.from_settings(wear_model), Future.from_settings(wear_model)
life = follow_life(readout, tracker, limits, future)
noticed = np.array(life.noticed).tolist()
log.info("%d operations, family %s, changes at %s", len(series.operations), readout.family, noticed)
names = ("limits", "speeds", "wear_model", "seed")
save(describe(life, "life", **{name: params[name] for name in names}), snakemake.output[0])
