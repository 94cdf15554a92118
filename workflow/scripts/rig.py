"""Run the stand-in: write the curve files of one motion of its endurance test."""

from breaker.family.endurance_rig import Rig
from breaker.workflow.jobs import start

log = start(snakemake)
params = snakemake.params

Rig.from_settings(params.rig, params.seed).run(snakemake.wildcards.motion, snakemake.output[0])
