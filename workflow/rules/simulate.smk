"""Simulated operations: the prior predictive, and the training banks.

Needs only the configuration. Makes one Zarr store a shard, in one job a shard. The content of a
shard depends on the seed, the prior, the grid, the onset, the motion and the shard number.
"""


rule prior_predictive:
    """Simulate operations from the prior, for the prior predictive check."""
    input:
        code=code("simulate"),
    output:
        directory("results/prior_predictive/{motion}.zarr"),
    log:
        "logs/prior_predictive/{motion}.log",
    benchmark:
        "results/benchmarks/prior_predictive_{motion}.tsv"
    conda:
        "../../envs/breaker.yaml"
    params:
        seed=config["seed"],
        purpose=["prior predictive"],
        curves=config["validation"]["prior_curves"],
        model=MODEL,
        prior=config["prior"],
        grid=GRID,
        onset_sd=config["sensor"]["onset_sd"],
    script:
        "../scripts/simulate.py"


rule bank_shard:
    """Simulate one shard of the training bank of one motion."""
    input:
        code=code("simulate"),
    output:
        directory("results/bank/{motion}/shard_{shard}.zarr"),
    log:
        "logs/bank/{motion}_{shard}.log",
    benchmark:
        "results/benchmarks/bank_{motion}_{shard}.tsv"
    priority: 10  # start the longest chain first
    conda:
        "../../envs/breaker.yaml"
    params:
        seed=config["seed"],
        purpose=lambda wildcards: ["bank", int(wildcards.shard)],
        curves=config["bank"]["curves_per_shard"],
        model=MODEL,
        prior=config["prior"],
        grid=GRID,
        onset_sd=config["sensor"]["onset_sd"],
    script:
        "../scripts/simulate.py"
