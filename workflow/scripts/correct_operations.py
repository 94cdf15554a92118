"""Correct the posteriors of some operations of the endurance test."""

from breaker.mechanism import NAMES, speeds_of
from breaker.model import Facts, Model
from breaker.posterior import correct_operations
from breaker.stores import describe, open_store, save
from breaker.workflow import start

log = start(snakemake)
params, motion = snakemake.params, snakemake.wildcards.motion
names = ("prior", "sensor", "known", "speeds", "correction", "misfit_p_value")
settings = {key: params[key] for key in names}
model = Model.from_settings({**settings, "motion": motion})
facts = Facts.from_settings(params.known, speeds_of(params.speeds))
inferred = open_store(snakemake.input.inferred).load()

result = correct_operations(
    model.conditioned_on(facts),
    inferred,
    params.correction,
    seed=params.seed,
    misfit_p_value=params.misfit_p_value,
)
log.info(
    "%d of %d operations resolved, %.1f rounds on average, %d do not fit the model",
    result.resolved.sum(),
    result.sizes["operation"],
    result.rounds.mean(),
    result.misfit.sum(),
)
for text in facts.contradicted(result["median"].values[:, : len(NAMES)]):
    log.warning(text)
title = f"exact posteriors of measured {motion} operations"
save(describe(result, title, seed=params.seed, **settings), snakemake.output[0])
