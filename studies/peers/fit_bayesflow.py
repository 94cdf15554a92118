"""BayesFlow: coupling flow or flow matching behind a TimeSeriesNetwork, by its BasicWorkflow.

Rows of the bank reach it as an online simulator does, noise and zero as an augmentation, so that
its own schedule (5 % warm-up, then a cosine) spans the budget, which is less than one pass over
the bank.
"""

import bayesflow as bf
import keras
import numpy as np
import xarray as xr

from breaker.common.randomness import generator, seed_integer
from breaker.paper.joint_model import Model
from studies.peers.common import truth

_EPOCHS = 10  # a training's steps are spread over as many
_FIXED = (4, 8, 16, 32)  # solver steps tried for many draws and densities
_CLOSE = 0.01  # nats that they may differ by from the default solver, on average


class _Rows(bf.simulators.Simulator):
    """Rows of a bank, drawn at random."""

    def __init__(self, travel: np.ndarray, z: np.ndarray, rng: np.random.Generator) -> None:
        self.travel, self.z, self.rng = travel, z.astype(np.float32), rng

    def sample(self, batch_shape: int | tuple[int, ...], **_) -> dict[str, np.ndarray]:
        rows = self.rng.integers(len(self.z), size=batch_shape)
        return {"z": self.z[rows], "records": self.travel[rows][..., None]}


class BayesFlow:
    """An estimator of BayesFlow, in standardised outputs.

    Args:
        arm: "bayesflow_KIND_BACKEND", of kind default, coupling or matching.
    """

    unit = _EPOCHS

    def __init__(self, arm: str) -> None:
        self.kind = arm.split("_")[1]
        self.batch = 32 if self.kind == "default" else 256
        self.options: dict = {}  # of the solver

    # Training.

    def settings(self) -> dict:
        """Return what a table has to say about the arm."""
        tuned = "standardize='all', batch 256, filters (16, 32), kernels (7, 5), strides (4, 2)"
        tuned += ", no dropout"
        networks = {"default": "CouplingFlow", "coupling": "CouplingFlow, spline"}
        return {
            "estimator": f"{networks.get(self.kind, 'FlowMatching')}, TimeSeriesNetwork",
            "optimiser": "Adam 5e-4, 5 % warm-up and cosine over the budget, clipnorm 1.5",
            "batch": self.batch,
            "deviations": "none but the budget" if self.kind == "default" else tuned,
        }

    def _networks(self) -> dict:
        """Return summary and inference network and what is scaled, as BasicWorkflow takes them."""
        if self.kind == "default":
            return {"summary_network": bf.networks.TimeSeriesNetwork()}
        summary = bf.networks.TimeSeriesNetwork(
            filters=(16, 32), kernel_sizes=(7, 5), strides=(4, 2), dropout=0.0
        )
        if self.kind == "coupling":
            network = bf.networks.CouplingFlow(transform="spline", subnet_kwargs={"dropout": 0.0})
        else:
            network = bf.networks.FlowMatching()
        return {"summary_network": summary, "inference_network": network, "standardize": "all"}

    def train(self, bank: xr.Dataset, model: Model, steps: int, seed: int) -> dict:
        """Train on a bank for so many steps."""
        keras.utils.set_random_seed(seed_integer(seed, "bayesflow") % 2**32)
        rng, sensor = generator(seed, "bayesflow batches"), model.sensor

        def measure(records: np.ndarray) -> np.ndarray:
            noise = sensor.noise_sd * rng.standard_normal(records.shape, dtype=np.float32)
            zero = rng.standard_normal((len(records), 1, 1), dtype=np.float32)
            return records + noise + sensor.zero_sd * zero

        workflow = bf.BasicWorkflow(
            simulator=_Rows(bank.travel.values, truth(bank, model), rng),
            inference_variables="z",
            summary_variables="records",
            **self._networks(),
        )
        history = workflow.fit_online(
            epochs=_EPOCHS,
            num_batches_per_epoch=steps // _EPOCHS,
            batch_size=self.batch,
            augmentations={"records": measure},
            verbose=0,
        )
        self.estimator, self.options = workflow.estimator, {}
        return {
            "curves": steps // _EPOCHS * _EPOCHS * self.batch,
            "parameters": self.estimator.count_params(),
            "final_loss": float(history.history["loss"][-1]),
        }

    # Inference: records (o, t), outputs (o, d, q).

    def sample(self, measured: np.ndarray, draws: int, seed: int) -> np.ndarray:
        """Draw ``(o, d, q)`` by the default solver, or as ``choose_solver`` has chosen."""
        conditions = {"records": measured.astype(np.float32)[..., None]}
        found = self.estimator.sample(
            num_samples=draws, conditions=conditions, seed=seed, **self.options
        )
        return np.asarray(found["z"], dtype=np.float64)

    def log_prob(self, measured: np.ndarray, z: np.ndarray) -> np.ndarray:
        """Log density of ``(o, d, q)`` given records, ``(o, d)``.

        By the default solver, or as ``choose_solver`` has chosen.
        """
        o, d, q = z.shape
        records = np.repeat(measured.astype(np.float32), d, axis=0)[..., None]
        data = {"z": z.reshape(o * d, q).astype(np.float32), "records": records}
        return np.asarray(self.estimator.log_prob(data, **self.options)).reshape(o, d)

    def choose_solver(self, measured: np.ndarray, z: np.ndarray) -> str:
        """Choose fixed solver steps for many draws and densities: the default takes too long.

        The fewest whose densities of ``z``, ``(o, d, q)``, are those of the default solver.
        """
        if self.kind != "matching":
            return "one pass"
        exact = self.log_prob(measured, z)
        for steps in _FIXED:
            self.options = {"steps": steps}
            difference = float(np.abs(self.log_prob(measured, z) - exact).mean())
            if difference < _CLOSE:
                return f"Tsit5, {steps} fixed steps: {difference:.2g} nats from the default"
        self.options = {}
        return "the default: no number of fixed steps came close"
