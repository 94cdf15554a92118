"""Training of networks by stochastic gradients: optimisers, batches, checkpoints, the trainer.

The exponential moving average (EMA) of the weights is evaluated by the mean negative log density of
a fixed batch, and the best average is kept. The training loss cannot rank weights: the loss of flow
matching is in coordinates that its base whitens, so it falls where the base is too wide. The
learning rate warms up linearly and falls to zero by a cosine over a fixed number of steps.

All randomness of the batches comes from one generator, whose state is in the checkpoint, or from
its seed and the step. So an interrupted training continues from its checkpoint and ends with the
weights of an uninterrupted one.
"""

import hashlib
import json
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from pickle import UnpicklingError
from typing import NamedTuple

import numpy as np
import torch
import xarray as xr
from torch import Tensor, nn
from torch.utils.data import DataLoader
from tqdm import tqdm

from breaker.common.randomness import seed_integer
from breaker.networks.blocks import Edge, Hidden

# ---- optimisers ----

# Layers whose matrices Muon updates, by name of the optimiser; AdamW updates all other weights.
_MOVED = {"muon": (Hidden,), "muon_edges": (Hidden, Edge)}
# Jordan's polynomial has the steepest slope at 0 with values that stay near 1, so that five rounds
# raise singular values from 1e-3 of the largest to 0.7.
_COEFFICIENTS = (3.4445, -4.7750, 2.0315)
_ROUNDS = 5


def optimisers(
    network: nn.Module, kind: str, *, learning_rate: float, weight_decay: float
) -> list[torch.optim.Optimizer]:
    """Return the optimisers of a network's weights, AdamW and Muon.

    Args:
        kind: "muon", which updates matrices of ``Hidden`` layers by Muon, or "muon_edges", which
            updates matrices of ``Edge`` layers by Muon, too.
    """
    options = {"lr": learning_rate, "weight_decay": weight_decay}
    moved = [layer.weight for layer in network.modules() if isinstance(layer, _MOVED[kind])]
    moved_ids = {id(weight) for weight in moved}
    others = [weight for weight in network.parameters() if id(weight) not in moved_ids]
    return [torch.optim.AdamW(others, **options), Muon(moved, **options)]


class Muon(torch.optim.Optimizer):
    """Momentum made orthogonal, for matrices (Jordan et al., 2024).

    A step has the root mean square of AdamW's step (Liu et al., 2025, "Muon is scalable for LLM
    training"), so that both optimisers take the same learning rate. ``torch.optim.Muon`` computes
    one matrix at a time and only in bfloat16: on small networks it takes a third longer, and on a
    processor without instructions for bfloat16 more than twenty times as long.

    Args:
        weights: Matrices.
        lr: Learning rate.
        weight_decay: Decoupled weight decay.
        momentum: Decay of the gradient's moving average, with Nesterov's step.
    """

    def __init__(
        self, weights: Iterable[Tensor], *, lr: float, weight_decay: float, momentum: float = 0.95
    ) -> None:
        super().__init__(weights, {"lr": lr, "weight_decay": weight_decay, "momentum": momentum})

    @torch.no_grad()
    def step(self, closure: None = None) -> None:
        """Update all weights that have a gradient."""
        del closure  # the loss is not evaluated again
        for group in self.param_groups:
            by_shape: dict[torch.Size, list[Tensor]] = {}
            for weight in group["params"]:
                if weight.grad is not None:
                    by_shape.setdefault(weight.shape, []).append(weight)
            for shape, weights in by_shape.items():
                grads = [weight.grad for weight in weights]
                means = [
                    self.state[weight].setdefault("momentum", torch.zeros_like(weight))
                    for weight in weights
                ]
                torch._foreach_lerp_(means, grads, 1.0 - group["momentum"])
                ahead = torch._foreach_lerp(grads, means, group["momentum"])
                steps = orthogonal(torch.stack(ahead)).unbind()
                if group["weight_decay"]:
                    torch._foreach_mul_(weights, 1.0 - group["lr"] * group["weight_decay"])
                # 0.2 is the usual root mean square of AdamW's step (Liu et al., 2025).
                torch._foreach_add_(weights, steps, alpha=-0.2 * max(shape) ** 0.5 * group["lr"])


