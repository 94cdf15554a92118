"""The network of a family of drives in training: inputs in, density of outputs out."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
import torch
from torch import Tensor, nn
from torch.utils.data import DataLoader, Dataset

from breaker.common.randomness import seed_integer
from breaker.networks.blocks import ResidualMLP
from breaker.networks.mixture import AutoregressiveMixture
from breaker.networks.training import DrawnRows

_ENDLESS = 2**62  # steps; as many are asked for as a training has


class FamilyNetwork(nn.Module):
    """Residual network and autoregressive mixture, of ``trained_network.Network`` with torch.

    Args:
        settings: Sizes: ``width``, ``blocks``, ``features``, ``components`` and ``head``.
        name: What it is of, for messages.
        sizes: Numbers of inputs and outputs.
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

    A batch follows from the seed of the training and the step alone. So other processes may make
    batches ahead, and a training that was killed ends with the same weights.

    Attributes:
        drives: Numbers of the drives, ``(n,)``.
        make: What takes drives ``(n,)`` and a generator, and returns inputs ``(n, i)``, outputs
            ``(n, q)`` and which of these are there.
        workers: Processes, forked, that make batches ahead; 0 makes each when it is asked for.
    """

    drives: np.ndarray
    make: Callable[[np.ndarray, np.random.Generator], tuple[np.ndarray, ...]]
    device: torch.device | str = "cpu"
    workers: int = 0
    _next: int = field(default=-1, init=False)
    _ahead: Iterator[list[Tensor]] = field(default=iter(()), init=False)

    def __len__(self) -> int:
        return len(self.drives)

    def batch(self, step: int, n: int, rng: torch.Generator) -> list[Tensor]:
        """Return the batch of ``n`` rows of a step, for ``FamilyNetwork.loss``.

        Raises:
            ValueError: If there are to be workers, and the system does not fork processes.
        """
        if step != self._next:
            self._ahead = iter(
                DataLoader(
                    _Batches(self, n, rng.initial_seed()),
                    sampler=range(step, _ENDLESS),
                    batch_size=None,  # an item is a batch
                    num_workers=self.workers,
                    multiprocessing_context="fork" if self.workers else None,
                    pin_memory=torch.device(self.device).type == "cuda",
                    generator=torch.Generator(),  # that of torch stays as it is
                )
            )
        self._next = step + 1
        return [each.to(self.device, non_blocking=True) for each in next(self._ahead)]

    def draw(self, rows: Tensor, rng: torch.Generator) -> list[Tensor]:
        """Return rows ``(n,)`` for ``FamilyNetwork.loss``."""
        seed = torch.randint(2**62, (), generator=rng, device=rng.device).item()
        made = self.made(self.drives[rows.cpu().numpy()], np.random.default_rng(seed))
        return [each.to(self.device) for each in made]

    def made(self, drives: np.ndarray, rng: np.random.Generator) -> list[Tensor]:
        """Return rows of drives ``(n,)``, on the processor."""
        return [torch.as_tensor(each, dtype=torch.float32) for each in self.make(drives, rng)]


@dataclass
class _Batches(Dataset):
    """Batches by their steps."""

    rows: FamilyRows
    n: int
    seed: int

    def __getitem__(self, step: int) -> list[Tensor]:
        rng = np.random.default_rng([self.seed, step])
        return self.rows.made(rng.choice(self.rows.drives, self.n), rng)
