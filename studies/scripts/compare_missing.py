"""Put calibration and widths of posteriors from records with missing samples into a table."""

import pandas as pd

from breaker.common.zarr_store import open_store
from breaker.paper.validation.calibration import judge_draws
from breaker.workflow.jobs import start
from studies.networks.missing import over_curves, widening

log = start(snakemake)
data = {key: open_store(path) for key, path in snakemake.input.items() if key != "code"}
names = data["missing"].output.values

calibration = judge_draws(data["missing"].draws.values, data["missing"].truth.values)
columns = {"outside": calibration.outside}
for of, whole, missing in (
    ("network", "whole", "missing"),
    ("exact", "exact_whole", "exact_missing"),
):
    ratios = over_curves(widening(data[whole], data[missing], names))
    ends = ("5", "50", "95", "curves")
    columns |= {f"{of}_{end}": row for end, row in zip(ends, ratios, strict=True)}
table = pd.DataFrame({"output": names} | columns | {"calibration_p": calibration.p_value})
log.info("\n%s", table.to_string(index=False))
table.to_csv(snakemake.output[0], index=False, float_format="%.4g")
