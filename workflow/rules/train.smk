"""Training of the posterior of each motion, apart and side by side.

Needs all shards of the motion's bank. Makes the model file, the history of the losses and the
convergence of the solver. Checkpoints are no outputs, for Snakemake removes those of a failed
job: they lie in checkpoints/, and a training that was killed goes on from there.
"""


rule train:
    """Train summary and inference network together."""
    input:
        shards=[
            f"results/bank/{{motion}}/shard_{shard:03d}.zarr"
            for shard in range(config["bank"]["shards"])
        ],
        code=code("train"),
    output:
        model="results/models/{motion}.safetensors",
        history=directory("results/training/{motion}_history.zarr"),
        solver=directory("results/training/{motion}_solver.zarr"),
    log:
        "logs/train/{motion}.log",
    benchmark:
        "results/benchmarks/train_{motion}.tsv"
    priority: 10  # the longest chain first: what follows fills the cores after it
    conda:
        "../../envs/breaker.yaml"
    threads: lambda wildcards: training_of_motion(wildcards)["threads"]
    resources:
        gpu=lambda wildcards: int(training_of_motion(wildcards)["device"] == "cuda"),
        runtime=lambda wildcards, attempt: training_minutes(training_of_motion(wildcards), attempt),
    params:
        seed=config["seed"],
        model=MODEL,
        prior=config["prior"],
        sensor=config["sensor"],
        network=network_of_motion,
        training=training_of_motion,
        bank=config["bank"],
    script:
        "../scripts/train.py"
