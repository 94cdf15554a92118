"""Score all judged rigs: coverage, errors, false alarms and power."""

import pandas as pd

from breaker.synthetic import score_lives, score_power
from breaker.workflow import start

log = start(snakemake)
judged = snakemake.params.judged
rows = {
    kind: pd.concat(pd.read_csv(file, dtype={"name": str}) for file in snakemake.input[kind])
    for kind in ("lives", "faults")
}
common = {"settle": snakemake.params.settle, "every": judged["every"]}
tables = {
    "lives": score_lives(rows["lives"], operations=judged["operations"], **common),
    "faults": score_power(rows["faults"], records=judged["fault_records"], **common),
}
for kind, table in tables.items():
    log.info("%s\n%s", kind, table.to_string(index=False))
    table.to_csv(snakemake.output[kind], index=False, float_format="%.4g")
