"""Let faults happen to some followed rigs, and keep whether they are noticed."""

from breaker.mechanism import Size
from breaker.model import Model, Prior
from breaker.stores import open_store
from breaker.synthetic import family_of, judge_power
from breaker.workflow import start

log = start(snakemake)
params = snakemake.params
shared = {key: params[key] for key in ("prior", "sensor")}
models = {each: Model.from_settings({**shared, "motion": each}) for each in params.motions}
prior, size = Prior.from_settings(params.prior), Size(**params.size)
family = family_of("held_back", prior, params.rigs, params.judged, size)
learned = open_store(snakemake.input.discrepancy).load()

rows = judge_power(family, models, learned, params.numbers, params.judged, params.wear_model)
log.info("rigs %s judged", params.numbers)
rows.to_csv(snakemake.output[0], index=False)
