"""Networks side by side, one row each: how good, how fast, how large."""

from time import process_time

import numpy as np
import pandas as pd
import xarray as xr

from breaker.paper.calibration import judge_draws
from breaker.paper.posterior import Posterior

_CURVES, _DRAWS = 10, 500  # of the timing


def draws_per_second(posterior: Posterior, measured: np.ndarray) -> float:
    """Return how many draws the posterior makes in a second of processor time.

    Args:
        measured: Records, ``(n, t)``, mm; a few of them are inferred, curve after curve.
    """
    rng = np.random.default_rng(0)  # what is drawn does not matter
    noise = rng.standard_normal((min(_CURVES, len(measured)), _DRAWS, len(posterior.outputs)))
    posterior.sample(measured[:1], noise[:1])  # the first call sets things up
    start = process_time()
    posterior.sample(measured[: len(noise)], noise)
    return noise.shape[0] * noise.shape[1] / (process_time() - start)


def network_row(
    network: str,
    posterior: Posterior,
    validation: xr.Dataset,
    judged: pd.DataFrame,
    history: xr.Dataset,
    training: pd.DataFrame,
) -> pd.DataFrame:
    """Sum up one trained network.

    Args:
        validation: What ``amortised.validate`` returns.
        judged: What ``posterior_tables.summary`` returns.
        history: What ``Trainer.run`` returns, with the held-out log density.
        training: Snakemake's benchmark of the training.

    Returns:
        One row with ``held_out_log_density`` (nats, standardised outputs) and its standard error,
        ``gap_nats`` and its standard error, ``efficiency_median`` and ``efficiency_10_percent``,
        ``calibration_p``, the smallest times all, and ``calibrated``, ``draws_per_second`` and
        ``training_seconds`` of processor time, ``solver_steps`` and ``weights``, their number.
    """
    calibration = judge_draws(validation.draws.values, validation.truth.values)
    columns = ["gap_nats", "gap_se", "efficiency_median", "efficiency_10_percent"]
    return pd.DataFrame(
        {
            "network": [network],
            "held_out_log_density": [history.attrs["held_out_log_density"]],
            "held_out_log_density_se": [history.attrs["held_out_log_density_se"]],
            **{name: [judged[name].iloc[0]] for name in columns},
            "calibration_p": [calibration.p_value],
            "calibrated": [not calibration.outside.any()],
            "draws_per_second": [draws_per_second(posterior, validation.measured.values)],
            "training_seconds": [training.cpu_time.iloc[0]],
            "solver_steps": [posterior.steps],
            "weights": [sum(weight.numel() for weight in posterior.parameters())],
        }
    )