def orthogonal(matrices: Tensor) -> Tensor:
    """Return approximately the nearest matrices with orthogonal rows or columns (Newton-Schulz).

    Singular values end between 0.7 and 1.2, which is enough for a step. Matrices of one shape are
    stacked, because for the small matrices of a network a call costs more than its product.

    Args:
        matrices: ``(k, m, n)``.
    """
    a, b, c = _COEFFICIENTS
    tall = matrices.shape[1] > matrices.shape[2]
    wide = matrices.mT if tall else matrices
    norms = torch.linalg.vector_norm(wide, dim=(1, 2), keepdim=True).clamp_min(1e-7)
    # A step's direction may be rounded to bfloat16 where products of bfloat16 are faster.
    fast = matrices.device.type == "cuda" or torch.cpu.get_capabilities().get("avx512_bf16", False)
    x = (wide / norms).to(torch.bfloat16 if fast else torch.float32)
    for _ in range(_ROUNDS):
        gram = x @ x.mT
        x = torch.baddbmm(x, torch.baddbmm(gram, gram, gram, beta=b, alpha=c), x, beta=a)
    return (x.mT if tall else x).to(matrices.dtype)


@contextmanager
def full_width() -> Iterator[None]:
    """Multiply matrices of float32 at the full vector width of an AMD processor, without rounding.

    MKL uses half of the width, and oneDNN is twice as fast. But torch selects oneDNN only if it may
    round to bfloat16. oneDNN does round on processors with matrix tiles (AMX), but not on others.
    """
    able, matmul = torch.cpu.get_capabilities(), torch.backends.mkldnn.matmul
    exact = able.get("avx512_bf16", False) and not able.get("amx_bf16", False)
    before = matmul.fp32_precision
    matmul.fp32_precision = "bf16" if exact else before
    try:
        yield
    finally:
        matmul.fp32_precision = before


def choose_device(name: str) -> torch.device:
    """Return the device called ``name``; "auto" is CUDA if available, else the CPU."""
    if name == "auto":
        name = "cuda" if torch.cuda.is_available() else "cpu"
    return torch.device(name)


# ---- batches ----


class DrawnRows:
    """Rows from which a batch is drawn with replacement, by ``draw(rows, rng)``.

    Subclasses that make rows for a batch override ``batch``.
    """

    def batch(self, step: int, n: int, rng: torch.Generator) -> Sequence[Tensor]:
        """Return the batch of ``n`` rows of a step of a training."""
        del step  # all steps draw from all rows
        return self.draw(torch.randint(len(self), (n,), generator=rng, device=rng.device), rng)


@dataclass
class MadeRows(DrawnRows):
    """Rows that a function makes for each batch, optionally in other processes.

    A batch depends only on the seed of the training and the step. So other processes may make
    batches ahead, and an interrupted training ends with the same weights.

    Attributes:
        numbers: Numbers of the rows, ``(n,)``.
        make: Function that takes numbers ``(n,)`` and a generator, and returns arrays ``(n, ...)``.
        device: Device of the training.
        workers: Forked processes that make batches ahead; 0 makes a batch when it is needed.
    """

    numbers: np.ndarray
    make: Callable[[np.ndarray, np.random.Generator], tuple[np.ndarray, ...]]
    device: torch.device | str = "cpu"
    workers: int = 0
    _next: int = field(default=-1, init=False)
    _ahead: Iterator[list[Tensor]] = field(default=iter(()), init=False)

    def __len__(self) -> int:
        return len(self.numbers)

    def batch(self, step: int, n: int, rng: torch.Generator) -> list[Tensor]:
        """Return the batch of ``n`` rows of a step of a training.

        Raises:
            ValueError: If there are workers, and the system cannot fork processes.
        """
        if step != self._next:
            steps = range(step, 2**62)  # endless: the training takes the batches that it needs
            loader = DataLoader(
                steps,
                batch_size=None,  # an item is a batch
                collate_fn=partial(self._batch_of, n, rng.initial_seed()),
                num_workers=self.workers,
                multiprocessing_context="fork" if self.workers else None,
                pin_memory=torch.device(self.device).type == "cuda",
                generator=torch.Generator(),  # torch's global generator stays as it is
            )
            self._ahead = iter(loader)
        self._next = step + 1
        return [tensor.to(self.device, non_blocking=True) for tensor in next(self._ahead)]

    def draw(self, rows: Tensor, rng: torch.Generator) -> list[Tensor]:
        """Return rows by their indices ``(n,)`` in ``numbers``."""
        seed = torch.randint(2**62, (), generator=rng, device=rng.device).item()
        made = self._made(self.numbers[rows.cpu().numpy()], np.random.default_rng(seed))
        return [tensor.to(self.device) for tensor in made]

    def _batch_of(self, n: int, seed: int, step: int) -> list[Tensor]:
        rng = np.random.default_rng([seed, step])
        return self._made(rng.choice(self.numbers, n), rng)

    def _made(self, numbers: np.ndarray, rng: np.random.Generator) -> list[Tensor]:
        return [torch.as_tensor(array, dtype=torch.float32) for array in self.make(numbers, rng)]


