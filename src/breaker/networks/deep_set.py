r"""Deep set: features of a record from those of its samples that are present.

Zaheer et al. (2017), "Deep sets": a network maps each pair of time and value by itself, a mean
over the pairs that are there is blind to their order, and a second network maps the mean to the
features. A missing sample is NaN; it is not in the set, and nothing stands in for it.

A mean over pairs hardly learns the precise linear statistics of a long record. So a linear highway
runs beside it, as in the time-series network: there a fixed linear map of the whole record, here
its counterpart for a set, the regression of the samples on the frozen components.
"""

import math

import torch
from torch import Tensor, nn

from breaker.networks.blocks import ResidualMLP

_FREQUENCIES = 4  # of a sample's time; more would resolve what the highway does better


class SetHighway(nn.Module):
    r"""Posterior of the components' amplitudes given the samples that are there.

    A record is taken for ``centre + Psi b + zero + noise`` with independent normal terms: the
    amplitudes b, the zero of sd ``offset_sd`` that all samples share, and the noise of sd
    ``noise_sd``. Given the samples at hand, with residuals r and covariance
    ``C = noise_sd^2 I + offset_sd^2 1 1^T``, the precision and the mean of b are

        Lambda = diag(1 / (1 + v)) + Psi^T C^-1 Psi,    b = Lambda^-1 Psi^T C^-1 r,

    where v is the variance of a component over the noise's, and Psi is scaled so that Lambda is
    the unit matrix for a whole record. There ``b / sqrt(v)`` is the plain highway,
    ``(record - centre) @ components``. All of it in float64: with few samples the precision spans
    as many orders of magnitude as v.

    Args:
        components: Number c of components.
    """

    def __init__(self, samples: int, components: int) -> None:
        super().__init__()
        self.register_buffer("table", torch.zeros(samples, 1 + components, dtype=torch.float64))
        self.register_buffer("spread", torch.ones(components, dtype=torch.float64))
        self.register_buffer("variances", torch.tensor([1.0, 0.0], dtype=torch.float64))

    @torch.no_grad()
    def freeze(
        self, centre: Tensor, components: Tensor, *, noise_sd: float, offset_sd: float
    ) -> None:
        """Set centre ``(t,)``, components ``(t, c)`` and the noise that they were whitened by.

        ``components.T @ C @ components`` has to be diagonal: components are whitened, orthogonal,
        and scaled to the unit variance of signal and noise together, as those of
        ``plausibility.principal_components``. So its diagonal is ``1 / (1 + v)``.
        """
        weights = components.to(self.table)
        loadings = noise_sd**2 * weights + offset_sd**2 * weights.sum(0)
        # A component without any signal (v = 0) gets a little, which moves no score visibly.
        spread = (1.0 / (weights * loadings).sum(0) - 1.0).clamp(min=1e-9).sqrt()
        self.table.copy_(torch.cat([centre.to(self.table)[:, None], loadings * spread], dim=1))
        self.spread.copy_(spread)
        self.variances.copy_(self.variances.new_tensor([noise_sd**2, offset_sd**2]))

    @torch.no_grad()
    def forward(self, x: Tensor) -> tuple[Tensor, Tensor, Tensor]:
        """Regress records ``(n, t)``, NaN where a sample is missing, on the components.

        Returns:
            Scores ``(n, c)``, which for whole records are the plain highway's outputs; the log
            of their sd given the samples over that given a whole record, ``(n, c)``; and the
            centred records ``(n, t)``, zero where nothing is present. All in float64.
        """
        present = ~x.isnan()
        centred = torch.where(present, x.double() - self.table[:, 0], 0.0)
        precision, product = self._normal_equations(centred, present.to(self.table))
        precision.diagonal(dim1=1, dim2=2).add_(1.0 / (1.0 + self.spread**2))
        factor = torch.linalg.cholesky(precision)
        amplitudes = torch.cholesky_solve(product.unsqueeze(-1), factor).squeeze(-1)
        variance = torch.cholesky_inverse(factor).diagonal(dim1=1, dim2=2)
        return amplitudes / self.spread, 0.5 * variance.log(), centred

    def _normal_equations(self, centred: Tensor, there: Tensor) -> tuple[Tensor, Tensor]:
        """``Psi^T C^-1 Psi`` and ``Psi^T C^-1 r`` over the samples that are there.

        ``C^-1 = (I - k 1 1^T) / noise_sd^2`` with ``k = offset_sd^2 / (noise_sd^2 + m
        offset_sd^2)`` for m samples.
        """
        psi, (noise, offset) = self.table[:, 1:], self.variances
        pairs = (psi.unsqueeze(2) * psi.unsqueeze(1)).flatten(1)
        square = (there @ pairs).unflatten(1, (psi.shape[1], -1))
        sums, product = there @ psi, centred @ psi
        shared = offset / (noise + there.sum(1, keepdim=True) * offset)
        square = square - shared.unsqueeze(-1) * sums.unsqueeze(2) * sums.unsqueeze(1)
        product = product - shared * sums * centred.sum(1, keepdim=True)
        return square / noise, product / noise


