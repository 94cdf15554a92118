"""Simulated operations: the prior predictive, the training banks, and what the model leaves out.

Needs nothing but the configuration. Makes one Zarr store a shard, each a job of its own, whose
content depends on the seed, the prior, the grid, the onset, the motion and its number; and one
store of the differences between the model and drives of a family that it does not fit.
"""


rule prior_predictive:
    """Operations drawn from the prior, to look at."""
    output:
        directory("results/prior_predictive/{motion}.zarr"),
    log:
        "logs/prior_predictive/{motion}.log",
    params:
        seed=config["seed"],
        purpose=["prior predictive"],
        curves=config["prior_predictive"]["curves"],
        prior=config["prior"],
        grid=GRID,
        onset_sd=config["sensor"]["onset_sd"],
    script:
        "../scripts/simulate.py"


rule bank_shard:
    """One shard of the training bank of one motion."""
    output:
        directory("results/bank/{motion}/shard_{shard}.zarr"),
    log:
        "logs/bank/{motion}_{shard}.log",
    priority: 10  # the longest chain first: what follows fills the cores after it
    params:
        seed=config["seed"],
        purpose=lambda wildcards: ["bank", int(wildcards.shard)],
        curves=config["bank"]["curves_per_shard"],
        prior=config["prior"],
        grid=GRID,
        onset_sd=config["sensor"]["onset_sd"],
    script:
        "../scripts/simulate.py"


rule discrepancy:
    """What the model leaves out of both motions, learned from drives that are richer than it."""
    output:
        directory("results/discrepancy.zarr"),
    log:
        "logs/discrepancy.log",
    params:
        seed=config["seed"],
        motions=MOTIONS,
        prior=config["prior"],
        sensor=config["sensor"],
        rigs=config["rigs"],
        size=config["size"],
        discrepancy=config["discrepancy"],
    script:
        "../scripts/discrepancy.py"


rule discrepancy_cost:
    """What each error of a record costs, what the model leaves out among them."""
    input:
        discrepancy="results/discrepancy.zarr",
    output:
        directory("results/discrepancy_cost/{motion}.zarr"),
    log:
        "logs/discrepancy_cost/{motion}.log",
    params:
        seed=config["seed"],
        prior=config["prior"],
        sensor=config["sensor"],
        curves=config["identifiability"]["curves"],
    script:
        "../scripts/discrepancy_cost.py"


# What the model leaves out, and what it costs.
figure(
    "discrepancy",
    "1 Simulation",
    label="what the model leaves out",
    params={"noise_sd": config["sensor"]["noise_sd"]},
    discrepancy="results/discrepancy.zarr",
    cost="results/discrepancy_cost/{motion}.zarr",
)