# ---- checkpoints ----


class Checkpoint(NamedTuple):
    """File of the state of a training.

    Attributes:
        file: Path of the file.
        fingerprint: Hash of the training; a state with another one is not read, and is
            overwritten.
    """

    file: Path
    fingerprint: str

    def write(self, state: dict) -> None:
        """Write a state; an interrupted write leaves the old file."""
        self.file.parent.mkdir(parents=True, exist_ok=True)
        partial_file = self.file.with_suffix(".partial")
        torch.save(state | {"fingerprint": self.fingerprint}, partial_file)
        partial_file.replace(self.file)

    def read(self) -> dict | None:
        """Return the state, or None if this training has none.

        Raises:
            ValueError: If the file cannot be read.
        """
        if not self.file.exists():
            return None
        try:
            # weights_only: a checkpoint must not run code. On the CPU, because optimisers count
            # steps there, and move other state to the device of the weights.
            state = torch.load(self.file, weights_only=True, map_location="cpu")
            saved = state["fingerprint"]
        except (EOFError, KeyError, RuntimeError, UnpicklingError) as error:
            raise ValueError(
                f"{self.file} cannot be read ({type(error).__name__}); delete it to train from the "
                "start"
            ) from error
        if saved != self.fingerprint:
            tqdm.write(f"{self.file} is of another training; starting from step 0")
            return None
        tqdm.write(f"going on from step {state['step']} of {self.file}")
        return state


def fingerprint(settings: Mapping, code: Sequence[str | Path]) -> str:
    """Return a hash of settings and code that identifies a training."""
    digest = hashlib.sha256(json.dumps(settings, sort_keys=True).encode())
    for file in code:
        digest.update(Path(file).read_bytes())
    digest.update(torch.__version__.encode())
    return digest.hexdigest()


# ---- training ----

# Share of the steps in which the learning rate rises, as the first means of gradients are noisy.
_WARM_UP = 0.03
# Attributes of a training in its checkpoint.
_NUMBERS = ("step", "best_step", "best_loss", "losses", "evaluations")
_WEIGHTS = ("weights", "means", "best")


