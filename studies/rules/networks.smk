"""Every network of the paper against every other.

Needs the banks, and the corrected validation for the evidence. Makes a model of each combination of
`summaries` and `inferences` of studies/config.yaml, one table and one figure a motion; and, of the
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
        training=training_of,
        solver=config["solver"],
        bank=config["bank"],
        checkpoint="checkpoints/{network}_{motion}.pt",


use rule validate as validate_network with:
    input:
        model="results/networks/{network}/{motion}.safetensors",
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
    output:
        page(
            "results/networks/{motion}.csv",
            "7 Networks",
            "table of the networks",
            "networks_table",
        ),
    log:
        "logs/compare_networks/{motion}.log",
    conda:
        "../../envs/breaker.yaml"
    params:
        networks=NETWORKS,
    script:
        "../scripts/compare_networks.py"


# All networks of one motion side by side.
figure("networks", "7 Networks", table="results/networks/{motion}.csv")


rule validate_missing:
    """The same simulated records, with samples missing at random."""
    input:
        model="results/networks/{network}/{motion}.safetensors",
        whole="results/networks/{network}/{motion}_seed{seed}.zarr",
    output:
        directory("results/networks/{network}/{motion}_missing_seed{seed}.zarr"),
    log:
        "logs/networks/{network}/validate_missing_{motion}_seed{seed}.log",
    conda:
        "../../envs/breaker.yaml"
    params:
        share=COMPARISON["missing"],
    script:
        "../scripts/validate_missing.py"


use rule correct_validation as correct_missing with:
    input:
        validation="results/networks/{network}/{motion}_missing_seed{seed}.zarr",
    output:
        directory("results/networks/{network}/{motion}_missing_corrected_seed{seed}.zarr"),
    log:
        "logs/networks/{network}/correct_missing_{motion}_seed{seed}.log",
    benchmark:
        "results/networks/{network}/{motion}_seed{seed}_correct_missing.tsv"


# Are posteriors from records with missing samples calibrated, and wider where they should be?
figure(
    "missing",
    "7 Networks",
    label="missing samples, {network}",
    of="_{network}_{motion}",
    whole=f"results/networks/{{network}}/{{motion}}_seed{SEED}.zarr",
    missing=f"results/networks/{{network}}/{{motion}}_missing_seed{SEED}.zarr",
    exact_whole=f"results/validation/{{motion}}_corrected_seed{SEED}.zarr",
    exact_missing=f"results/networks/{{network}}/{{motion}}_missing_corrected_seed{SEED}.zarr",
    params={"share": COMPARISON["missing"]},
)


# The scripts of rules that are used anew stay where those of the workflow are.
USED_ANEW = {
    "train_network": "train",
    "validate_network": "validate",
    "judge_network": "judge",
    "correct_missing": "correct_validation",
}
snakemake_internals.keep_scripts(workflow, USED_ANEW)
