"""The exact judge: networks held against the exact posterior, and brought to it.

Needs the draws of networks, and for the judgement the model file. Makes corrected posteriors of the
validation curves and of every operation, and the figures that show how far the network was from
them and what the curves can say at all.
"""


rule correct_validation:
    """The exact posteriors of simulated records, from the network's draws."""
    input:
        validation="results/validation/{motion}_seed{seed}.zarr",
        code=sources("correct_validation.py"),
    output:
        directory("results/validation/{motion}_corrected_seed{seed}.zarr"),
    log:
        "logs/correct_validation/{motion}_seed{seed}.log",
    benchmark:
        "results/benchmarks/correct_validation_{motion}_seed{seed}.tsv"
    conda:
        ENVIRONMENT
    params:
        prior=config["prior"],
        sensor=config["sensor"],
        correction=config["correction"],
    script:
        "../scripts/correct_validation.py"


rule judge:
    """The network's own density, held against the exact posterior."""
    input:
        model="results/models/{motion}.safetensors",
        validation="results/validation/{motion}_seed{seed}.zarr",
        corrected="results/validation/{motion}_corrected_seed{seed}.zarr",
        code=sources("judge.py"),
    output:
        store=directory("results/exactness/{motion}_seed{seed}.zarr"),
        table=report(
            "results/exactness/{motion}_seed{seed}.csv",
            caption="../report/exactness_table.rst",
            category="4 Exactness",
            labels={"figure": "table of the exactness", "motion": "{motion}"},
        ),
    log:
        "logs/judge/{motion}_seed{seed}.log",
    benchmark:
        "results/benchmarks/judge_{motion}_seed{seed}.tsv"
    conda:
        ENVIRONMENT
    params:
        curves=config["validation"]["judged_curves"],
    script:
        "../scripts/judge.py"


rule correct_operations:
    """The exact posteriors of some operations, from the network's draws."""
    input:
        inferred="results/endurance/{motion}/inferred_{chunk}.zarr",
        code=sources("correct_operations.py"),
    output:
        directory("results/endurance/{motion}/corrected_{chunk}.zarr"),
    log:
        "logs/correct_operations/{motion}_{chunk}.log",
    benchmark:
        "results/benchmarks/correct_operations_{motion}_{chunk}.tsv"
    conda:
        ENVIRONMENT
    params:
        seed=config["seed"],
        prior=config["prior"],
        sensor=config["sensor"],
        correction=config["correction"],
        misfit_p_value=config["endurance"]["misfit_p_value"],
    script:
        "../scripts/correct_operations.py"


rule figure_exactness:
    """How far the network's posteriors are from the exact ones, curve by curve."""
    input:
        judged=f"results/exactness/{{motion}}_seed{SEED}.zarr",
        amortised=f"results/validation/{{motion}}_seed{SEED}.zarr",
        corrected=f"results/validation/{{motion}}_corrected_seed{SEED}.zarr",
        code=sources("figure_exactness.py"),
    output:
        report(
            "figures/exactness_{motion}.png",
            caption="../report/exactness.rst",
            category="4 Exactness",
            labels={"figure": "exactness", "motion": "{motion}"},
        ),
    log:
        "logs/figures/exactness_{motion}.log",
    conda:
        ENVIRONMENT
    script:
        "../scripts/figure_exactness.py"


rule figure_identifiability:
    """How well a curve determines each parameter, and how much of it posteriors reach."""
    input:
        limit="results/identifiability/{motion}.zarr",
        amortised=f"results/validation/{{motion}}_seed{SEED}.zarr",
        corrected=f"results/validation/{{motion}}_corrected_seed{SEED}.zarr",
        drive="results/endurance/{motion}.zarr",
        code=sources("figure_identifiability.py"),
    output:
        report(
            "figures/identifiability_{motion}.png",
            caption="../report/identifiability.rst",
            category="4 Exactness",
            labels={"figure": "identifiability", "motion": "{motion}"},
        ),
    log:
        "logs/figures/identifiability_{motion}.log",
    conda:
        ENVIRONMENT
    params:
        prior=config["prior"],
        onset_sd=config["sensor"]["onset_sd"],
    script:
        "../scripts/figure_identifiability.py"
