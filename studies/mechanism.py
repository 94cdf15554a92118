"""Speed and memory of the exact mechanism and its derivatives.

    python -m studies.mechanism            # 2^14 and 2^20 operations held in memory: 1.3 GB
    python -m studies.mechanism --large    # 2^22 as well: 5.2 GB

Records of the default prior and sensor (151 samples, random onsets). Rates are by the clock, on one
thread and on two; the ratio is of processor time on one thread, in rounds that alternate, so that a
busy machine slows both sides; the median round counts. Memory is the most that ``tracemalloc`` sees
beside the output. ODE solvers stand beside the mechanism in ``studies.peers.simulators``.
"""

import argparse
import tracemalloc
from collections.abc import Callable
from statistics import median
from time import perf_counter, process_time

import numba

from breaker.common.randomness import generator
from breaker.configuration.loading import read
from breaker.mechanism.curves import sensitivity, travel
from breaker.mechanism.prior import Prior
from breaker.mechanism.sensor import Sensor
from breaker.paper.model.joint_model import Model
from breaker.paper.model.simulation_bank import simulate
from breaker.quantities.parameters import MOTIONS
from breaker.shipped import DEFAULTS


def seconds(function: Callable[[], object], clock: Callable[[], float]) -> float:
    """Return how long a call takes."""
    start = clock()
    function()
    return clock() - start


def print_speed(prior: Prior, sensor: Sensor, arguments: argparse.Namespace) -> None:
    """Print rates, and how much longer derivatives take."""
    rng = generator(1, "benchmark", "mechanism")
    theta, times = prior.sample(arguments.curves, rng), sensor.times
    onset = sensor.onset_sd * rng.standard_normal(arguments.curves)
    threads = range(1, min(2, numba.config.NUMBA_NUM_THREADS) + 1)

    header = [f"{n} thread{'s'[: n > 1]}" for n in threads]
    header += ["per core-s", "derivatives", "ratio"]
    print(f"{'curves/s':<10}" + "".join(f"{name:>12}" for name in header))
    for motion in MOTIONS:

        def curves(motion=motion):
            return travel(theta, times, motion, onset=onset)

        def derivatives(motion=motion):
            return sensitivity(theta, times, motion, onset=onset)

        derivatives()  # compiled from here on, as the curves are
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
        numbers += [len(theta) / median(column) for column in zip(*rounds, strict=True)]
        ratio = median(second / first for first, second in rounds)
        print(f"{motion:<10}" + "".join(f"{v:>12,.0f}" for v in numbers) + f"{ratio:>12.1f}")
    print("derivatives: curves with all eight; ratio: of their times to those of curves")


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
    parser.add_argument("--rounds", type=int, default=9)
    parser.add_argument("--large", action="store_true", help="memory at 2^22 operations as well")
    arguments = parser.parse_args()

    settings = read(DEFAULTS)
    prior, sensor = Prior.from_settings(settings["prior"]), Sensor.from_settings(settings["sensor"])
    print_speed(prior, sensor, arguments)
    print_memory(prior, sensor, [2**14, 2**20, *([2**22] if arguments.large else [])])


if __name__ == "__main__":
    main()
