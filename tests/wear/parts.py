"""Series of drives of the model, and parts of them, to follow them in pieces."""

from dataclasses import replace

import numpy as np
import xarray as xr

from breaker.wear.series import Series
from breaker.wear.state import State


def recorded(models, operations, z, rng, *, scatter, temperature=None):
    """Records of standardised parameters ``(o, p)``, each of which scatters by such a share."""
    prior = next(iter(models.values())).prior
    z = z + scatter / prior.log_sds * rng.standard_normal(z.shape)
    records, outputs = {}, {}
    for motion, model in models.items():
        outputs[motion] = np.column_stack([z, rng.standard_normal(len(z))])
        curves = model.curves(model.destandardise(outputs[motion]))
        records[motion] = model.sensor.corrupt(curves, rng)
    return Series(operations[: len(z)], records, outputs, None, temperature)


def part(series, chosen):
    """Chosen operations of a series; its events go by their numbers."""
    known = series.temperature
    return replace(
        series,
        operations=series.operations[chosen],
        records={m: each[chosen] for m, each in series.records.items()},
        outputs={m: each[chosen] for m, each in series.outputs.items()},
        temperature=None if known is None else known[chosen],
    )


def assert_goes_on(follower, series, split, whole):
    """Bit by bit as in one run, which gave ``whole``, if the state is stored in between."""
    state, first = follower.follow(follower.begin(series), part(series, slice(0, split)))
    again = State.from_dataset(state.to_dataset())
    end, second = follower.follow(again, part(series, slice(split, None)))
    joined = xr.concat([first, second], dim="operation", data_vars="minimal")
    xr.testing.assert_identical(joined, whole[1])
    xr.testing.assert_identical(end.to_dataset(), whole[0].to_dataset())
