"""Rigs that the model does not fit: posteriors, trends and alarms held against their truth.

Outside of `all`. Needs what the model leaves out, and no network. Goes through the rigs in jobs of a
few, each rig with a generator of its own; an interrupted evaluation goes on with the jobs that are
missing.
"""

from math import ceil

JUDGED = config["judged"]
SINGLE = ["held_back", "foreign"]  # sets of single records


wildcard_constraints:
    family="tuning|held_back|foreign",


def jobs(count, size, path):
    """The files of as many jobs as there are rigs for."""
    return [path.format(job=job) for job in range(ceil(count / size))]


def part_of(count, size):
    """The numbers of the rigs of a job."""

    def numbers(wildcards):
        total = count[wildcards.family] if isinstance(count, dict) else count
        first = int(wildcards.chunk) * size
        return list(range(first, min(first + size, total)))

    return numbers


rule judged_records:
    """The exact posteriors of single records of some rigs."""
    input:
        discrepancy="results/discrepancy.zarr",
    output:
        "results/judged/jobs/records_{family}_{chunk}.csv",
    log:
        "logs/judged_records/{family}_{chunk}.log",
    benchmark:
        "results/benchmarks/judged_records_{family}_{chunk}.tsv"
    params:
        motions=MOTIONS,
        prior=config["prior"],
        sensor=config["sensor"],
        rigs=config["rigs"],
        judged=JUDGED,
        correction=config["correction"],
        numbers=part_of(JUDGED["rigs"], JUDGED["rigs_per_job"]),
    script:
        "../scripts/judged_records.py"


rule judged_lives:
    """Some lives of rigs, followed."""
    input:
        discrepancy="results/discrepancy.zarr",
    output:
        "results/judged/jobs/lives_{family}_{chunk}.csv",
    log:
        "logs/judged_lives/{family}_{chunk}.log",
    benchmark:
        "results/benchmarks/judged_lives_{family}_{chunk}.tsv"
    params:
        motions=MOTIONS,
        prior=config["prior"],
        sensor=config["sensor"],
        rigs=config["rigs"],
        judged=JUDGED,
        wear_model=config["wear_model"],
        numbers=part_of(JUDGED["lives"], JUDGED["lives_per_job"]),
    script:
        "../scripts/judged_lives.py"


rule judged_faults:
    """Faults at one operation of some followed rigs."""
    input:
        discrepancy="results/discrepancy.zarr",
    output:
        "results/judged/jobs/faults_{chunk}.csv",
    log:
        "logs/judged_faults/{chunk}.log",
    benchmark:
        "results/benchmarks/judged_faults_{chunk}.tsv"
    params:
        motions=MOTIONS,
        prior=config["prior"],
        sensor=config["sensor"],
        rigs=config["rigs"],
        judged=JUDGED,
        wear_model=config["wear_model"],
        numbers=part_of(JUDGED["faults"], JUDGED["faults_per_job"]),
    script:
        "../scripts/judged_faults.py"


rule judged_scores:
    """Coverage, errors, false alarms and power over all judged rigs."""
    input:
        records=[
            file
            for family in SINGLE
            for file in jobs(
                JUDGED["rigs"],
                JUDGED["rigs_per_job"],
                f"results/judged/jobs/records_{family}_{{job:03d}}.csv",
            )
        ],
        lives=[
            file
            for family, count in JUDGED["lives"].items()
            for file in jobs(
                count,
                JUDGED["lives_per_job"],
                f"results/judged/jobs/lives_{family}_{{job:03d}}.csv",
            )
        ],
        faults=jobs(
            JUDGED["faults"], JUDGED["faults_per_job"], "results/judged/jobs/faults_{job:03d}.csv"
        ),
    output:
        records="results/judged/records.csv",
        lives="results/judged/lives.csv",
        faults="results/judged/faults.csv",
    log:
        "logs/judged_scores.log",
    params:
        settle=config["wear_model"]["settle"],
        judged=JUDGED,
    script:
        "../scripts/judged_scores.py"


# How often the truth is where it should be, and how often a fault is noticed.
figure(
    "judged",
    "8 Judged rigs",
    label="judged rigs",
    of="",
    records="results/judged/records.csv",
    lives="results/judged/lives.csv",
    faults="results/judged/faults.csv",
)
