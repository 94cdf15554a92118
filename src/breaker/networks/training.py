"""Training of a posterior on a bank of simulated operations.

Every batch gets a fresh zero, fresh noise and, where the summary network takes missing samples,
fresh gaps; the rows for validation got theirs once. The exponential moving average (EMA) of the
weights is judged and kept, by the mean negative log density of the validation rows. The loss
that is trained on does not rank weights: flow matching is scored in coordinates that the base
whitens, so its value falls where the base is too wide. The learning rate warms up linearly and
falls to zero by a cosine over a fixed budget of steps.

All randomness of the batches comes from one generator, whose state is in the checkpoint, or from
its seed and the step: a training that was killed goes on where it was and ends with the weights of
an uninterrupted one.
"""

import hashlib
import json
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from pickle import UnpicklingError
from typing import NamedTuple, Protocol

import numpy as np
import torch
import xarray as xr
from torch import Tensor, nn
from tqdm import tqdm

from breaker.common.randomness import seed_integer
from breaker.networks.blocks import Edge, Hidden

_COEFFICIENTS = (3.4445, -4.7750, 2.0315)  # of a polynomial steep at 0, as of Jordan et al.
_ROUNDS = 5
_MOVED = {"adamw": (), "muon": (Hidden,), "muon_edges": (Hidden, Edge)}  # by Muon, by optimiser


def optimisers(network: nn.Module, settings: Mapping) -> list[torch.optim.Optimizer]:
    """Return the optimisers of a network's weights, one or two.

    Args:
        settings: The section ``training`` of the configuration.
    """
    options = {"lr": settings["learning_rate"], "weight_decay": settings["weight_decay"]}
    kinds = _MOVED[settings["optimiser"]]
    hidden = [layer.weight for layer in network.modules() if isinstance(layer, kinds)]
    if not hidden:
        return [torch.optim.AdamW(network.parameters(), **options)]
    apart = {id(weight) for weight in hidden}
    others = [weight for weight in network.parameters() if id(weight) not in apart]
    return [torch.optim.AdamW(others, **options), Muon(hidden, **options)]


class Muon(torch.optim.Optimizer):
    """Momentum made orthogonal, for matrices.

    A step's root mean square is that of AdamW (Liu et al., 2025, "Muon is scalable for LLM
    training"), so that both take the same learning rate.

    Args:
        weights: Matrices.
        lr: Learning rate.
        weight_decay: Decoupled weight decay.
        momentum: Of the gradient's moving average, which Nesterov's step looks ahead of.
    """

    def __init__(
        self,
        weights: Iterable[Tensor],
        *,
        lr: float,
        weight_decay: float = 0.0,
        momentum: float = 0.95,
    ) -> None:
        super().__init__(weights, {"lr": lr, "weight_decay": weight_decay, "momentum": momentum})

    @torch.no_grad()
    def step(self, closure: None = None) -> None:
        """Move all weights that have a gradient."""
        del closure  # the loss is not asked for again
        for group in self.param_groups:
            alike: dict[torch.Size, list[Tensor]] = {}
            for weight in group["params"]:
                if weight.grad is not None:
                    alike.setdefault(weight.shape, []).append(weight)
            for shape, weights in alike.items():
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
                torch._foreach_add_(weights, steps, alpha=-0.2 * max(shape) ** 0.5 * group["lr"])


def orthogonal(matrices: Tensor) -> Tensor:
    """Return about the nearest matrices of orthogonal rows or columns, by Newton and Schulz.

    Singular values end between 0.7 and 1.2, which is near enough for a step. Matrices of a shape
    go together, for those of a network are so small that each product costs its start.

    Args:
        matrices: ``(k, m, n)``.
    """
    a, b, c = _COEFFICIENTS
    tall = matrices.shape[1] > matrices.shape[2]
    wide = matrices.mT if tall else matrices
    norms = torch.linalg.vector_norm(wide, dim=(1, 2), keepdim=True).clamp_min(1e-7)
    x = (wide / norms).to(_precision(matrices.device.type))
    for _ in range(_ROUNDS):
        gram = x @ x.mT
        x = torch.baddbmm(x, torch.baddbmm(gram, gram, gram, beta=b, alpha=c), x, beta=a)
    return (x.mT if tall else x).to(matrices.dtype)


