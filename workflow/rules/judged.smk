"""Rigs that the model does not fit: trends and alarms held against their truth.

Outside of `all`. Needs what the model leaves out, and no network. Goes through the rigs in jobs of a
few, each rig with a generator of its own; an interrupted evaluation goes on with the jobs that are
missing.
"""

JUDGED = config["judged"]


wildcard_constraints:
    family="tuning|held_back|foreign",


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
        size=config["size"],
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
        size=config["size"],
        judged=JUDGED,
        wear_model=config["wear_model"],
        numbers=part_of(JUDGED["faults"], JUDGED["faults_per_job"]),
    script:
        "../scripts/judged_faults.py"


rule judged_scores:
    """Coverage, errors, false alarms and power over all judged rigs."""
    input:
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
    lives="results/judged/lives.csv",
    faults="results/judged/faults.csv",
)
