"""Follow the measured quantities that limits name."""

from breaker.decisions import join
from breaker.mechanism import from_list, speeds_of
from breaker.stores import describe, open_store, save
from breaker.wear import Event, follow_measured
from breaker.workflow import start

log = start(snakemake)
params = snakemake.params
names = ["accepted", "measured", "measured_sd"]
data = {
    motion: join([open_store(file)[names].load() for file in snakemake.input[motion]])
    for motion in params.motions
}
limits = from_list(params.limits, params.motions, speeds_of(params.speeds))
events = Event.by_operation(params.events, params.more_events)
result = follow_measured(data, limits, params.wear_model, params.seed, events)
for name in result.followed.values:
    one = result.alarm.sel(followed=name)
    log.info("%s: changes noticed at %s", name, one.operation.values[one.values].tolist())
settings = {name: params[name] for name in ("limits", "speeds", "wear_model", "seed")}
save(describe(result, "trends of measured quantities", **settings), snakemake.output[0])
