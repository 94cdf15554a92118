"""Join single operations and trends into alarms, decisions and the first page."""

import pandas as pd

from breaker.decisions import (
    alarm_table,
    decide,
    health,
    join,
    remaining,
    step_table,
    trust_table,
    verdict,
)
from breaker.mechanism import from_list, speeds_of
from breaker.stores import describe, open_store, save
from breaker.synthetic import true_lives
from breaker.workflow import start

log = start(snakemake)
params, found = snakemake.params, snakemake.input
limits = from_list(params.limits, params.motions, speeds_of(params.speeds))
condition = join([open_store(file).load() for file in found.conditions])
trends = {data.attrs["source"]: data for data in (open_store(f).load() for f in found.trends)}
curves = dict(zip(params.motions, (open_store(file) for file in found.curves), strict=True))
together = "both" in trends and trends["both"].sizes["operation"] > 0
used = {source: trends[source] for source in (["both"] if together else params.motions)}

left = remaining(used, limits)
if found.truth:
    left = left.assign(true_lives(open_store(found.truth).load(), limits))
judged = health(condition, left, params.alarm)
rows = decide(judged, left, used, curves, params.wear_model)
by_source = dict(zip(trends, (open_store(file).load() for file in found.trust), strict=True))
trust = trust_table([by_source[source] for source in used])
page = verdict(judged, left, used, rows, trust, params.wear_model)
log.info("%s %s %s %s", *(page.attrs[name] for name in ("healthy", "wearing", "left", "trust")))

settings = {"limits": params.limits, "alarm": params.alarm, "wear_model": params.wear_model}
save(describe(judged, "health", **settings), snakemake.output.health)
save(describe(left, "remaining life", **settings), snakemake.output.remaining)
save(describe(page, "verdict", **settings), snakemake.output.verdict)
rows.to_csv(snakemake.output.decisions, index=False, float_format="%.5g")
alarms = alarm_table(
    limits, judged.operation.values, judged.alarm.values, judged.probability.values
)
alarms = pd.concat([alarms, step_table(used)], ignore_index=True)
if "date" in rows:
    dates = rows.set_index("operation").date
    alarms = alarms.assign(from_date=alarms.from_operation.map(dates))
alarms.to_csv(snakemake.output.alarms, index=False, float_format="%.5g")
trust.to_csv(snakemake.output.trust, index=False, float_format="%.3g")