class DeepSet(nn.Module):
    """Features of records with missing samples.

    Args:
        features: Number s of features.
        components: Number c of components of the highway.
        pair_width, pair_blocks: Size of the residual network of a pair.
        width, blocks: Size of the residual network that joins the parts.
        missing: Largest share of missing samples in training, and of the records it answers for.
    """

    def __init__(
        self,
        samples: int,
        features: int,
        *,
        components: int,
        pair_width: int,
        pair_blocks: int,
        width: int,
        blocks: int,
        missing: float,
    ) -> None:
        super().__init__()
        self.samples, self.missing = samples, missing
        self.highway = SetHighway(samples, components)
        self.pair = ResidualMLP(2 + 2 * _FREQUENCIES, pair_width, pair_width, blocks=pair_blocks)
        parts = 2 * components + pair_width + 1
        self.join = ResidualMLP(parts, width, features, blocks=blocks)
        self.register_buffer("scale", torch.ones(()))

    def freeze(
        self,
        centre: Tensor,
        scale: Tensor,
        components: Tensor,
        *,
        noise_sd: float = 1.0,
        offset_sd: float = 0.0,
    ) -> None:
        """Set the frozen centre ``(t,)``, scale ``()`` and components ``(t, c)`` of records.

        Args:
            noise_sd: Standard deviation of a sample's noise, in the unit of a record.
            offset_sd: That of an offset which all samples of a record share.
        """
        self.highway.freeze(centre, components, noise_sd=noise_sd, offset_sd=offset_sd)
        with torch.no_grad():
            self.scale.copy_(scale)

    def forward(self, x: Tensor) -> Tensor:
        """Map records ``(n, t)``, NaN where a sample is missing, to features ``(n, s)``."""
        there = (~x.isnan()).to(self.scale)
        scores, log_sd, centred = self.highway(x)
        pooled = self._pool(centred.to(self.scale) / self.scale, there)
        share = there.sum(1, keepdim=True) / self.samples
        parts = [scores.to(self.scale), log_sd.to(self.scale), pooled, share]
        return self.join(torch.cat(parts, dim=1))

    def _pool(self, values: Tensor, there: Tensor) -> Tensor:
        """Mean over the pairs that are there, ``(n, t) -> (n, pair_width)``."""
        steps = torch.arange(self.samples, device=values.device).to(values)
        share = (steps / (self.samples - 1)).unsqueeze(-1)
        angles = math.pi * share * torch.arange(1, 1 + _FREQUENCIES, device=values.device)
        waves = torch.cat([2.0 * share - 1.0, angles.sin(), angles.cos()], dim=-1)
        mapped = self.pair(
            torch.cat([values.unsqueeze(-1), waves.expand(*values.shape, -1)], dim=-1)
        )
        there = there.unsqueeze(-1)
        return (mapped * there).sum(1) / there.sum(1).clamp(min=1.0)
