"""Draw calibration, contraction, recovery and pairs of posteriors (Figs. 4, 5, 6, 7).

A rule names the figures that it wants as its outputs: ``sbc`` alone, or all four.
"""

import numpy as np
import xarray as xr

from breaker.common.zarr_store import open_store
from breaker.figures import calibration
from breaker.figures.pairs import pairs
from breaker.figures.panels import SOURCES
from breaker.figures.style import save
from breaker.paper.calibration import judge_draws
from breaker.paper.validation import (
    correlation,
    parameters_of,
    recovery,
    regions,
    scale_of,
    scores,
    with_width,
)
from breaker.workflow.jobs import start

log = start(snakemake)
files, wildcards, figures = snakemake.input, snakemake.wildcards, snakemake.output
data = parameters_of(open_store(files.validation)).load()
names, draws, truth = data.output.values, data.draws.values, data.truth.values
about = f"{SOURCES[wildcards.get('source') or wildcards.motion]}: {snakemake.params.subject}"


def draw_contraction(scale: dict, file: str) -> None:
    """Draw z-scores against contraction, with its limit if known."""
    wide = with_width(data)
    if left_out := data.sizes["curve"] - wide.sizes["curve"]:
        log.warning("%d curves are left out, because their draws are all equal", left_out)
    both = scores(wide.draws.values, wide.truth.values, **scale)
    limit = files.get("limit")  # unknown for a family and for the user's simulator
    limit = open_store(limit).contraction.mean("curve").values if limit else None
    save(calibration.contraction(*both, names, about=about, limit=limit), file)


def draw_pairs(prior: xr.Dataset, scale: dict, file: str) -> None:
    """Draw the first record, which the seed chooses."""
    case = data.isel(curve=0)
    columns = np.concatenate([prior.parameters.values, prior.onset.values[:, None]], axis=1)
    scores = {
        "correlation": correlation(case.draws.values, log=scale["log"]),
        "regions": regions(case.draws.values),
    }
    save(pairs(case, columns[:, : len(names)], about=about, **scores), file)


about += f", {data.sizes['curve']} records, {data.sizes['draw']} draws of each"
rejected = data.attrs.get("rejected", 0)
if rejected:
    about += f", {rejected} of {rejected + data.sizes['curve']} rejected by the reader"
save(calibration.sbc(judge_draws(draws, truth), names, about=about), figures.sbc)
if figures.get("pairs"):
    save(calibration.recovery(recovery(draws, truth), truth, names, about=about), figures.recovery)
    draw_contraction(scale_of(data), figures.contraction)
    draw_pairs(open_store(files.prior), scale_of(data), figures.pairs)
