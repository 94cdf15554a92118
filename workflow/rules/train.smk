"""Training of the posterior of each motion, in separate jobs.

Needs all shards of the motion's bank. Makes the model file, the history of the losses and the
convergence of the solver. Checkpoints are not outputs, because Snakemake removes outputs of a
failed job. They are in checkpoints/, from which an interrupted training continues.
"""


rule train:
    """Train summary and inference network jointly."""
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
    priority: 10  # start the longest chain first
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
