"""Draw calibration, contraction and recovery of posteriors of simulated records (Figs. 4, 5, 6).

A rule names the figures that it wants as its outputs: ``sbc``, ``contraction``, ``recovery``.
"""

import json

from breaker.common.zarr_store import open_store
from breaker.figures import calibration
from breaker.figures.panels import SOURCES
from breaker.figures.style import save
from breaker.model.parameters import is_logarithmic, prior_sds
from breaker.paper.calibration import judge_draws
from breaker.paper.validation import parameters_of, recovery, scores, with_width
from breaker.workflow.jobs import start

log = start(snakemake)
params, wildcards, figures = snakemake.params, snakemake.wildcards, snakemake.output
data = parameters_of(open_store(snakemake.input.validation)).load()
names, draws, truth = data.output.values, data.draws.values, data.truth.values
source = wildcards.get("source") or wildcards.motion
about = f"{SOURCES[source]}: {params.subject}"

rejected = sum(json.loads(data.attrs.get("rejected", "{}")).values())
if rejected:
    about += f", {rejected} of {rejected + data.sizes['curve']} rejected by the reader"
save(calibration.sbc(judge_draws(draws, truth), names, about=about), figures.sbc)
if file := figures.get("recovery"):
    save(calibration.recovery(recovery(draws, truth), names, about=about), file)
if file := figures.get("contraction"):
    # A family is wider than the prior of its medians: its own spread counts.
    prior = params.get("prior")
    sds = prior_sds(names, prior, params.onset_sd) if prior else None
    wide = with_width(data)
    if alike := data.sizes["curve"] - wide.sizes["curve"]:
        log.warning("%d curves are left out, whose draws are all the same", alike)
    log_scale = is_logarithmic(names)
    judged = scores(wide.draws.values, wide.truth.values, prior_sd=sds, log=log_scale)
    limit = snakemake.input.get("limit")  # none is known of a family
    limit = open_store(limit).contraction.mean("curve").values if limit else None
    save(calibration.contraction(judged, names, about=about, limit=limit), file)