@dataclass
class Trainer:
    """Training of one network, ready to run.

    Attributes:
        network: Network on the device of its training, with a ``name``, ``loss(*batch)`` and
            ``validation_loss(*batch)``, the negative log density, ``(n,)`` each.
        rows: Rows to train on.
        validation: Held-out rows for evaluation, drawn once.
        settings: ``steps``, ``batch``, ``optimiser``, ``learning_rate``, ``evaluate_every``,
            ``checkpoint_every``.
        seed: Seed of the configuration.
        checkpoint: File of the state; None for a short training without one.
        weight_decay: Decoupled weight decay. Batches with new noise need none.
        clip: Largest norm of the gradient. The default acts only on extreme batches; smaller norms
            lower the held-out log density of the paper's networks by 0.03 nats.
        ema: Decay of the moving average of the weights, which spans the last 1 / (1 - ema) steps,
            a third of the paper's training.
    """

    network: nn.Module
    rows: DrawnRows
    validation: DrawnRows
    settings: Mapping
    seed: int
    checkpoint: Checkpoint | None = None
    weight_decay: float = 0.0
    clip: float = 1000.0
    ema: float = 0.999

    def __post_init__(self) -> None:
        name = self.network.name
        self.step, self.best_step, self.best_loss = 0, 0, math.inf
        self.losses: list[float] = []
        self.evaluations: list[tuple[int, float]] = []
        self.weights = list(self.network.parameters())
        self.means = [weight.detach().clone() for weight in self.weights]
        self.best = [weight.clone() for weight in self.means]
        self.optimisers = optimisers(
            self.network,
            self.settings["optimiser"],
            learning_rate=self.settings["learning_rate"],
            weight_decay=self.weight_decay,
        )
        device = self.weights[0].device
        self.rng = torch.Generator(device).manual_seed(seed_integer(self.seed, "training", name))
        fixed = torch.Generator(device).manual_seed(seed_integer(self.seed, "validation", name))
        rows = torch.arange(len(self.validation), device=device)
        self.fixed_batch = self.validation.draw(rows, fixed)

    def run(self) -> xr.Dataset:
        """Train to the last step, set the best weights, and return the history.

        Returns:
            Dataset with ``training_loss`` and ``learning_rate`` over ``step``, and
            ``validation_loss`` and ``evaluation_step`` over ``evaluation``.

        Raises:
            FloatingPointError: If a loss is not finite.
        """
        if self.checkpoint and (state := self.checkpoint.read()):
            self._restore(state)
        total = self.settings["steps"]
        bar = tqdm(
            total=total,
            initial=self.step,
            desc=f"training {self.network.name}",
            mininterval=5.0,
            unit="step",
        )
        with bar, full_width():
            while self.step < total:
                self._advance()
                if self.step % self.settings["evaluate_every"] == 0 or self.step == total:
                    self._evaluate()
                    bar.set_postfix(loss=f"{self.losses[-1]:.2f}", best=f"{self.best_loss:.3f}")
                if self.checkpoint and self.step % self.settings["checkpoint_every"] == 0:
                    self.checkpoint.write(self._state())
                bar.update()
        _copy(self.best, self.weights)
        return self._history()

    def learning_rate(self, step: int) -> float:
        """Return the learning rate of a step, counted from 0: linear warm-up times a cosine."""
        total = self.settings["steps"]
        warm_up = max(1.0, _WARM_UP * total)
        cosine = 0.5 * (1.0 + math.cos(math.pi * step / total))
        return self.settings["learning_rate"] * min(1.0, (step + 1) / warm_up) * cosine

    def _advance(self) -> None:
        batch = self.rows.batch(self.step, self.settings["batch"], self.rng)
        loss = self.network.loss(*batch).mean()
        self.losses.append(loss.item())
        self._check("loss", self.losses[-1])
        self.network.zero_grad()
        loss.backward()
        torch.nn.utils.clip_grad_norm_(self.weights, self.clip)
        for optimiser in self.optimisers:
            for group in optimiser.param_groups:
                group["lr"] = self.learning_rate(self.step)
            optimiser.step()
        self.step += 1
        # In early steps a smaller decay lets the average forget the initial weights.
        decay = min(self.ema, self.step / (self.step + 10))
        with torch.no_grad():
            torch._foreach_lerp_(self.means, self.weights, 1.0 - decay)

    @torch.no_grad()
    def _evaluate(self) -> None:
        kept = [weight.detach().clone() for weight in self.weights]
        _copy(self.means, self.weights)
        loss = self.network.validation_loss(*self.fixed_batch).mean().item()
        _copy(kept, self.weights)
        self.evaluations.append((self.step, loss))
        self._check("validation loss", loss)
        if loss < self.best_loss:
            self.best_step, self.best_loss = self.step, loss
            _copy(self.means, self.best)

    def _check(self, name: str, loss: float) -> None:
        if not math.isfinite(loss):
            raise FloatingPointError(
                f"the {name} of {self.network.name} is {loss} at step {self.step}; "
                "lower training.learning_rate"
            )

    def _state(self) -> dict:
        return {
            **{name: getattr(self, name) for name in _NUMBERS},
            **{name: [tensor.detach() for tensor in getattr(self, name)] for name in _WEIGHTS},
            "optimisers": [optimiser.state_dict() for optimiser in self.optimisers],
            "rng": self.rng.get_state(),
        }

    def _restore(self, state: dict) -> None:
        for name in _NUMBERS:
            setattr(self, name, state[name])
        for name in _WEIGHTS:
            _copy(state[name], getattr(self, name))
        for optimiser, kept in zip(self.optimisers, state["optimisers"], strict=True):
            optimiser.load_state_dict(kept)
        self.rng.set_state(state["rng"])

    def _history(self) -> xr.Dataset:
        steps, losses = zip(*self.evaluations, strict=True)
        rates = [self.learning_rate(step) for step in range(self.step)]
        return xr.Dataset(
            {
                "training_loss": ("step", self.losses),
                "learning_rate": ("step", rates),
                "validation_loss": ("evaluation", list(losses)),
                "evaluation_step": ("evaluation", list(steps)),
            },
            coords={"step": ("step", np.arange(1, self.step + 1))},
            attrs={"best_step": self.best_step, "best_validation_loss": self.best_loss},
        )


@torch.no_grad()
def _copy(source: list[Tensor], target: list[Tensor]) -> None:
    torch._foreach_copy_(target, source)
