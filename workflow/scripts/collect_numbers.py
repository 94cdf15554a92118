"""Collect the numbers that texts state, and report differences from the stated numbers."""

import pandas as pd

from breaker.common.zarr_store import open_store
from breaker.paper.run_numbers import numbers_of_motion
from breaker.workflow.jobs import start

log = start(snakemake)
params, files = snakemake.params, snakemake.input

collected = {}
for i, motion in enumerate(params.motions):
    numbers = numbers_of_motion(
        quality=pd.read_csv(files.quality[i]),
        exactness=pd.read_csv(files.exactness[i]),
        prior=open_store(files.prior[i]),
        validation=open_store(files.validation[i]),
        operations=open_store(files.operations[i]),
        family=open_store(files.family[i]),
        predictive=open_store(files.predictive[i]),
        truth=open_store(files.truth).sel(motion=motion) if files.truth else None,
    )
    collected |= {f"{motion}.{name}": value for name, value in numbers.items()}

log.info("%d numbers", len(collected))
pd.Series(collected, name="value").rename_axis("name").to_csv(snakemake.output[0])
if params.stated:
    stated = pd.read_csv(params.stated, dtype=str, index_col="name").value.to_dict()
    others = [name for name in collected | stated if collected.get(name) != stated.get(name)]
    for name in others:
        log.warning("%s is %s here, %s in docs", name, collected.get(name), stated.get(name))
    log.info("%d of them differ from docs/numbers.csv", len(others))
    if others:
        log.warning("`make numbers` writes the numbers of this run into README.md and docs/")
