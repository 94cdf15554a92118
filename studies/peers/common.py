"""What all processes of the comparison share: threads, clocks, and curves."""

import argparse
import json
import os
import platform
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from datetime import date
from importlib.metadata import distributions
from pathlib import Path

import numpy as np
import xarray as xr

from breaker.common.randomness import generator
from breaker.model.parameters import MOTIONS
from breaker.paper.bank import simulate
from breaker.paper.joint_model import Model

RESULTS = Path("results/benchmarks/peers")
SEED = 101  # of the held-out curves; no bank has it

_ROWS = 262_144  # of the bank, as many as in the workflow's
_WARM_UP = 0.03  # share of the budget by which two short trainings differ, at least
_PACKAGES = ("breaker-drive", "bayesflow", "keras", "jax", "sbi", "zuko", "torch", "numpy", "scipy")
_PACKAGES += ("numba", "scikit-learn")

CLOCKS = {"wall": time.perf_counter, "processor": time.process_time}
"""Seconds that have passed, and those of all threads and processors of this process together."""


def parser(description: str, makes: str = "") -> argparse.ArgumentParser:
    """Return a parser with the options that all of them share, and the file that they make."""
    options = argparse.ArgumentParser(description=description)
    options.add_argument("--motion", choices=MOTIONS, default="closing")
    options.add_argument("--seed", type=int, default=1, help="of weights, batches and draws")
    options.add_argument("--threads", type=int, default=1, help="and processor cores")
    options.add_argument("--out", type=Path, default=RESULTS / f"{makes}.json")
    return options


def restart(threads: int, **environment: str) -> None:
    """Start this process anew with so many threads, each with a core, unless it runs so already.

    Libraries choose their number of threads when they are loaded, so setting it later would be
    too late. Further environment variables are set on the way.
    """
    names = ("OMP", "OPENBLAS", "MKL", "NUMBA")
    wanted = {f"{name}_NUM_THREADS": str(threads) for name in names} | environment
    wanted |= {"CUDA_VISIBLE_DEVICES": "", "JAX_PLATFORMS": "cpu"}
    wanted["XLA_FLAGS"] = f"--xla_cpu_multi_thread_eigen={str(threads > 1).lower()}"
    if wanted.items() <= os.environ.items():
        return
    os.sched_setaffinity(0, sorted(os.sched_getaffinity(0))[:threads])
    os.environ.update(wanted)
    os.execv(sys.executable, sys.orig_argv)


def plan(run: Callable[[int], object], given: argparse.Namespace, unit: int) -> dict:
    """Find how many steps of a training fit into a budget.

    Two short trainings, with few and with several times as many steps, tell the seconds of a step
    from those of set-up and compilation. Neither counts: the training starts anew afterwards.

    Args:
        run: Does a whole training of so many steps, from nothing.
        given: With ``clock`` and ``seconds``, the budget.
        unit: Steps that hold all that happens now and then, such as an evaluation.
    """
    clock = CLOCKS[given.clock]

    def spent(steps: int) -> float:
        begin = clock()
        run(steps)
        return clock() - begin

    spent(unit)  # what a process does but once
    few, units = spent(unit), 3
    while (many := spent(units * unit)) - few < _WARM_UP * given.seconds:
        units *= 3
    step = (many - few) / ((units - 1) * unit)
    set_up = max(0.0, few - unit * step)
    steps = max(unit, int((given.seconds - set_up) / step) // unit * unit)
    return {"steps": steps, "seconds_per_step": step, "seconds_of_set_up": set_up}


def bank_of(model: Model) -> xr.Dataset:
    """Simulate the rows that every arm trains on, the same for all seeds."""
    return simulate(model, _ROWS, generator(SEED, "peers bank", model.motion))


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


def classifier_accuracy(one: np.ndarray, other: np.ndarray, seed: int) -> float:
    """Accuracy with which sbi's classifier tells two sets of draws ``(d, q)`` apart."""
    import torch
    from sbi.utils.metrics import c2st

    pair = (torch.from_numpy(draws).float() for draws in (one, other))
    return float(c2st(*pair, seed=seed, classifier="mlp"))


def write_json(path: Path, record: dict) -> None:
    """Write a record, together with where and with what it was made; whole or not at all."""
    path.parent.mkdir(parents=True, exist_ok=True)
    text = json.dumps({**record, "machine": _machine()}, indent=1, default=float)
    partial = path.with_suffix(".partial")
    partial.write_text(text + "\n", encoding="utf-8")
    partial.replace(path)


def _machine() -> dict:
    """Return what a run was made with; packages that are not there are left out."""
    known = {each.name: each.version for each in distributions() if each.name in _PACKAGES}
    return {
        "processor": platform.processor() or platform.machine(),
        "cores": os.cpu_count(),
        "system": f"{platform.system()} {platform.machine()}",
        "date": date.today().isoformat(),
        "versions": {"python": platform.python_version()} | dict(sorted(known.items())),
    }