def _precision(device: str) -> torch.dtype:
    """Half of float32 where the processor multiplies it faster, which a step's direction bears."""
    fast = device == "cuda" or torch.cpu.get_capabilities().get("avx512_bf16", False)
    return torch.bfloat16 if fast else torch.float32


@contextmanager
def full_width() -> Iterator[None]:
    """Multiply matrices of float32 on the whole width of an AMD processor, as exactly as before.

    MKL uses half of it. oneDNN, twice as fast there, is taken by torch only where it may round to
    bfloat16, which it does on processors with tiles for matrices (AMX), and not on others.
    """
    able, matmul = torch.cpu.get_capabilities(), torch.backends.mkldnn.matmul
    exact = able.get("avx512_bf16", False) and not able.get("amx_bf16", False)
    before = matmul.fp32_precision
    matmul.fp32_precision = "bf16" if exact else before
    try:
        yield
    finally:
        matmul.fp32_precision = before


# ---- training ----


# Of the state of a training, in its checkpoint.
_NUMBERS = ("step", "best_step", "best_loss", "losses", "evaluations")
_WEIGHTS = ("weights", "ema", "best")


def choose_device(name: str) -> torch.device:
    """Return the device called ``name``; "auto" is CUDA where there is one."""
    if name == "auto":
        name = "cuda" if torch.cuda.is_available() else "cpu"
    return torch.device(name)


def fingerprint(settings: Mapping, code: Sequence[str | Path]) -> str:
    """Return a hash of the settings and the code of a training, which identifies it."""
    digest = hashlib.sha256(json.dumps(settings, sort_keys=True).encode())
    for file in code:
        digest.update(Path(file).read_bytes())
    digest.update(torch.__version__.encode())
    return digest.hexdigest()


class Batches(Protocol):
    """What makes the batches of a training."""

    def batch(self, step: int, n: int, rng: torch.Generator) -> Sequence[Tensor]:
        """Return the batch of ``n`` rows of a step of a training."""
        ...


class DrawnRows:
    """Rows of which a batch takes any, with replacement, by ``draw(rows, rng)``."""

    def batch(self, step: int, n: int, rng: torch.Generator) -> Sequence[Tensor]:
        """Return the batch of ``n`` rows of a step of a training."""
        del step  # any row at any time
        return self.draw(torch.randint(len(self), (n,), generator=rng, device=rng.device), rng)


class Checkpoint(NamedTuple):
    """Where the state of a training is kept.

    Attributes:
        file: Its file.
        fingerprint: What the state must have been made with; that of another training is left
            alone and written over.
    """

    file: Path
    fingerprint: str


