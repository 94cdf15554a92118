"""Join single operations and trends into decisions, alarms and the first page."""

import pandas as pd

from breaker.decisions import (
    alarm_table,
    dated,
    decide,
    health,
    join,
    judge,
    remaining,
    step_table,
    trust_table,
    verdict,
    with_measured,
)
from breaker.mechanism import from_list, speeds_of
from breaker.stores import describe, open_store, save
from breaker.synthetic import true_lives
from breaker.workflow import start

log = start(snakemake)
params, found = snakemake.params, snakemake.input
wear_model, alarm = params.wear_model, params.alarm
limits = from_list(params.limits, params.motions, speeds_of(params.speeds))
condition = join([open_store(file).load() for file in found.conditions])
trends = {data.attrs["source"]: data for data in (open_store(f).load() for f in found.trends)}
curves = dict(zip(params.motions, (open_store(file) for file in found.curves), strict=True))
together = "both" in trends and trends["both"].sizes["operation"] > 0
used = {source: trends[source] for source in (["both"] if together else params.motions)}
by_source = dict(zip(trends, (open_store(file).load() for file in found.trust), strict=True))
trust = trust_table([by_source[source] for source in used])

measured = {"record": open_store(found.measured).load()} if found.measured else {}
left = remaining(used | measured, limits, condition.operation.values)
followed = with_measured(used, measured.get("record"))
judged = judge(condition, left, followed, alarm=alarm, toward=wear_model["toward"])
left = left.assign(told=judged.told)
if found.truth:
    left = left.assign(true_lives(open_store(found.truth).load(), limits))
asked = {"alarm": alarm, "notice": wear_model["notice"], "measured": measured.get("record")}
rows = decide(judged, left, used, curves, trust, **asked)
page = verdict(judged, left, followed, rows, trust, baseline=wear_model["baseline"])
log.info("%s %s %s %s", *(page.attrs[name] for name in ("headline", "wearing", "left", "trust")))

settings = {"limits": params.limits, "alarm": alarm, "wear_model": wear_model}
save(describe(health(judged, alarm), "health", **settings), snakemake.output.health)
save(describe(left, "remaining life", **settings), snakemake.output.remaining)
save(describe(page, "verdict", **settings), snakemake.output.verdict)
rows.to_csv(snakemake.output.decisions, index=False, float_format="%.10g")
alarms = alarm_table(judged, {limit.name: limit.motion for limit in limits})
alarms = dated(pd.concat([alarms, step_table(used)], ignore_index=True), rows)
alarms.to_csv(snakemake.output.alarms, index=False, float_format="%.5g")
trust.to_csv(snakemake.output.trust, index=False, float_format="%.3g")
