"""Speed and memory of the exact mechanism and its derivatives, beside an ODE solver.

    python -m studies.mechanism            # 2^14 and 2^20 operations held in memory: 1.3 GB
    python -m studies.mechanism --large    # 2^22 as well: 5.2 GB

Records of the default prior and sensor (151 samples, random onsets). Rates are by the clock, on one
thread and on two; ratios are of processor time on one thread, in rounds that alternate, so that a
busy machine slows both sides; the median round counts. The solver is ``scipy.integrate.solve_ivp``
(RK45, rtol 1e-6, event located). Memory is the most that ``tracemalloc`` sees beside the output.
"""

import argparse
import tracemalloc
from collections.abc import Callable
from statistics import median
from time import perf_counter, process_time

import numba
import numpy as np
from scipy.integrate import solve_ivp

from breaker.mechanism import MOTIONS, rest_position, sensitivity, travel
from breaker.model import Model, Prior, Sensor, generator, simulate
from breaker.shipped import DEFAULTS
from breaker.workflow import read


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


def seconds(function: Callable[[], object], clock: Callable[[], float]) -> float:
    """Return how long a call takes."""
    start = clock()
    function()
    return clock() - start


def print_speed(prior: Prior, sensor: Sensor, arguments: argparse.Namespace) -> None:
    """Print rates, ratios and the largest difference from the solver."""
    rng = generator(1, "benchmark", "mechanism")
    theta, times = prior.sample(arguments.curves, rng), sensor.times
    onset = sensor.onset_sd * rng.standard_normal(arguments.curves)
    solved = min(arguments.solved, arguments.curves)
    threads = range(1, min(2, numba.config.NUMBA_NUM_THREADS) + 1)

    header = [f"{n} thread{'s'[: n > 1]}" for n in threads]
    header += ["per core-s", "derivatives", "ratio", "solve_ivp", "ratio", "difference"]
    print(f"{'curves/s':<10}" + "".join(f"{name:>12}" for name in header))
    for motion in MOTIONS:

        def curves(motion=motion):
            return travel(theta, times, motion, onset=onset)

        def derivatives(motion=motion):
            return sensitivity(theta, times, motion, onset=onset)

        exact = derivatives()[0].travel  # both are compiled from here on
        numbers = []
        for n in threads:
            numba.set_num_threads(n)
            clocks = [seconds(curves, perf_counter) for _ in range(arguments.rounds)]
            numbers.append(len(theta) / median(clocks))
        numba.set_num_threads(1)
        rounds = [
            (seconds(curves, process_time), seconds(derivatives, process_time))
            for _ in range(arguments.rounds)
        ]
        one, both = (median(column) / len(theta) for column in zip(*rounds, strict=True))
        start = process_time()
        found = [solve(theta[k], times - onset[k], motion) for k in range(solved)]
        solver = (process_time() - start) / solved
        difference = np.abs(np.array(found) - exact[:solved]).max()
        ratio = median(second / first for first, second in rounds)
        numbers += [1 / one, 1 / both]
        print(
            f"{motion:<10}"
            + "".join(f"{value:>12,.0f}" for value in numbers)
            + f"{ratio:>12.1f}{1 / solver:>12,.0f}{solver / one:>12,.0f}{difference:>12.1e}"
        )
    print("derivatives: curves with all eight; ratios: derivatives to curves, curves to solve_ivp")


def print_memory(prior: Prior, sensor: Sensor, sizes: list[int]) -> None:
    """Print the memory that curves and banks need beside themselves."""

    def curves(n: int) -> int:
        result = travel(prior.medians[None].repeat(n, axis=0), sensor.times, "closing")
        return sum(each.nbytes for each in result)

    def bank(n: int) -> int:
        rng = generator(1, "benchmark", "bank")
        result = simulate(Model(prior, sensor, "closing"), n, rng)
        return sum(array.nbytes for array in result.variables.values())

    print(f"\n{'MB':<10}{'operations':>12}{'output':>12}{'beside it':>12}")
    for name, make, given in (("curves", curves, 56), ("bank", bank, 0)):
        make(1)  # compiled from here on
        for n in sizes:
            tracemalloc.start()
            output = make(n) + given * n  # the parameters of the curves are given
            peak = tracemalloc.get_traced_memory()[1]
            tracemalloc.stop()
            print(f"{name:<10}{n:>12,}{output / 1e6:>12,.1f}{(peak - output) / 1e6:>12.2f}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--curves", type=int, default=20_000, help="curves of a round")
    parser.add_argument("--solved", type=int, default=100, help="curves of the ODE solver")
    parser.add_argument("--rounds", type=int, default=9)
    parser.add_argument("--large", action="store_true", help="memory at 2^22 operations as well")
    arguments = parser.parse_args()

    settings = read(DEFAULTS)
    prior, sensor = Prior.from_settings(settings["prior"]), Sensor.from_settings(settings["sensor"])
    print_speed(prior, sensor, arguments)
    print_memory(prior, sensor, [2**14, 2**20, *([2**22] if arguments.large else [])])


if __name__ == "__main__":
    main()
