"""Draw the life of a drive: its limits, its changes, and the operations left."""

import json
from pathlib import Path

import xarray as xr

from breaker.common.zarr_store import open_store
from breaker.family.endurance_truth import failure_times
from breaker.figures.life import changepoint, changes, coverage, health, remaining_life
from breaker.figures.style import save
from breaker.figures.verdict import verdict
from breaker.model.limits import from_list
from breaker.model.quantities import speeds_of
from breaker.workflow.jobs import start

start(snakemake)
files, params, output = snakemake.input, snakemake.params, snakemake.output
life, standing = (open_store(files[name]).load() for name in ("life", "standing"))
words = json.loads(Path(files.words).read_text(encoding="utf-8"))

true_changes = true_life = None
if files.truth:  # only for the simulated test
    truth = open_store(files.truth).load()
    new = {"operation": slice(None, life.asked.values[0])}  # until the reference is full
    true_changes = 100.0 * (truth.value / truth.value.sel(new).mean("operation") - 1.0)
    limits = from_list(params.limits, params.motions, speeds_of(params.speeds))
    failure = failure_times(truth, limits)
    names = life.limit.values
    true_life = xr.Dataset({"failure": ("limit", [failure[name] for name in names])})
    true_life = true_life.assign_coords(limit=names)
    true_life["held"] = "limit", coverage(life, true_life.failure.values)

save(verdict(life, standing, words["sentences"]), output.verdict)
save(health(life, standing), output.health)
save(changepoint(life), output.changepoint)
save(remaining_life(life, standing, true_life), output.remaining_life)
save(changes(life, true_changes), output.changes)
