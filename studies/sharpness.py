"""How sharp the networks are that ship, by records of one sensor: the tables of docs/evidence.md.

    python -m studies.sharpness     # writes docs/sharpness.csv, in two minutes of one core

Levels from single operations with the noise of the defaults, 0.7 % of the stroke, the size given;
changes from means with a fifth of that noise, of drives that wear in a few parameters or in most.
"""

import numpy as np
import pandas as pd

from breaker.common.randomness import generator
from breaker.configuration.data_files import family_of
from breaker.configuration.loading import load
from breaker.family.bank import simulate_family
from breaker.family.drive_family import Family
from breaker.family.networks import shipped_networks
from breaker.family.training_rows import rows_of, sample_rows
from breaker.model.parameters import NAMES
from breaker.model.prior import Prior
from breaker.paper.validation import family_quality

DRIVES, DRAWS = 5000, 300
NOISE, OF_MEANS = (0.0074, 0.0075), (0.0015, 0.00151)  # share of the stroke


def main() -> None:
    config = load()
    family = Family(Prior.from_settings(config["prior"]), family_of(config["family"]["name"]))
    bank = simulate_family(family, DRIVES, generator(1, "sharpness"))
    levels, changes = next(shipped_networks())
    tables = []
    for source in ("closing", "opening", "both"):
        rows = rows_of("levels", bank, levels, noise=NOISE, known_size=1.0)
        data = sample_rows(levels, rows, source, DRAWS, generator(2, source))
        table = family_quality(data, log=True)
        tables.append(table.assign(network="levels", motions=source, drives=DRIVES))
    for k, kind in enumerate(bank.wear.kinds):
        some = bank.isel(drive=np.flatnonzero(bank.wear.values == k))
        rows = rows_of("changes", some, changes, noise=OF_MEANS)
        data = sample_rows(changes, rows, "both", DRAWS, generator(3, kind))
        table = family_quality(data, log=False)
        table["unchanged"] = (np.abs(data.draws) < 1e-3).mean(["curve", "draw"]).values
        about = {"network": "changes", "motions": "both", "drives": some.sizes["drive"]}
        tables.append(table.assign(wear=kind, **about))
    result = pd.concat(tables).drop(columns=["calibration_p", "calibrated"])
    result = result[result.output.isin(NAMES) | result.output.str.contains("touch|part")]
    print(result.to_string(index=False))
    result.to_csv("docs/sharpness.csv", index=False, float_format="%.3g")


if __name__ == "__main__":
    main()
