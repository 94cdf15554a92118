"""Every network of the paper against every other, outside of `all`.

Needs the banks, and the corrected validation for the evidence. Makes a model of each combination of
`comparison.summaries` and `comparison.inferences`, one table and one figure a motion; and, of the
networks that take missing samples, what becomes of their posteriors when samples are missing.
"""


use rule train as train_network with:
    output:
        model="results/networks/{network}/{motion}.safetensors",
        history=directory("results/networks/{network}/{motion}_history.zarr"),
        solver=directory("results/networks/{network}/{motion}_solver.zarr"),
    log:
        "logs/networks/{network}/train_{motion}.log",
    benchmark:
        "results/networks/{network}/{motion}_train.tsv"
    params:
        seed=config["seed"],
        prior=config["prior"],
        sensor=config["sensor"],
        network=network_of,
        training=lambda wildcards: {
            **config["training"][wildcards.motion],
            "steps": config["comparison"]["steps"],
        },
        solver=config["solver"],
        bank_curves=config["bank"]["shards"] * config["bank"]["curves_per_shard"],
        checkpoint="checkpoints/{network}_{motion}.pt",


use rule validate as validate_network with:
    input:
        model="results/networks/{network}/{motion}.safetensors",
        code=sources("validate.py"),
    output:
        directory("results/networks/{network}/{motion}_seed{seed}.zarr"),
    log:
        "logs/networks/{network}/validate_{motion}_seed{seed}.log",
    benchmark:
        "results/networks/{network}/{motion}_seed{seed}_validate.tsv"


use rule judge as judge_network with:
    input:
        model="results/networks/{network}/{motion}.safetensors",
        validation="results/networks/{network}/{motion}_seed{seed}.zarr",
        corrected="results/validation/{motion}_corrected_seed{seed}.zarr",
        code=sources("judge.py"),
    output:
        store=directory("results/networks/{network}/{motion}_judged_seed{seed}.zarr"),
        table="results/networks/{network}/{motion}_judged_seed{seed}.csv",
    log:
        "logs/networks/{network}/judge_{motion}_seed{seed}.log",
    benchmark:
        "results/networks/{network}/{motion}_seed{seed}_judge.tsv"


rule compare_networks:
    """One row a network: density, gap, efficiency, calibration, speed, size."""
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
        code=sources("compare_networks.py"),
    output:
        report(
            "results/networks/{motion}.csv",
            caption="../report/networks_table.rst",
            category="8 Networks",
            labels={"figure": "table of the networks", "motion": "{motion}"},
        ),
    log:
        "logs/compare_networks/{motion}.log",
    conda:
        ENVIRONMENT
    params:
        networks=NETWORKS,
    script:
        "../scripts/compare_networks.py"


rule figure_networks:
    """All networks of one motion side by side."""
    input:
        table="results/networks/{motion}.csv",
        code=sources("figure_networks.py"),
    output:
        report(
            "figures/networks_{motion}.png",
            caption="../report/networks.rst",
            category="8 Networks",
            labels={"figure": "networks", "motion": "{motion}"},
        ),
    log:
        "logs/figures/networks_{motion}.log",
    conda:
        ENVIRONMENT
    script:
        "../scripts/figure_networks.py"


rule validate_missing:
    """The same simulated records, with samples missing at random."""
    input:
        model="results/networks/{network}/{motion}.safetensors",
        code=sources("validate.py"),
    output:
        directory("results/networks/{network}/{motion}_missing_seed{seed}.zarr"),
    log:
        "logs/networks/{network}/validate_missing_{motion}_seed{seed}.log",
    conda:
        ENVIRONMENT
    params:
        curves=config["validation"]["curves"],
        draws=config["validation"]["draws"],
        missing=config["comparison"]["missing"],
    script:
        "../scripts/validate.py"


use rule correct_validation as correct_missing with:
    input:
        validation="results/networks/{network}/{motion}_missing_seed{seed}.zarr",
        code=sources("correct_validation.py"),
    output:
        directory("results/networks/{network}/{motion}_missing_corrected_seed{seed}.zarr"),
    log:
        "logs/networks/{network}/correct_missing_{motion}_seed{seed}.log",
    benchmark:
        "results/networks/{network}/{motion}_seed{seed}_correct_missing.tsv"


rule figure_missing:
    """Are posteriors from records with missing samples calibrated, and wider where they should be?"""
    input:
        whole=f"results/networks/{{network}}/{{motion}}_seed{SEED}.zarr",
        missing=f"results/networks/{{network}}/{{motion}}_missing_seed{SEED}.zarr",
        exact_whole=f"results/validation/{{motion}}_corrected_seed{SEED}.zarr",
        exact_missing=f"results/networks/{{network}}/{{motion}}_missing_corrected_seed{SEED}.zarr",
        code=sources("figure_missing.py"),
    output:
        report(
            "figures/missing_{network}_{motion}.png",
            caption="../report/missing.rst",
            category="8 Networks",
            labels={"figure": "missing samples, {network}", "motion": "{motion}"},
        ),
    log:
        "logs/figures/missing_{network}_{motion}.log",
    conda:
        ENVIRONMENT
    params:
        share=config["comparison"]["missing"],
    script:
        "../scripts/figure_missing.py"
