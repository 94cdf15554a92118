"""Every network of the paper against every other.

Needs the banks, and the corrected validation for the evidence. Makes a model of each combination of
summary and inference networks, and one table a motion. The rules are those of the workflow with
other inputs, outputs and settings, and run its scripts.
"""


rule train_network:
    """Train a combination of networks."""
    input:
        shards=[
            f"results/bank/{{motion}}/shard_{shard:03d}.zarr"
            for shard in range(config["bank"]["shards"])
        ],
        code=code("train"),
    output:
        model="results/networks/{network}/{motion}.safetensors",
        history=directory("results/networks/{network}/{motion}_history.zarr"),
        solver=directory("results/networks/{network}/{motion}_solver.zarr"),
    log:
        "logs/networks/{network}/train_{motion}.log",
    benchmark:
        "results/networks/{network}/{motion}_train.tsv"
    conda:
        "../../envs/breaker.yaml"
    threads: lambda wildcards: training_of(wildcards)["threads"]
    params:
        seed=config["seed"],
        model=MODEL,
        prior=config["prior"],
        sensor=config["sensor"],
        network=network_of,
        training=training_of,
        bank=config["bank"],
    script:
        "../../workflow/scripts/train.py"


rule validate_network:
    """Draw from the posterior of simulated records whose truth is known."""
    input:
        model="results/networks/{network}/{motion}.safetensors",
        code=code("validate"),
    output:
        directory("results/networks/{network}/{motion}_seed{seed}.zarr"),
    log:
        "logs/networks/{network}/validate_{motion}_seed{seed}.log",
    conda:
        "../../envs/breaker.yaml"
    params:
        curves=config["validation"]["curves"],
        draws=config["validation"]["draws"],
    script:
        "../../workflow/scripts/validate.py"


rule judge_network:
    """The network's own density, compared with the exact posterior."""
    input:
        model="results/networks/{network}/{motion}.safetensors",
        validation="results/networks/{network}/{motion}_seed{seed}.zarr",
        corrected="results/validation/{motion}_corrected_seed{seed}.zarr",
        code=code("judge"),
    output:
        store=directory("results/networks/{network}/{motion}_judged_seed{seed}.zarr"),
        table="results/networks/{network}/{motion}_judged_seed{seed}.csv",
    log:
        "logs/networks/{network}/judge_{motion}_seed{seed}.log",
    conda:
        "../../envs/breaker.yaml"
    params:
        curves=config["validation"]["judged_curves"],
    script:
        "../../workflow/scripts/judge.py"


rule compare_networks:
    """One row a network: density, divergence, efficiency, calibration, speed, size."""
    input:
        models=expand("results/networks/{network}/{{motion}}.safetensors", network=NETWORKS),
        histories=expand("results/networks/{network}/{{motion}}_history.zarr", network=NETWORKS),
        trainings=expand("results/networks/{network}/{{motion}}_train.tsv", network=NETWORKS),
        validations=expand(
            "results/networks/{network}/{{motion}}_seed{seed}.zarr", network=NETWORKS, seed=SEED
        ),
        judged=expand(
            "results/networks/{network}/{{motion}}_judged_seed{seed}.csv",
            network=NETWORKS,
            seed=SEED,
        ),
    output:
        "results/networks/{motion}.csv",
    log:
        "logs/compare_networks/{motion}.log",
    conda:
        "../../envs/breaker.yaml"
    params:
        networks=NETWORKS,
    script:
        "../scripts/compare_networks.py"
