"""Correction to the exact posterior, and divergence of the networks from it.

Needs the draws of networks, and for the divergence the model file. Makes corrected posteriors of
the validation curves, and figures of the divergence and of the parameters that a curve determines.
Only simulated curves are used, because the model is not exact for measured ones.
"""


rule correct_validation:
    """Correct the network's draws to the exact posteriors of simulated records."""
    input:
        validation="results/validation/{motion}_seed{seed}.zarr",
        code=code("correct_validation"),
    output:
        directory("results/validation/{motion}_corrected_seed{seed}.zarr"),
    log:
        "logs/correct_validation/{motion}_seed{seed}.log",
    benchmark:
        "results/benchmarks/correct_validation_{motion}_seed{seed}.tsv"
    conda:
        "../../envs/breaker.yaml"
    params:
        model=MODEL,
        prior=config["prior"],
        sensor=config["sensor"],
        rounds=config["validation"]["correction_rounds"],
    script:
        "../scripts/correct_validation.py"


rule judge:
    """Compare the network's density with the exact posterior."""
    input:
        model="results/models/{motion}.safetensors",
        validation="results/validation/{motion}_seed{seed}.zarr",
        corrected="results/validation/{motion}_corrected_seed{seed}.zarr",
        code=code("judge"),
    output:
        store=directory("results/exactness/{motion}_seed{seed}.zarr"),
        table=page(
            "results/exactness/{motion}_seed{seed}.csv",
            "4 Exactness",
            "table of the exactness",
            "exactness_table",
        ),
    log:
        "logs/judge/{motion}_seed{seed}.log",
    benchmark:
        "results/benchmarks/judge_{motion}_seed{seed}.tsv"
    conda:
        "../../envs/breaker.yaml"
    params:
        curves=config["validation"]["judged_curves"],
    script:
        "../scripts/judge.py"


rule figures_exactness:
    """Draw the divergence from exact posteriors, and the parameters that a curve determines."""
    input:
        judged=f"results/exactness/{{motion}}_seed{SEED}.zarr",
        limit="results/identifiability/{motion}.zarr",
        amortised=f"results/validation/{{motion}}_seed{SEED}.zarr",
        corrected=f"results/validation/{{motion}}_corrected_seed{SEED}.zarr",
        code=code("figures_exactness"),
    output:
        exactness=page("figures/exactness_{motion}.png", "4 Exactness", "exactness", "exactness"),
        identifiability=page(
            "figures/identifiability_{motion}.png",
            "4 Exactness",
            "identifiability",
            "identifiability",
        ),
    log:
        "logs/figures/exactness_{motion}.log",
    benchmark:
        "results/benchmarks/figures_exactness_{motion}.tsv"
    conda:
        "../../envs/breaker.yaml"
    script:
        "../scripts/figures_exactness.py"