@dataclass
class Trainer:
    """A training and its state.

    Args:
        posterior: The network on its device, with a ``name``, and ``loss`` and ``validation_loss``
            of a batch; its weights are the best EMA weights at the end.
        rows: Rows to train on, with ``batch(step, n, rng)``.
        validation: Rows to judge on, not among ``rows``.
        settings: The section ``training`` of the configuration, for this motion.
        seed: Seed of the configuration.
        checkpoint: The state, written as the training goes and read if its file is there; None for
            a training too short to be killed.
    """

    posterior: nn.Module
    rows: Batches
    validation: DrawnRows
    settings: Mapping
    seed: int
    checkpoint: Checkpoint | None = None
    step: int = 0
    best_step: int = 0
    best_loss: float = math.inf
    losses: list[float] = field(default_factory=list)
    evaluations: list[tuple[int, float]] = field(default_factory=list)

    def __post_init__(self) -> None:
        name = self.posterior.name
        self.weights = list(self.posterior.parameters())
        self.ema = [weight.detach().clone() for weight in self.weights]
        self.best = [weight.clone() for weight in self.ema]
        self.optimisers = optimisers(self.posterior, self.settings)
        device = self.weights[0].device
        self.rng = torch.Generator(device).manual_seed(seed_integer(self.seed, "training", name))
        fixed = torch.Generator(device).manual_seed(seed_integer(self.seed, "validation", name))
        rows = torch.arange(len(self.validation), device=device)
        self.fixed_batch = self.validation.draw(rows, fixed)

    def run(self) -> xr.Dataset:
        """Train to the end of the budget, put the best weights in place, return the history.

        Raises:
            FloatingPointError: If a loss is not finite.
        """
        self._resume()
        total = self.settings["steps"]
        bar = tqdm(
            total=total,
            initial=self.step,
            desc=f"training {self.posterior.name}",
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
                    self._save()
                bar.update()
        self._copy(self.best, self.weights)
        return self._history()

    def learning_rate(self, step: int) -> float:
        """Learning rate of a step, from 0: linear warm-up times a cosine."""
        total = self.settings["steps"]
        warm_up = max(1.0, self.settings["warm_up"] * total)
        cosine = 0.5 * (1.0 + math.cos(math.pi * step / total))
        return self.settings["learning_rate"] * min(1.0, (step + 1) / warm_up) * cosine

    def _advance(self) -> None:
        batch = self.rows.batch(self.step, self.settings["batch"], self.rng)
        loss = self.posterior.loss(*batch).mean()
        self.losses.append(loss.item())
        self._check("loss", self.losses[-1])
        self.posterior.zero_grad()
        loss.backward()
        torch.nn.utils.clip_grad_norm_(self.weights, self.settings["clip"])
        for optimiser in self.optimisers:
            for group in optimiser.param_groups:
                group["lr"] = self.learning_rate(self.step)
            optimiser.step()
        self.step += 1
        # Early on the average spans the steps so far, so that it forgets the start.
        decay = min(self.settings["ema"], self.step / (self.step + 10))
        with torch.no_grad():
            torch._foreach_lerp_(self.ema, self.weights, 1.0 - decay)

    @torch.no_grad()
    def _evaluate(self) -> None:
        kept = [weight.detach().clone() for weight in self.weights]
        self._copy(self.ema, self.weights)
        loss = self.posterior.validation_loss(*self.fixed_batch).mean().item()
        self._copy(kept, self.weights)
        self.evaluations.append((self.step, loss))
        self._check("validation loss", loss)
        if loss < self.best_loss:
            self.best_step, self.best_loss = self.step, loss
            self._copy(self.ema, self.best)

    def _check(self, name: str, loss: float) -> None:
        if not math.isfinite(loss):
            raise FloatingPointError(
                f"the {name} of {self.posterior.name} is {loss} at step {self.step}; "
                "lower training.learning_rate"
            )

    @staticmethod
    @torch.no_grad()
    def _copy(source: list[Tensor], target: list[Tensor]) -> None:
        torch._foreach_copy_(target, source)

    def _state(self) -> dict:
        return {
            "fingerprint": self.checkpoint.fingerprint,
            **{name: getattr(self, name) for name in _NUMBERS},
            **{name: [each.detach() for each in getattr(self, name)] for name in _WEIGHTS},
            "optimisers": [optimiser.state_dict() for optimiser in self.optimisers],
            "rng": self.rng.get_state(),
        }

    def _save(self) -> None:
        file = self.checkpoint.file
        file.parent.mkdir(parents=True, exist_ok=True)
        partial = file.with_suffix(".partial")
        torch.save(self._state(), partial)
        partial.replace(file)  # whole or not at all

    def _resume(self) -> None:
        if self.checkpoint is None or not self.checkpoint.file.exists():
            return
        file, fingerprint = self.checkpoint
        # weights_only: a checkpoint is data, whoever wrote it.
        try:
            # Optimisers count steps on the processor, and move all else to the weights.
            state = torch.load(file, weights_only=True, map_location="cpu")
            found = state["fingerprint"]
        except (EOFError, KeyError, RuntimeError, UnpicklingError) as error:
            raise ValueError(
                f"{file} cannot be read ({type(error).__name__}); delete it to train from the start"
            ) from error
        if found != fingerprint:
            tqdm.write(f"{file} is of another training; starting anew")
            return
        for name in _NUMBERS:
            setattr(self, name, state[name])
        for name in _WEIGHTS:
            self._copy(state[name], getattr(self, name))
        for optimiser, kept in zip(self.optimisers, state["optimisers"], strict=True):
            optimiser.load_state_dict(kept)
        self.rng.set_state(state["rng"])
        tqdm.write(f"going on from step {self.step} of {file}")

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
