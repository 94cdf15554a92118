"""The network of a family of drives in training: inputs in, density of outputs out."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor, nn

from breaker.common.randomness import seed_integer
from breaker.networks.blocks import ResidualMLP
from breaker.networks.mixture import AutoregressiveMixture
from breaker.paper.posterior.training_batches import DrawnRows


class FamilyNetwork(nn.Module):
    """Residual network and autoregressive mixture, of ``trained_network.Network`` with torch.

    Args:
        settings: Sizes: ``width``, ``blocks``, ``features``, ``components`` and ``head``.
        name: What it is of, for messages.
        sizes: Numbers of inputs and outputs.
        atoms: Which outputs may be exactly 0.
        seed: Seed of the first weights.
    """

    def __init__(
        self,
        settings: Mapping,
        name: str,
        sizes: tuple[int, int],
        *,
        atoms: Sequence[bool],
        seed: int,
    ) -> None:
        super().__init__()
        self.name, features = name, settings["features"]
        inputs, outputs = sizes
        with torch.random.fork_rng(devices=[]):
            torch.manual_seed(seed_integer(seed, "first weights", name))
            self.summary = ResidualMLP(
                inputs, settings["width"], features, blocks=settings["blocks"]
            )
            self.inference = AutoregressiveMixture(
                outputs,
                features,
                atoms=atoms,
                components=settings["components"],
                width=settings["head"],
            )

    def loss(self, x: Tensor, y: Tensor, there: Tensor) -> Tensor:
        """Minus the log density of rows ``(n, i)``, ``(n, q)``, ``(n, q)``, ``(n,)``."""
        return -self.inference.log_prob(y, self.summary(x), there).sum(dim=1)

    validation_loss = loss


@dataclass
class FamilyRows(DrawnRows):
    """Rows of a family's bank, whose records are made anew for each batch.

    Attributes:
        drives: Numbers of the drives, ``(n,)``.
        make: What takes drives ``(n,)`` and a generator, and returns inputs ``(n, i)``, outputs
            ``(n, q)`` and which of these are there.
        device: Of the training.
    """

    drives: np.ndarray
    make: Callable[[np.ndarray, np.random.Generator], tuple[np.ndarray, ...]]
    device: torch.device | str = "cpu"

    def __len__(self) -> int:
        return len(self.drives)

    def draw(self, rows: Tensor, rng: torch.Generator) -> list[Tensor]:
        """Return a batch for ``FamilyNetwork.loss``."""
        seed = torch.randint(2**62, (), generator=rng, device=rng.device).item()
        made = self.make(self.drives[rows.cpu().numpy()], np.random.default_rng(seed))
        return [torch.as_tensor(each, dtype=torch.float32, device=self.device) for each in made]
