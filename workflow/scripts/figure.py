"""Draw stores as they are: by the function of the figure's name in the module that a rule names."""

from importlib import import_module

from breaker.common.zarr_store import open_store
from breaker.figures.style import save
from breaker.workflow.jobs import start

start(snakemake)
params, files = snakemake.params, dict(snakemake.input.items())
files.pop("code")
draw = getattr(import_module(params.within), params.figure)
stores = {name: open_store(file).load() for name, file in files.items()}
save(draw(**stores, **dict(snakemake.wildcards.items())), snakemake.output[0])
