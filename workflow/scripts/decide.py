"""Judge the limits of a drive: tables, and the sentences of the first page."""

import json
from pathlib import Path

from breaker.common.zarr_store import describe, open_store, save
from breaker.prognosis.limit_states import states_of
from breaker.prognosis.tables import change_table, decide, limit_table, sentences
from breaker.workflow.jobs import start

log = start(snakemake)
planning, output = snakemake.params.planning, snakemake.output
life = open_store(snakemake.input.life).load()
stands = states_of(life, planning)
decisions, limits = decide(life, stands), limit_table(life, stands)
said = sentences(life, decisions, limits, snakemake.params.advice)
log.info(" ".join(said))

save(describe(stands, "standing", planning=planning), output.standing)
decisions.to_csv(output.decisions, index=False, float_format="%.10g")
limits.to_csv(output.limits, index=False, float_format="%.6g")
change_table(life).to_csv(output.changes, index=False, float_format="%.4g")
Path(output.words).write_text(json.dumps({"sentences": said}, indent=1), encoding="utf-8")
