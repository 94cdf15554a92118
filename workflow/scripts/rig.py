"""Run the stand-in: write the curve files of its endurance test."""

from breaker.jobs import start
from breaker.rig import run

log = start(snakemake)
