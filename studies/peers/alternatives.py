"""What else one could do with a measured curve, beside the trained network.

    python -m studies.peers.alternatives --motion closing

On the same held-out records: ABC rejection with the simulations of the bank, maximum likelihood and
maximum a posteriori by least squares (intervals from the Jacobian at the optimum), ensemble MCMC.
Standardised outputs throughout. The log score of all is that of the normal distribution with the
mean and covariance that the method reports, as not all have a density.
"""

import emcee
import numpy as np
from scipy.optimize import least_squares
from scipy.stats import multivariate_normal

from breaker.common.randomness import generator
from breaker.paper.posterior.exact_correction import correct
from studies.peers.common import (
    CLOCKS,
    HeldOut,
    bank_of,
    held_out,
    mean_and_error,
    parser,
    read_settings,
    restart,
    truth,
    write_json,
)
from studies.peers.fit_breaker import Breaker

_clock = CLOCKS["processor"]
_KEPT = 500  # simulations that ABC keeps
_STARTS = 5  # of a least-squares fit: the prior median, and draws from the prior
_WALKERS, _STEPS, _BURN_IN = 32, 10_000, 2000
_DRAWS = 1000  # of the network
_FAR = 8.0  # prior sd, bound of the fits


class Abc:
    """Rejection with the simulations of the bank, nearest by Mahalanobis distance."""

    def __init__(self, bank, data: HeldOut, rng: np.random.Generator) -> None:
        parts = []
        for start in range(0, bank.sizes["curve"], 16384):
            travel = bank.travel.values[start : start + 16384].astype(np.float64)
            records = data.model.sensor.corrupt(travel, rng)
            parts.append(data.model.sensor.whiten(records).astype(np.float32))
        self.records = np.concatenate(parts)
        self.squares = np.einsum("nt,nt->n", self.records, self.records)
        self.z = truth(bank, data.model)

    def __call__(self, measured: np.ndarray, data: HeldOut, rng) -> np.ndarray:
        target = data.model.sensor.whiten(measured).astype(np.float32)
        distance = self.squares - 2.0 * self.records @ target
        return self.z[np.argpartition(distance, _KEPT)[:_KEPT]]


def fit(measured: np.ndarray, data: HeldOut, rng, *, prior: bool) -> tuple[np.ndarray, np.ndarray]:
    """Return optimum ``(q,)`` and covariance ``(q, q)`` by least squares; the onset's prior, part
    of the sensor, is always in."""
    q = data.z.shape[1]
    known = slice(0 if prior else q - 1, q)

    def residuals(z: np.ndarray) -> np.ndarray:
        difference = measured - data.model.curves(data.model.destandardise(z[None]))[0]
        return np.concatenate([data.model.sensor.whiten(difference), z[known]])

    starts = np.vstack([np.zeros(q), rng.standard_normal((_STARTS - 1, q))])
    runs = [least_squares(residuals, start, bounds=(-_FAR, _FAR)) for start in starts]
    best = min(runs, key=lambda run: run.cost)
    return best.x, np.linalg.pinv(best.jac.T @ best.jac, hermitian=True)


def mcmc(measured: np.ndarray, data: HeldOut, rng: np.random.Generator) -> tuple[np.ndarray, float]:
    """Return draws ``(d, q)`` and the autocorrelation time of an ensemble started at the MAP."""
    optimum, covariance = fit(measured, data, rng, prior=True)
    start = rng.multivariate_normal(optimum, 0.25 * covariance, size=_WALKERS)
    sampler = emcee.EnsembleSampler(
        *(_WALKERS, data.z.shape[1], data.model.log_joint), args=(measured,), vectorize=True
    )
    sampler.random_state = np.random.RandomState(rng.integers(2**31)).get_state()
    sampler.run_mcmc(start, _STEPS)
    time = float(np.max(sampler.get_autocorr_time(discard=_BURN_IN, tol=0)))
    return sampler.get_chain(discard=_BURN_IN, thin=16, flat=True), time


def main() -> None:
    options = parser(__doc__.splitlines()[0], "alternatives")
    options.add_argument("--curves", type=int, default=20)
    options.add_argument("--steps", type=int, default=3000, help="of the network's training")
    given = options.parse_args()
    restart(given.threads)

    settings = read_settings()
    data = held_out(given.motion, settings, given.curves)
    bank = bank_of(data.model)
    rng = generator(given.seed, "alternatives", given.motion)
    arm = Breaker("breaker_coupling_flow")
    arm.train(bank, data.model, given.steps, given.seed)
    begin = _clock()
    abc = Abc(bank, data, rng)
    set_up = _clock() - begin

    def network(measured: np.ndarray) -> np.ndarray:
        return arm.sample(measured[None], _DRAWS, int(rng.integers(2**31)))[0]

    unresolved: list[str] = []

    def corrected(measured: np.ndarray) -> np.ndarray:
        draws = data.model.destandardise(network(measured))
        found = correct(data.model, measured, draws, settings["correction"], rng)
        unresolved.extend([found.reason] * (not found.resolved))
        return data.model.standardise(found.draws)

    times: list[float] = []

    def chains(measured: np.ndarray) -> np.ndarray:
        draws, time = mcmc(measured, data, rng)
        times.append(time)
        return draws

    methods = {
        "network": network,
        "network, corrected": corrected,
        "abc": lambda measured: abc(measured, data, rng),
        "maximum likelihood": lambda measured: fit(measured, data, rng, prior=False),
        "maximum a posteriori": lambda measured: fit(measured, data, rng, prior=True),
        "mcmc": chains,
    }
    rows = {name: judge(method, data) for name, method in methods.items()}
    rows["mcmc"]["autocorrelation_time"] = [float(np.median(times)), max(times)]
    rows["abc"]["seconds_once"] = set_up
    rows["network, corrected"]["unresolved"] = unresolved
    write_json(given.out, {"motion": given.motion, "curves": given.curves, "rows": rows})


def judge(method, data: HeldOut) -> dict:
    """Apply a method to all records; it returns draws, or an optimum and its covariance."""
    method(data.measured[0])  # compiles
    begin = _clock()
    found = [method(measured) for measured in data.measured]
    seconds = (_clock() - begin) / len(found)
    inside, errors, scores = [], [], []
    for answer, z in zip(found, data.z, strict=True):
        if isinstance(answer, tuple):
            mean, covariance = answer
            half = 1.96 * np.sqrt(np.diag(covariance))
            lower, upper = mean - half, mean + half
        else:
            mean, covariance = answer.mean(axis=0), np.cov(answer.T)
            lower, upper = np.quantile(answer, [0.025, 0.975], axis=0)
        inside.append((lower <= z) & (z <= upper))
        errors.append(mean - z)
        scores.append(multivariate_normal(mean, covariance, allow_singular=True).logpdf(z))
    return {
        "rmse": float(np.sqrt(np.mean(np.square(errors)))),
        "rmse_outputs": np.sqrt(np.mean(np.square(errors), axis=0)).tolist(),
        "coverage_95": float(np.mean(inside)),
        "normal_log_score": mean_and_error(np.array(scores)),
        "seconds_per_curve": seconds,
    }


if __name__ == "__main__":
    main()
