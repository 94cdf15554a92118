"""An exact judge for the network of levels: Markov chains over parameters and elements.

    python -m studies.family_exact              # 20 records a motion: an hour of a core
    python -m studies.family_exact --records 2 --steps 1500
    python -m studies.family_exact --draw results/family_exact.png   # the first records, drawn

The likelihood of a drive whose elements are unknown is an integral over them, so chains walk over
all that the family draws: seven parameters, contact, elements with a strength of their own, laws,
random forces, and the onset; the zero is integrated. The simulator is that of the bank, the sensor
that of the defaults, the sampler emcee with moves by differences of walkers (0.7 DE, 0.1 DE with
gamma 1, 0.2 snooker). Unknowns are standard normal numbers; the family makes a drive of them.

Written for each record: effective size of the chains, how far their halves are apart and their last
walker behind; by how many nats the network's posterior differs from theirs, both taken for normal
in the logarithms of the parameters; and the ratio of their standard deviations.
"""

import argparse
import csv
from pathlib import Path

import emcee
import matplotlib.pyplot as plt
import numpy as np

from breaker.common.compiling import compiled, numba_or_plain
from breaker.common.randomness import generator
from breaker.configuration.loading import load
from breaker.drive.exact.exact_posterior import divergence
from breaker.drive.exact.family_scores import FamilyScores
from breaker.drive.family.level_network import Levels
from breaker.drive.family.network_files import open_network
from breaker.drive.family.record_inputs import network_record
from breaker.drive.simulation.drive_family import Family
from breaker.drive.simulation.integrator import closed_rest, follow
from breaker.drive.simulation.paths import curve, sampled
from breaker.drive.simulation.rich_drive import ELEMENTS
from breaker.mechanism.prior import Prior
from breaker.mechanism.sensor import Sensor
from breaker.quantities.parameters import MOTIONS, NAMES, PARAMETERS
from breaker.quantities.size import Size
from breaker.reading.records.normalised_shape import shape_of
from breaker.shipped import DEFAULTS, model_file

_, prange = numba_or_plain()
_TOLERANCE = 1e-5  # mm and mm/ms, error of a step
_LINKAGE = len(NAMES) + ELEMENTS.index("linkage")
_MOVES = [
    (emcee.moves.DEMove(), 0.7),
    (emcee.moves.DEMove(gamma0=1.0), 0.1),
    (emcee.moves.DESnookerMove(), 0.2),
]
_FIRST = 3000  # draws of the prior, of which walkers start at the best
_WALKERS = 2  # for each unknown
_BEFORE = 800  # steps of a first run
_STUCK = 25.0  # nats; some four sd of the log density of a hundred unknowns
_LOOKED_AT = 12  # scores whose chains are judged: the kind of contact, and the parameters
_DRAWS = 4000


@compiled(parallel=True)
def curves(numbers, closing, times, begins):
    """Travel of drives of size 1 ``(n, p + e)`` at times, released at begins ``(n,)``, ``(n, t)``.

    It is nan of a drive that does not work, or whose curve is not finite.
    """
    found = np.full((len(numbers), times.size), np.nan)
    for i in prange(len(numbers)):
        rest, at = closed_rest(numbers[i]), times - begins[i]
        if np.isfinite(rest):
            steps = follow(numbers[i], rest, closing, max(at[-1], 1e-9), np.inf, _TOLERANCE)[0]
            if len(steps):
                found[i] = sampled(curve(steps, numbers[i, _LINKAGE]), at)
    return found


def log_posterior(family: FamilyScores, sensor, motion, record, scores) -> np.ndarray:
    """Log densities of scores ``(w, m + 1)``, the last that of the onset, but for a constant."""
    drives = family.numbers(scores[:, :-1])
    there = curves(drives, motion == "closing", sensor.times, sensor.onset_sd * scores[:, -1])
    found = np.isfinite(there).all(axis=1)
    log_prior = family.log_prior(scores[:, :-1]) - 0.5 * np.square(scores[:, -1])
    chi_square = sensor.chi_square(record, np.where(found[:, None], there, 0.0))
    return np.where(found, log_prior - 0.5 * chi_square, -np.inf)


