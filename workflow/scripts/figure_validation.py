"""Draw calibration, z-scores or recovery of posteriors of simulated records (Figs. 4, 5, 6)."""

import json

from breaker.common.zarr_store import open_store
from breaker.figures import validation
from breaker.figures.style import save
from breaker.model.parameters import is_logarithmic, prior_sds
from breaker.paper.calibration import judge_draws
from breaker.paper.validation import parameters_of, recovery, scores, with_width
from breaker.workflow.jobs import start

log = start(snakemake)
params, wildcards = snakemake.params, snakemake.wildcards
data = parameters_of(open_store(snakemake.input.validation))
names, posteriors = data.output.values, (data.draws.values, data.truth.values)
words = {"motion": wildcards.get("source") or wildcards.motion, **params.get("words", {})}
if rejected := json.loads(data.attrs.get("rejected", "{}")):
    left_out = sum(rejected.values())
    words["subject"] += f", {left_out} of {left_out + data.sizes['curve']} rejected by the reader"

if params.shows == "ranks":
    figure = validation.sbc(judge_draws(*posteriors), names, **words)
elif params.shows == "recovery":
    figure = validation.recovery(recovery(*posteriors), names, **words)
else:
    # A family is wider than the prior of its medians: its own spread counts.
    of_prior = None if wildcards.get("source") else prior_sds(names, params.prior, params.onset_sd)
    wide = with_width(data)
    if alike := data.sizes["curve"] - wide.sizes["curve"]:
        log.warning("%d curves are left out, whose draws are all the same", alike)
    posteriors = wide.draws.values, wide.truth.values
    judged = scores(*posteriors, prior_sd=of_prior, log=is_logarithmic(names))
    limit = snakemake.input.get("limit")  # none is known of a family
    limit = open_store(limit).contraction.mean("curve").values if limit else None
    figure = validation.contraction(judged, names, limit=limit, **words)
save(figure, snakemake.output[0])
