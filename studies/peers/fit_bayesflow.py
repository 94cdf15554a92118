"""BayesFlow: a coupling flow behind a TimeSeriesNetwork, both as shipped, by its BasicWorkflow.

Rows of the bank reach it as an online simulator does, and noise and zero as an augmentation. So its
own schedule (5 % warm-up, then a cosine) spans the budget, which is less than one pass.
"""

import bayesflow as bf
import keras
import numpy as np
import xarray as xr

from breaker.common.randomness import generator, seed_integer
from breaker.paper.bank import truth
from breaker.paper.joint_model import Model

_EPOCHS, _BATCH = 10, 32


class _Rows(bf.simulators.Simulator):
    """Rows of a bank, drawn at random."""

    def __init__(self, travel: np.ndarray, z: np.ndarray, rng: np.random.Generator) -> None:
        self.travel, self.z, self.rng = travel, z.astype(np.float32), rng

    def sample(self, batch_shape: int | tuple[int, ...], **_) -> dict[str, np.ndarray]:
        rows = self.rng.integers(len(self.z), size=batch_shape)
        return {"z": self.z[rows], "records": self.travel[rows][..., None]}


class BayesFlow:
    """An estimator of BayesFlow, in standardised outputs."""

    unit = _EPOCHS

    def train(self, bank: xr.Dataset, model: Model, steps: int, seed: int) -> None:
        """Train on a bank for so many steps."""
        keras.utils.set_random_seed(seed_integer(seed, "bayesflow") % 2**32)
        rng, sensor = generator(seed, "bayesflow batches"), model.sensor

        def measure(records: np.ndarray) -> np.ndarray:
            noise = sensor.noise_sd * rng.standard_normal(records.shape, dtype=np.float32)
            zero = rng.standard_normal((len(records), 1, 1), dtype=np.float32)
            return records + noise + sensor.zero_sd * zero

        workflow = bf.BasicWorkflow(
            simulator=_Rows(bank.travel.values, model.standardise(truth(bank, model)), rng),
            inference_variables="z",
            summary_variables="records",
            summary_network=bf.networks.TimeSeriesNetwork(),
        )
        workflow.fit_online(
            epochs=_EPOCHS,
            num_batches_per_epoch=steps // _EPOCHS,
            batch_size=_BATCH,
            augmentations={"records": measure},
            verbose=0,
        )
        self.estimator = workflow.estimator

    def sample(self, measured: np.ndarray, draws: int, seed: int) -> np.ndarray:
        """Draw ``(o, d, q)`` given records ``(o, t)``, mm."""
        conditions = {"records": measured.astype(np.float32)[..., None]}
        drawn = self.estimator.sample(num_samples=draws, conditions=conditions, seed=seed)
        return np.asarray(drawn["z"], dtype=np.float64)

    def log_prob(self, measured: np.ndarray, z: np.ndarray) -> np.ndarray:
        """Return the log density of ``(o, d, q)`` given records, ``(o, d)``."""
        o, d, q = z.shape
        records = np.repeat(measured.astype(np.float32), d, axis=0)[..., None]
        data = {"z": z.reshape(o * d, q).astype(np.float32), "records": records}
        return np.asarray(self.estimator.log_prob(data)).reshape(o, d)
