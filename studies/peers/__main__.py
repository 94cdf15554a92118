"""Other tools beside this one: train, judge, measure, two processes side by side on two cores.

    python -m studies.peers

What is finished is skipped, so that it goes on where it was interrupted; delete a JSON file to have
it made anew. Banks are those of the workflow (results/bank); the tables are made by table.py.
"""

import argparse
import os
import subprocess
import sys
from concurrent.futures import FIRST_COMPLETED, ThreadPoolExecutor, wait
from dataclasses import dataclass
from pathlib import Path
from queue import SimpleQueue

from studies.peers.common import RESULTS
from studies.peers.tools import TOOLS


@dataclass(frozen=True)
class Job:
    """One process: the file that it writes, the files that it needs, and its command."""

    makes: Path
    needs: tuple[Path, ...]
    script: str
    arguments: tuple[str, ...]


def jobs(motion: str, given: argparse.Namespace) -> list[Job]:
    """Return the jobs of a motion, in an order in which no job waits for a later one."""
    folder = given.results / motion
    common = ("--motion", motion, "--seed", str(given.seed))
    bank, model = str(given.banks / motion), folder / "breaker" / "model.safetensors"
    trained = {tool: folder / tool / "training.json" for tool in TOOLS}
    evidence = folder / "evidence.json"
    reference = ("--model", str(model), "--out")
    train = ("--bank", bank, "--seconds", str(given.seconds), "--out")
    listed = [
        Job(trained[tool], (), "train", ("--tool", tool, *train, str(folder / tool)))
        for tool in TOOLS
    ]
    needs = (trained["breaker"],)
    listed.append(Job(evidence, needs, "evidence", (*reference, str(evidence))))
    listed += [
        Job(
            folder / tool / "score.json",
            (trained[tool], evidence),
            "score",
            ("--tool", tool, "--model", str(folder / tool), "--evidence", str(evidence)),
        )
        for tool in TOOLS
    ]
    simulators, alternatives = folder / "simulators.json", folder / "alternatives.json"
    listed.append(Job(simulators, (), "simulators", ("--out", str(simulators))))
    options = ("--bank", bank, *reference, str(alternatives))
    listed.append(Job(alternatives, needs, "alternatives", options))
    return [Job(job.makes, job.needs, job.script, (*job.arguments, *common)) for job in listed]


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--motions", nargs="+", default=["closing", "opening"])
    options.add_argument("--banks", type=Path, default=Path("results/bank"))
    options.add_argument("--results", type=Path, default=RESULTS)
    options.add_argument("--seconds", type=float, default=600.0, help="processor time to train")
    options.add_argument("--seed", type=int, default=1)
    options.add_argument("--cores", type=int, nargs="+", help="(the first two of this machine)")
    given = options.parse_args()

    listed = [job for motion in given.motions for job in jobs(motion, given)]
    waiting = [job for job in listed if not job.makes.exists()]
    print(f"{len(listed) - len(waiting)} of {len(listed)} jobs are done already", flush=True)
    cores: SimpleQueue[int] = SimpleQueue()
    available = given.cores or sorted(os.sched_getaffinity(0))[:2]
    for core in available:
        cores.put(core)

    running, failed = {}, []
    with ThreadPoolExecutor(len(available)) as pool:
        while waiting or running:
            ready = [job for job in waiting if all(path.exists() for path in job.needs)]
            for job in ready[: len(available) - len(running)]:
                waiting.remove(job)
                running[pool.submit(start, job, cores)] = job
            if not running:
                break
            for future in wait(running, return_when=FIRST_COMPLETED).done:
                job = running.pop(future)
                if future.result():
                    failed.append(job)
                print(f"{'FAILED' if future.result() else 'done'}: {job.makes}", flush=True)
    for job in failed:
        print(f"failed: {job.makes}; see {job.makes.with_suffix('.log')}")
    for job in waiting:
        print(f"not made, for what it needs failed: {job.makes}")
    sys.exit(bool(failed or waiting))


def start(job: Job, cores: SimpleQueue) -> int:
    """Run a job on a free core and return its exit status."""
    core = cores.get()
    try:
        job.makes.parent.mkdir(parents=True, exist_ok=True)
        command = [
            sys.executable,
            "-m",
            f"studies.peers.{job.script}",
            *job.arguments,
            "--core",
            str(core),
        ]
        with job.makes.with_suffix(".log").open("w") as log:
            log.write(" ".join(command) + "\n")
            log.flush()
            return subprocess.run(command, stdout=log, stderr=subprocess.STDOUT).returncode
    finally:
        cores.put(core)


if __name__ == "__main__":
    main()
