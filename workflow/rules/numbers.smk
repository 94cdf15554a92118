"""Numbers stated by the README and the pages in docs/, from the tables of this run.

Needs the tables of validation and exactness, and the stores of the endurance test.
Makes one flat table. With the default configuration it is compared with docs/numbers.csv, the
source of the texts; `make numbers` renews both.
"""

STATED = config == defaults() and Path("docs/numbers.csv").exists()


rule numbers:
    """Collect all numbers of a run that a text states, by name."""
    input:
        quality=expand(f"results/quality/{{motion}}_seed{SEED}.csv", motion=MOTIONS),
        exactness=expand(f"results/exactness/{{motion}}_seed{SEED}.csv", motion=MOTIONS),
        prior=expand("results/prior_predictive/{motion}.zarr", motion=MOTIONS),
        validation=expand(f"results/validation/{{motion}}_seed{SEED}.zarr", motion=MOTIONS),
        operations=expand("results/endurance/{motion}.zarr", motion=MOTIONS),
        family=expand("results/endurance/{motion}_family.zarr", motion=MOTIONS),
        predictive=expand("results/endurance/{motion}_predictive.zarr", motion=MOTIONS),
        truth=TRUTH,
        code=code("collect_numbers"),
    output:
        "results/numbers.csv",
    log:
        "logs/numbers.log",
    benchmark:
        "results/benchmarks/numbers.tsv"
    conda:
        "../../envs/breaker.yaml"
    params:
        motions=MOTIONS,
        stated="docs/numbers.csv" if STATED else None,
    script:
        "../scripts/collect_numbers.py"
