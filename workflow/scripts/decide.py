"""Say how a drive stands to its limits: tables, and the sentences of the first page."""

import json
from pathlib import Path

from breaker.common.text import save_frame
from breaker.common.zarr_store import describe, save
from breaker.prognosis.life import Life, decided
from breaker.prognosis.page import headline, limit_words, look_first, since_new, trust
from breaker.prognosis.tables import change_table, limit_table
from breaker.records.curves import open_curves
from breaker.workflow.jobs import start

UNUSED = ("travel", "record", "measured", "measured_sd", "measured_reason", "remarks")

log = start(snakemake)
planning, output = snakemake.params.planning, snakemake.output
life = Life.load(snakemake.input.life)
inputs = snakemake.input
curves = {m: open_curves(inputs[m], without=UNUSED) for m in snakemake.params.motions}
stands, decisions = decided(life, curves, planning)
limits = limit_table(life.forecast, stands)
changes = change_table(life.forecast)
sentences = [headline(decisions, limits), since_new(changes, life.forecast)]
sentences += [*look_first(decisions, limits, snakemake.params.advice), trust(life.forecast)]
log.info(" ".join(sentences))

save(describe(stands, "standing", planning=planning), output.standing)
save_frame(decisions, output.decisions, digits=10)
save_frame(limits, output.limits, digits=6)
save_frame(changes, output.changes, digits=4)
words = {"sentences": sentences, "limits": limit_words(limits).to_dict("list")}
Path(output.words).write_text(json.dumps(words, indent=1), encoding="utf-8")
