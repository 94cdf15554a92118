"""Draw calibration and widths of posteriors from records with missing samples."""

from breaker.common.zarr_store import open_store
from breaker.figures.style import save
from breaker.paper.validation.calibration import judge_draws
from breaker.workflow.jobs import start
from studies.networks.figures import missing
from studies.networks.missing import over_curves, widening

start(snakemake)
data = {key: open_store(path) for key, path in snakemake.input.items() if key != "code"}
names = data["missing"].output.values

figure = missing(
    judge_draws(data["missing"].draws.values, data["missing"].truth.values),
    over_curves(widening(data["whole"], data["missing"], names)),
    over_curves(widening(data["exact_whole"], data["exact_missing"], names)),
    names,
    motion=snakemake.wildcards.motion,
    share=snakemake.params.share,
)
save(figure, snakemake.output[0])
