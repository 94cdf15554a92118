"""BayesFlow: flow matching behind a TimeSeriesNetwork, through its BasicWorkflow.

Rows of the bank reach it as an online simulator does, noise and zero as an augmentation, so that
its own schedule (5 % warm-up, then a cosine) spans the budget, which is less than one pass over
the bank.
"""

from pathlib import Path

import bayesflow as bf
import keras
import numpy as np

from breaker.model import generator, seed_integer

__all__ = ["BayesFlow"]

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
    """An approximator of BayesFlow, in standardised outputs.

    Args:
        tool: "bayesflow_shipped", "bayesflow_tuned" or "bayesflow_jax", which is the tuned one.
    """

    unit = _EPOCHS

    def __init__(self, tool: str) -> None:
        self.tool = tool
        self.shipped = tool == "bayesflow_shipped"
        self.batch = 32 if self.shipped else 256
        self.steps: int | str = "adaptive"

    # Training.

    def settings(self) -> dict:
        """Return what a table has to say about the arm."""
        tuned = (
            "standardize='all', no dropout, time_power_law_alpha=-0.5, batch 256, "
            "filters (16, 32), kernels (7, 5), strides (4, 2)"
        )
        return {
            "backend": keras.backend.backend(),
            "estimator": "FlowMatching, TimeSeriesNetwork, BasicWorkflow",
            "optimiser": "Adam 5e-4, 5 % warm-up and cosine over the budget, clipnorm 1.5",
            "batch": self.batch,
            "deviations": "none but the budget" if self.shipped else tuned,
        }

    def _workflow(self, simulator: _Rows) -> bf.BasicWorkflow:
        if self.shipped:
            summary, inference = bf.networks.TimeSeriesNetwork(), bf.networks.FlowMatching()
            options = {}
        else:
            summary = bf.networks.TimeSeriesNetwork(
                filters=(16, 32), kernel_sizes=(7, 5), strides=(4, 2), dropout=0.0
            )
            inference = bf.networks.FlowMatching(
                subnet_kwargs={"dropout": 0.0}, time_power_law_alpha=-0.5
            )
            options = {"standardize": "all"}
        return bf.BasicWorkflow(
            simulator=simulator,
            summary_network=summary,
            inference_network=inference,
            inference_variables="z",
            summary_variables="records",
            **options,
        )

    def train(self, travel: np.ndarray, z: np.ndarray, sensor, steps: int, seed: int) -> dict:
        """Train on noise-free curves ``(n, t)`` and outputs ``(n, q)`` for so many steps."""
        keras.utils.set_random_seed(seed_integer(seed, "bayesflow") % 2**32)
        rng = generator(seed, "bayesflow batches")

        def measure(records: np.ndarray) -> np.ndarray:
            noise = sensor.noise_sd * rng.standard_normal(records.shape, dtype=np.float32)
            zero = rng.standard_normal((len(records), 1, 1), dtype=np.float32)
            return records + noise + sensor.zero_sd * zero

        workflow = self._workflow(_Rows(travel, z, rng))
        history = workflow.fit_online(
            epochs=_EPOCHS,
            num_batches_per_epoch=steps // _EPOCHS,
            batch_size=self.batch,
            augmentations={"records": measure},
            verbose=0,
        )
        self.approximator = workflow.approximator
        return {
            "curves": steps // _EPOCHS * _EPOCHS * self.batch,
            "parameters": self.approximator.count_params(),
            "final_loss": float(history.history["loss"][-1]),
        }

    # Files.

    def save(self, folder: Path) -> None:
        """Write the approximator."""
        self.approximator.save(folder / "approximator.keras")

    def load(self, folder: Path, samples: int, outputs: int) -> None:
        """Read the approximator."""
        self.approximator = keras.saving.load_model(folder / "approximator.keras")

    # Inference: records (o, t), outputs (o, d, q).

    def sample(self, measured: np.ndarray, draws: int, seed: int) -> np.ndarray:
        """Draw ``(o, d, q)`` by the default solver, or as ``choose_solver`` has chosen."""
        return self._sample(measured, draws, seed=seed, steps=self.steps)

    def sample_with_calls(self, measured: np.ndarray, draws: int, calls: int) -> np.ndarray:
        """Draw ``(o, d, q)`` with so many calls of the velocity network, by Euler's rule."""
        return self._sample(measured, draws, seed=0, method="euler", steps=calls)

    def _sample(self, measured: np.ndarray, draws: int, **options) -> np.ndarray:
        conditions = {"records": measured.astype(np.float32)[..., None]}
        found = self.approximator.sample(num_samples=draws, conditions=conditions, **options)
        return np.asarray(found["z"], dtype=np.float64)

    def log_prob(self, measured: np.ndarray, z: np.ndarray) -> np.ndarray:
        """Log density of ``(o, d, q)`` given records, ``(o, d)``.

        By the default solver, or as ``choose_solver`` has chosen.
        """
        o, d, q = z.shape
        records = np.repeat(measured.astype(np.float32), d, axis=0)[..., None]
        data = {"z": z.reshape(o * d, q).astype(np.float32), "records": records}
        return np.asarray(self.approximator.log_prob(data, steps=self.steps)).reshape(o, d)

    def choose_solver(self, measured: np.ndarray, z: np.ndarray) -> str:
        """Choose fixed solver steps for many draws and densities: the default takes too long.

        The fewest whose densities of ``z``, ``(o, d, q)``, are those of the default solver.
        """
        exact = self.log_prob(measured, z)
        for steps in _FIXED:
            self.steps = steps
            difference = float(np.abs(self.log_prob(measured, z) - exact).mean())
            if difference < _CLOSE:
                return f"Tsit5, {steps} fixed steps: {difference:.2g} nats from the default"
        self.steps = "adaptive"
        return "the default: no number of fixed steps came close"
