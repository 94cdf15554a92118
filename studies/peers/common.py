"""What all processes of the comparison share: one core, the clock, the curves, the exact density.

Everything is counted in processor time of a process that is pinned to one core, so that two may
run side by side on a shared machine without costing each other anything but caches.
"""

import argparse
import json
import os
import platform
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from datetime import date
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import numpy as np
import xarray as xr

from breaker.mechanism import MOTIONS
from breaker.model import Model, generator, open_bank, simulate
from breaker.shipped import DEFAULTS
from breaker.workflow import read

__all__ = [
    "RESULTS",
    "HeldOut",
    "clock",
    "held_out",
    "joint_model",
    "mean_and_error",
    "one_core",
    "parser",
    "plan",
    "read_bank",
    "read_settings",
    "truth",
    "write_json",
]

RESULTS = Path("results/benchmarks/peers")
SEED = 101  # of the held-out curves; no bank has it

_ONE_THREAD = {
    name: "1"
    for name in (
        "OMP_NUM_THREADS",
        "OPENBLAS_NUM_THREADS",
        "MKL_NUM_THREADS",
        "NUMBA_NUM_THREADS",
    )
}
_XLA = "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1"
_PACKAGES = ("breaker", "bayesflow", "keras", "jax", "sbi", "zuko", "diffrax", "emcee", "torch")
_PACKAGES += ("numpy", "scipy", "numba")

clock = time.process_time
"""Processor seconds of this process, all its threads together."""


def parser(description: str) -> argparse.ArgumentParser:
    """Return a parser with the options that all of them share."""
    options = argparse.ArgumentParser(description=description)
    options.add_argument("--motion", choices=MOTIONS, default="closing")
    options.add_argument("--seed", type=int, default=1, help="of weights, batches and draws")
    options.add_argument("--core", type=int, default=0, help="processor core to run on")
    return options


def one_core(core: int, **environment: str) -> None:
    """Start this process anew on one core with one thread, unless it is there already.

    Libraries choose their number of threads when they are loaded, so setting it later would be
    too late. Further environment variables are set on the way.
    """
    wanted = {**_ONE_THREAD, "XLA_FLAGS": _XLA, "CUDA_VISIBLE_DEVICES": "", **environment}
    if os.sched_getaffinity(0) == {core} and wanted.items() <= os.environ.items():
        return
    os.sched_setaffinity(0, {core})
    os.environ.update(wanted)
    os.execv(sys.executable, sys.orig_argv)


def plan(run: Callable[[int], object], seconds: float, *, unit: int, warm_up: float = 20.0) -> dict:
    """Find how many steps of a training fit into a budget of processor time.

    Two short trainings, with few and with several times as many steps, tell the seconds of a step
    from those of set-up and compilation. Neither counts: the training starts anew afterwards.

    Args:
        run: Does a whole training of so many steps, from nothing.
        seconds: The budget.
        unit: Steps that hold all that happens now and then, such as an evaluation.
        warm_up: Processor seconds to spend on the second training, at least.
    """

    def spent(steps: int) -> float:
        begin = clock()
        run(steps)
        return clock() - begin

    few = spent(unit)
    units = 3
    many = spent(units * unit)
    while many < warm_up:
        units *= 3
        many = spent(units * unit)
    step = (many - few) / ((units - 1) * unit)
    set_up = max(0.0, few - unit * step)
    return {
        "steps": max(unit, int((seconds - set_up) / step)),
        "seconds_per_step": step,
        "seconds_of_set_up": set_up,
    }


def read_settings() -> dict:
    """Return the default configuration."""
    return read(DEFAULTS)


def read_bank(folder: Path, settings: dict) -> xr.Dataset:
    """Read the bank of a folder and check that it was made with the settings' prior and grid."""
    bank = open_bank(sorted(folder.glob("shard_*.zarr")))[:]
    made = json.loads(bank.attrs["settings"])
    sensor = settings["sensor"]
    grid = {key: sensor[key] for key in ("start", "stop", "samples")}
    asked = {"prior": settings["prior"], "grid": grid, "onset_sd": sensor["onset_sd"]}
    if any(made[key] != asked[key] for key in asked):
        raise ValueError(f"{folder} was made with other settings than config/config.yaml")
    return bank


def joint_model(motion: str, settings: dict) -> Model:
    """Return the exact joint model of a motion."""
    return Model.from_settings({**settings, "motion": motion})


def truth(bank: xr.Dataset, model: Model) -> np.ndarray:
    """Return what is inferred of a bank's rows, standardised, ``(n, q)``."""
    return model.standardise(np.column_stack([bank.parameters.values, bank.onset.values]))


@dataclass(frozen=True)
class HeldOut:
    """Records that nothing was trained on.

    Attributes:
        measured: Records, ``(n, t)``, mm.
        z: Their truth, standardised, ``(n, q)``: log parameters in prior sd, onset in its own.
        model: What made them.
    """

    measured: np.ndarray
    z: np.ndarray
    model: Model


def held_out(motion: str, settings: dict, curves: int) -> HeldOut:
    """Return the held-out records of a motion, always the same; fewer are the first of more."""
    model = joint_model(motion, settings)
    rng, sensor = generator(SEED, "peers", motion), model.sensor
    data = simulate(model, 1000, rng)
    measured = sensor.corrupt(data.travel.values.astype(np.float64), rng)
    return HeldOut(measured[:curves], truth(data, model)[:curves], model)


def mean_and_error(values: np.ndarray) -> list[float]:
    """Return the mean of values and its standard error."""
    return [float(np.mean(values)), float(np.std(values, ddof=1) / np.sqrt(len(values)))]


def write_json(path: Path, record: dict) -> None:
    """Write a record, together with where and with what it was made; whole or not at all."""
    path.parent.mkdir(parents=True, exist_ok=True)
    text = json.dumps({**record, "machine": _machine()}, indent=1, default=float)
    partial = path.with_suffix(".partial")
    partial.write_text(text + "\n", encoding="utf-8")
    partial.replace(path)


def _machine() -> dict:
    versions = {"python": platform.python_version()}
    for package in _PACKAGES:
        try:
            versions[package] = version(package)
        except PackageNotFoundError:
            versions[package] = "none"
    return {
        "processor": _processor(),
        "cores": os.cpu_count(),
        "system": f"{platform.system()} {platform.machine()}",
        "date": date.today().isoformat(),
        "versions": versions,
    }


def _processor() -> str:
    information = Path("/proc/cpuinfo")
    if not information.exists():
        return platform.processor()
    lines = information.read_text(encoding="utf-8").splitlines()
    entry = dict(line.replace("\t", "").split(":", 1) for line in reversed(lines) if ":" in line)
    names = ("model name", "cpu family", "model")
    model, family, number = (entry.get(name, "unknown").strip() for name in names)
    return f"{model} (family {family}, model {number})"
