"""What moves the weights of a training: Muon at or between hidden layers, AdamW elsewhere.

Muon (Jordan et al., 2024, "Muon: an optimizer for hidden layers in neural networks") makes a step's
matrix orthogonal, so that weak directions of a layer move as far as strong ones. The posterior of a
drive is a thousand times sharper in some directions than in others: after 2,000 steps Muon is
within 0.07 nats of it where AdamW is within 0.16. Written out because torch's own works in bfloat16
alone, which processors without such instructions only emulate.
"""

from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager

import torch
from torch import Tensor, nn

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
