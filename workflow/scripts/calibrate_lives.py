"""Find the widening of trends from the lives that settings are tuned on."""

import xarray as xr

from breaker.stores import open_store
from breaker.synthetic import WIDENINGS, calibrate
from breaker.workflow import start

log = start(snakemake)
files = snakemake.input.lives
covered = xr.concat([open_store(file).covered.load() for file in files], "life")
table, widening = calibrate(covered.transpose("life", "fraction", "widening"), WIDENINGS)
log.info("%d lives: wear_model.widening of %g\n%s", len(covered), widening, table)
table.to_csv(snakemake.output[0], index=False, float_format="%.4g")
