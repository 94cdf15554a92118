"""State of a drive at every measured operation, each from its record alone."""

from collections.abc import Sequence

import numpy as np
import xarray as xr
from tqdm import tqdm

from breaker.common.randomness import generator
from breaker.family.inputs import network_record
from breaker.family.membership import choose_family
from breaker.family.networks import StateNetwork
from breaker.family.shape import shape_of
from breaker.model.parameters import NAMES, PARAMETERS


def infer_operations(
    curves: xr.Dataset,
    families: Sequence[StateNetwork],
    draws: int,
    seed: int,
    misfit_p_value: float,
) -> xr.Dataset:
    """Infer measured operations, each in the family for which its record gives most evidence.

    Args:
        curves: Curves in the layout of ``read_curves``; rejected ones stay, with their reason.
        families: State networks, in the order in which they are tried.
        misfit_p_value: p-value of the membership below which nothing is inferred from a record.

    Returns:
        ``curves`` without samples and quantities, with ``draws (operation, draw, output)`` of the
        parameters, physical units, which do not depend on other operations; and over ``operation``
        the ``family``, the ``p_value`` of membership and the flag ``misfit``.
    """
    motion, count = curves.attrs["motion"], curves.sizes["operation"]
    sign = 1.0 if motion == "closing" else -1.0
    values = np.full((count, draws, len(PARAMETERS)), np.nan, dtype=np.float32)
    p_value, names = np.full(count, np.nan), np.full(count, "", dtype=object)
    reasons = curves.reason.values.astype(object)
    accepted = np.flatnonzero(curves.accepted.values)
    for i in tqdm(accepted, desc=f"inferring {motion}", mininterval=5, unit="operation"):
        row = curves.isel(operation=i)
        step = 1.0 / float(row.rate)
        if (shape := shape_of(sign * row.record.values, step)) is None:
            reasons[i] = f"{row.file.item()}: shows no motion from one rest to another"
            continue
        seen = network_record(shape, float(row.record_noise), float(row.record_colour), step)
        network, ((_, match),), fits = choose_family(
            families, lambda net, seen=seen: [(motion, net.match(motion, seen))], misfit_p_value
        )
        p_value[i], names[i] = match.p_value, network.settings["family"]
        if fits:
            rng = generator(seed, "levels of operations", motion, int(row.operation))
            values[i] = network.draw({motion: seen}, draws, rng).theta
    units = [parameter.unit for parameter in PARAMETERS]
    return (
        curves.drop_dims(["time", "sample", "quantity"], errors="ignore")
        .assign(
            draws=(("operation", "draw", "output"), values),
            family=("operation", names.astype(str)),
            p_value=("operation", p_value),
            misfit=("operation", p_value < misfit_p_value),
            reason=("operation", reasons.astype(str)),
            accepted=("operation", reasons == ""),
        )
        .assign_coords(output=list(NAMES), output_unit=("output", units))
    )
