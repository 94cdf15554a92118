"""Score all lives of a seed, and compare detectors on them."""

import xarray as xr

from breaker.stores import describe, open_store, save
from breaker.synthetic import compare_detectors, score
from breaker.workflow import start

log = start(snakemake)
lives = xr.concat([open_store(file).load() for file in snakemake.input.lives], "life")

params = snakemake.params
scores, table = score(lives, toward=params.toward, settle=params.settle)
log.info("\n%s", table.to_string(index=False))
save(describe(scores, "scores of simulated lives"), snakemake.output.scores)
table.to_csv(snakemake.output.table, index=False, float_format="%.4g")
detectors = compare_detectors(lives, settle=params.settle)
detectors.to_csv(snakemake.output.detectors, index=False, float_format="%.6g")
