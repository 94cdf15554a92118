"""Follow a source through some operations, from the state after those before."""

import numpy as np

from breaker.decisions import align, usable
from breaker.mechanism import from_list, speeds_of
from breaker.model import Model, generator
from breaker.stores import describe, open_store, save
from breaker.wear import Event, Follower, Learned, State, series_of, trust_in
from breaker.workflow import start

log = start(snakemake)
params, source = snakemake.params, snakemake.wildcards.source
wear_model, operations = params.wear_model, np.array(params.operations)
shared = {key: params[key] for key in ("prior", "sensor")}
motions = params.motions if source == "both" else [source]
models = {motion: Model.from_settings({**shared, "motion": motion}) for motion in motions}
store = snakemake.input.get("discrepancy")
learned = store and Learned.from_dataset(
    open_store(store),
    motions,
    params.discrepancy,
    rough_sd=wear_model["rough_sd"],
    noise_sd=params.sensor["noise_sd"],
)
limits = from_list(params.limits, motions, speeds_of(params.speeds))
follower = Follower.from_settings(models, limits, wear_model, params.seed, learned or None)
data = {
    motion: align([open_store(file) for file in snakemake.input[motion]], operations).load()
    for motion in motions
}
events = Event.by_operation(params.events, params.more_events)
there = {motion: usable(each) for motion, each in data.items()}
series = series_of(models, data, there, events, params.temperatures)
before = snakemake.input.get("state")
state = State.from_dataset(open_store(before[0])) if before else follower.begin(series)
state, result = follower.follow(state, series)
if not follower.together(state):
    log.info("the motions have different parameters, or no operation in common: not followed")
log.info("%d operations, changes noticed at %s", result.sizes["operation"], list(state.alarms))
names = ("prior", "sensor", "limits", "speeds", "wear_model", "seed", "discrepancy")
settings = {name: params[name] for name in names}
trust = trust_in(follower, state, generator(params.seed, "trust", source))
save(describe(result, f"trend of {source}", **settings), snakemake.output.trend)
save(describe(state.to_dataset(), f"state of the trend of {source}"), snakemake.output.state)
save(describe(trust, f"trust in the model of {source}", **settings), snakemake.output.trust)
