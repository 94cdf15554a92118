"""Infer single records of some rigs exactly, and keep intervals beside the truth."""

from breaker.mechanism import Size
from breaker.model import Model, Prior, open_discrepancy
from breaker.synthetic import family_of, judge_records
from breaker.workflow import start

log = start(snakemake)
params, name = snakemake.params, snakemake.wildcards.family
shared = {key: params[key] for key in ("prior", "sensor")}
models = {each: Model.from_settings({**shared, "motion": each}) for each in params.motions}
left_out = {each: open_discrepancy(snakemake.input.discrepancy, each) for each in params.motions}
prior, size = Prior.from_settings(params.prior), Size(**params.size)
family = family_of(name, prior, params.rigs, params.judged, size)

rows = judge_records(
    name, family, models, left_out, params.numbers, params.judged, params.correction
)
log.info(
    "%d rigs judged, %.3g of their posteriors resolved", len(params.numbers), rows.resolved.mean()
)
rows.to_csv(snakemake.output[0], index=False)
