"""The exact judge: networks held against the exact posterior, and brought to it.

Needs the draws of networks, and for the judgement the model file. Makes corrected posteriors of the
validation curves, and the figures that show how far the network was from them and what the curves
can say at all. Of simulated curves alone: for no measured one is the model right.
"""


rule correct_validation:
    """The exact posteriors of simulated records, from the network's draws."""
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
    """The network's own density, held against the exact posterior."""
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
    """How far the network's posteriors are from the exact ones, and what a curve can say at all."""
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