def by_chains(family: FamilyScores, sensor, motion, record, steps, rng):
    """Draws of the logarithms of the parameters, ``(d, p)``, and how far the chains have come.

    Walkers that are stuck far below the others after a first run start anew among these (Hou et al.
    2012). Returned are further the effective size, the largest distance of the means of the two
    halves of what is kept, in sd, and by how many nats the last walker is below the median.
    """
    unknowns = family.unknowns + 1  # and the onset
    walkers = _WALKERS * unknowns

    def log_density(scores):
        return log_posterior(family, sensor, motion, record, scores)

    first = rng.standard_normal((_FIRST, unknowns))
    start = first[np.argsort(-log_density(first))[:walkers]]
    sampler = emcee.EnsembleSampler(walkers, unknowns, log_density, moves=_MOVES, vectorize=True)
    sampler.random_state = np.random.RandomState(int(rng.integers(2**31))).get_state()
    sampler.run_mcmc(start, _BEFORE)
    density = sampler.get_log_prob()[-1]
    arrived = np.flatnonzero(density > np.median(density) - _STUCK)
    late = np.unique(sampler.get_chain()[_BEFORE // 2 :, arrived].reshape(-1, unknowns), axis=0)
    start = late[rng.permutation(len(late))[:walkers]]
    sampler.reset()
    sampler.run_mcmc(start, steps)
    density = sampler.get_log_prob()[-1]
    stuck = np.median(density) - density.min()
    kept = sampler.get_chain(discard=steps // 4)[..., :_LOOKED_AT]
    time = np.nanmax(emcee.autocorr.integrated_time(kept, quiet=True))
    one, two = (each.mean(axis=(0, 1)) for each in np.array_split(kept, 2))
    apart = np.abs(one - two) / kept.std(axis=(0, 1))
    flat = sampler.get_chain(discard=steps // 4, flat=True)
    chosen = flat[rng.integers(0, len(flat), _DRAWS)]
    draws = np.log(family.numbers(chosen[:, :-1])[:, : len(NAMES)])
    return draws, walkers * (steps - steps // 4) / time, apart.max(), stuck


def by_network(levels: Levels, sensor, motion, record, rng) -> np.ndarray:
    """The same by the network, which is told the size."""
    step = float(sensor.times[1] - sensor.times[0])
    shape = shape_of(record if motion == "closing" else -record, step)
    seen = network_record(shape, sensor.noise_sd, 0.0, step)
    return np.log(levels.draw({motion: seen}, _DRAWS, rng, size=Size()).theta)


def draw(table: Path, picture: Path) -> None:
    """Draw the marginals of both for the first two records of each motion."""
    figure, axes = plt.subplots(4, len(NAMES), figsize=(13, 6.5), layout="constrained")
    for row, (i, motion) in enumerate((i, motion) for motion in MOTIONS for i in range(2)):
        with np.load(table.with_name(f"{table.stem}_{motion}_{i}.npz")) as found:
            by = {name: np.exp(found[name]) for name in ("exact", "network", "truth")}
        for k, axis in enumerate(axes[row]):
            edges = np.histogram_bin_edges(np.hstack([by["exact"][:, k], by["network"][:, k]]), 40)
            axis.hist(by["exact"][:, k], edges, density=True, color="0.75", label="chains")
            axis.hist(by["network"][:, k], edges, density=True, histtype="step", label="network")
            axis.axvline(by["truth"][k], color="k", ls="--", lw=1.0, label="truth")
            axis.set(yticks=[])
            if row == 0:
                axis.set_title(f"{PARAMETERS[k].symbol} ({PARAMETERS[k].unit or '1'})")
        axes[row, 0].set_ylabel(f"{motion} {i + 1}")
    figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=3)
    figure.savefig(picture, dpi=100)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--records", type=int, default=20, help="of each motion")
    parser.add_argument("--steps", type=int, default=2000, help="of the chains")
    parser.add_argument("--output", type=Path, default=Path("family_exact.csv"))
    parser.add_argument("--draw", type=Path, metavar="PNG", help="draw a run that there is")
    options = parser.parse_args()
    if options.draw:
        draw(options.output, options.draw)
        return
    config = load([DEFAULTS])
    family = Family(Prior.from_settings(config["prior"]), config["family"])
    sensor = Sensor(**config["sensor"])
    levels = open_network(model_file("medium_voltage", "levels"))
    scores = FamilyScores.of(family, generator(5, "exact judge of the family, kinds"))
    options.output.parent.mkdir(parents=True, exist_ok=True)
    with options.output.open("w", newline="") as file:
        table = csv.writer(file)
        table.writerow(["motion", "record", "effective_size", "apart", "stuck", "gap", *NAMES])
        for i in range(options.records):
            for motion in MOTIONS:
                rng = generator(5, "exact judge of the family", motion, i)
                drive = family.new(rng)
                times = sensor.times - sensor.onset_sd * rng.standard_normal()
                record = sensor.corrupt(drive.travel(motion, times)[None], rng)[0]
                given = scores, sensor, motion, record, options.steps, rng
                exact, size, apart, stuck = by_chains(*given)
                network = by_network(levels, sensor, motion, record, rng)
                ratios = network.std(axis=0) / exact.std(axis=0)
                gap = divergence(exact, network)
                draws = options.output.with_name(f"{options.output.stem}_{motion}_{i}.npz")
                both = {"exact": exact, "network": network}
                np.savez_compressed(draws, **both, truth=np.log(drive.theta), record=record)
                told = f"{size:.0f}", f"{apart:.2f}", f"{stuck:.0f}", f"{gap:.3f}"
                table.writerow([motion, i, *told, *ratios.round(2)])
                file.flush()
                print(f"{motion} {i}: effective size {size:.0f}, gap {gap:.2f} nats", flush=True)


if __name__ == "__main__":
    main()
