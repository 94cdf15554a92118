"""Follow some lives of rigs, and keep what is inferred beside the truth."""

from breaker.mechanism import Size
from breaker.model import Model, Prior
from breaker.stores import open_store
from breaker.synthetic import family_of, judge_lives
from breaker.workflow import start

log = start(snakemake)
params, name = snakemake.params, snakemake.wildcards.family
shared = {key: params[key] for key in ("prior", "sensor")}
models = {each: Model.from_settings({**shared, "motion": each}) for each in params.motions}
prior, size = Prior.from_settings(params.prior), Size(**params.size)
family = family_of(name, prior, params.rigs, params.judged, size)
learned = open_store(snakemake.input.discrepancy).load()

rows = judge_lives(name, family, models, learned, params.numbers, params.judged, params.wear_model)
log.info("lives %s followed", params.numbers)
rows.to_csv(snakemake.output[0], index=False)
