"""The comparison on drives of the family: curves to train on, and chains to judge by.

    python -m studies.family_exact --records 5 --output results/benchmarks/peers/chains/chains.csv
    python -m studies.peers --chains results/benchmarks/peers/chains

No answer is exact here: a drive's elements are unknown, and Markov chains over all of them decide.
Arms see records of the defaults' sensor as before, of drives of the family instead of the model.
"""

from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np
import xarray as xr

from breaker.common.randomness import generator
from breaker.drive.exact.exact_posterior import divergence
from breaker.drive.simulation.drive_family import Family
from breaker.quantities.parameters import MOTIONS, NAMES
from studies.peers.common import (
    SEED,
    HeldOut,
    joint_model,
    mean_and_error,
    parser,
    read_settings,
    told_apart,
    truth,
    write_json,
)

_DRIVES = 100_000
_HELD_OUT = 1000  # of them, the last
_CHUNK = 1000  # drives that have a generator together
_DRAWS = 4000  # of a record that chains judge
_TOLD_APART = 500  # of them, by the classifier


def main() -> None:
    options = parser(__doc__.splitlines()[0], "chains/drives")
    options.add_argument("--chains", type=Path, required=True, help="folder with what they drew")
    given = options.parse_args()
    with ProcessPoolExecutor() as pool:
        chunks = list(pool.map(_chunk, range(_DRIVES // _CHUNK)))
    names = ("parameters", "onset", *MOTIONS)
    arrays = {name: np.concatenate([chunk[name] for chunk in chunks]) for name in names}
    given.out.parent.mkdir(parents=True, exist_ok=True)
    np.savez(given.out.with_suffix(".npz"), **arrays)
    shipped = {
        motion: judged([(each["exact"], each["network"]) for each in by_chains(given, motion)])
        for motion in MOTIONS
    }
    failed = sum(int(chunk["failed"]) for chunk in chunks)
    write_json(given.out, {"drives": _DRIVES, "drawn_again": failed, "shipped": shipped})


def _chunk(number: int) -> dict[str, np.ndarray]:
    """Simulate some drives: parameters, onset, curves without noise, and how many had none."""
    settings = read_settings()
    model = joint_model("closing", settings)
    family, times = Family(model.prior, settings["family"]), model.sensor.times
    rng = generator(SEED, "peers, family", number)
    found = {name: [] for name in ("parameters", "onset", *MOTIONS)}
    failed = 0
    while len(found["onset"]) < _CHUNK:
        drive, onset = family.new(rng), model.sensor.onset_sd * rng.standard_normal()
        try:
            curves = {motion: drive.travel(motion, times - onset) for motion in MOTIONS}
        except (FloatingPointError, ValueError):
            failed += 1
            continue
        row = {"parameters": drive.theta, "onset": onset} | curves
        for name, values in row.items():
            found[name].append(values)
    arrays = {name: np.array(values) for name, values in found.items()}
    single = {motion: arrays[motion].astype(np.float32) for motion in MOTIONS}
    return arrays | single | {"failed": np.array(failed)}


def drives_of(folder: Path, motion: str, settings: dict) -> tuple[xr.Dataset, HeldOut]:
    """Return the curves to train on, and the records of others."""
    model = joint_model(motion, settings)
    with np.load(folder / "drives.npz") as stored:
        curves = xr.Dataset(
            {
                "travel": (("curve", "time"), stored[motion]),
                "parameters": (("curve", "parameter"), stored["parameters"]),
                "onset": ("curve", stored["onset"]),
            },
            {"time": model.sensor.times, "parameter": list(NAMES)},
            {"motion": motion},
        )
    bank, others = curves.isel(curve=slice(-_HELD_OUT)), curves.isel(curve=slice(-_HELD_OUT, None))
    clean = others.travel.values.astype(np.float64)
    measured = model.sensor.corrupt(clean, generator(SEED, "peers, family", motion))
    return bank, HeldOut(measured, truth(others, model), model)


def by_chains(given, motion: str) -> list[dict]:
    """Return what chains drew of records: log parameters ``(d, p)``, and the records."""
    paths = sorted(given.chains.glob(f"*_{motion}_*.npz"))
    if not paths:
        raise FileNotFoundError(f"{given.chains} has no chains; run studies.family_exact into it")
    return [dict(np.load(path)) for path in paths]


def against_chains(arm, data: HeldOut, given) -> dict:
    """Judge the draws of an arm by those of chains."""
    pairs = []
    for each in by_chains(given, given.motion):
        z = arm.sample(each["record"][None], _DRAWS, given.seed)
        pairs.append((each["exact"], np.log(data.model.destandardise(z)[0, :, : len(NAMES)])))
    return judged(pairs)


def judged(pairs: list[tuple[np.ndarray, np.ndarray]]) -> dict:
    """Return how far draws are from those of chains: nats, C2ST, and ratio of sd."""
    gaps = np.array([divergence(*pair) for pair in pairs])
    told = [told_apart(*(each[:_TOLD_APART] for each in pair), seed=1) for pair in pairs]
    ratios = [other.std(axis=0) / exact.std(axis=0) for exact, other in pairs]
    return {
        "chains": len(pairs),
        "chain_gap": [float(np.median(gaps)), float(gaps.min()), float(gaps.max())],
        "c2st": mean_and_error(np.array(told)),
        "sd_ratio": float(np.median(ratios)),
    }


if __name__ == "__main__":
    main()
