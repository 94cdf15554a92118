"""Curves per second of the exact mechanism, beside an ODE solver.

    python benchmarks/mechanism.py

The mechanism simulates records of the default prior and sensor (151 samples, random onsets) on one
thread and on two; the median of several rounds counts. The solver is ``scipy.integrate.solve_ivp``
(RK45, rtol 1e-6, event located) on one thread.
"""

import argparse
from pathlib import Path
from statistics import median
from time import perf_counter

import numba
import numpy as np
import yaml
from scipy.integrate import solve_ivp

from breaker.mechanism import rest_position, travel
from breaker.parameters import MOTIONS
from breaker.prior import Prior
from breaker.randomness import generator
from breaker.sensor import Sensor

DEFAULTS = Path(__file__).parents[1] / "config" / "config.yaml"


def solve(theta: np.ndarray, times: np.ndarray, motion: str) -> np.ndarray:
    """Return the travel ``(t,)`` of one operation that starts at time 0, by ``solve_ivp``."""
    mu, k_a, k_b, gamma_a, gamma_b, f, gap = theta.tolist()
    pull = f if motion == "closing" else 0.0
    rest = float(rest_position(theta, motion))

    def free(_, y):
        x_a, v_a, x_b, v_b = y.tolist()
        spring = k_b * (x_b - x_a) + gamma_b * (v_b - v_a)
        return v_a, pull - k_a * x_a - gamma_a * v_a + spring, v_b, -mu * spring

    def closed(_, y):
        x_a, v_a, _, _ = y.tolist()
        spring = k_b * (gap - x_a) - gamma_b * v_a
        return v_a, pull - k_a * x_a - gamma_a * v_a + spring, 0.0, 0.0

    def reached(_, y):
        return gap - y[2] if motion == "closing" else k_b * (y[0] - gap) + gamma_b * y[1]

    reached.terminal, reached.direction = True, -1
    first, second = (free, closed) if motion == "closing" else (closed, free)
    start = [rest, 0.0, 0.0 if motion == "closing" else gap, 0.0]
    position = np.full(len(times), rest)
    moving = times > 0
    settings = {"rtol": 1e-6, "atol": 1e-8}
    run = solve_ivp(
        first, (0.0, times[-1]), start, t_eval=times[moving], events=reached, **settings
    )
    reported = len(run.t)  # a list where there is none
    found = run.y[0] if reported else np.empty(0)
    if run.status == 1:
        now, state = run.t_events[0][0], run.y_events[0][0]
        later = times[moving][reported:]
        state[2:] = gap, 0.0
        rerun = solve_ivp(second, (now, times[-1]), state, t_eval=later, **settings)
        found = np.concatenate([found, rerun.y[0]])
    position[moving] = found
    return position


def rate(function, count: int, rounds: int) -> float:
    """Return how many of ``count`` curves a second the function makes, median of the rounds."""
    seconds = []
    for _ in range(rounds):
        start = perf_counter()
        function()
        seconds.append(perf_counter() - start)
    return count / median(seconds)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--curves", type=int, default=20_000, help="curves of a round")
    parser.add_argument("--solved", type=int, default=100, help="curves of the ODE solver")
    parser.add_argument("--rounds", type=int, default=5)
    arguments = parser.parse_args()

    settings = yaml.safe_load(DEFAULTS.read_text(encoding="utf-8"))
    prior, sensor = Prior.from_settings(settings["prior"]), Sensor.from_settings(settings["sensor"])
    rng = generator(1, "benchmark", "mechanism")
    theta = prior.sample(arguments.curves, rng)
    onset = sensor.onset_sd * rng.standard_normal(arguments.curves)
    solved = range(min(arguments.solved, arguments.curves))
    threads = range(1, min(2, numba.config.NUMBA_NUM_THREADS) + 1)

    header = [f"{n} thread{'s'[: n > 1]}" for n in threads]
    columns = "".join(f"{name:>12}" for name in [*header, "solve_ivp", "ratio", "difference"])
    print(f"{'curves/s':<10}{columns}  (ratio on one thread; largest difference, mm)")
    for motion in MOTIONS:
        exact = travel(theta, sensor.times, motion, onset=onset).travel  # compiled from here on
        rates = []
        for n in threads:
            numba.set_num_threads(n)
            rates.append(
                rate(
                    lambda motion=motion: travel(theta, sensor.times, motion, onset=onset),
                    arguments.curves,
                    arguments.rounds,
                )
            )
        start = perf_counter()
        curves = [solve(theta[k], sensor.times - onset[k], motion) for k in solved]
        solver = len(solved) / (perf_counter() - start)
        difference = np.abs(np.array(curves) - exact[: len(solved)]).max()
        numbers = "".join(f"{value:>12,.0f}" for value in [*rates, solver, rates[0] / solver])
        print(f"{motion:<10}{numbers}{difference:>12.1e}")


if __name__ == "__main__":
    main()
