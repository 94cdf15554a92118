"""The numbers that the README and the pages in docs/ state, from the tables of this run, and what these tables are.

Needs the tables of validation and exactness, and the stores and decisions of the endurance test. Makes one flat
table. With the default configuration it is compared with docs/numbers.csv, the table that the texts
are written from; `make numbers` renews both. A data package says to others what each table and column is.
"""

from breaker.shipped import DEFAULTS

IS_DEFAULT = config == configuration.read(DEFAULTS)


rule numbers:
    """Every number of a run that a text states, by name."""
    input:
        quality=expand(f"results/quality/{{motion}}_seed{SEED}.csv", motion=MOTIONS),
        exactness=expand(f"results/exactness/{{motion}}_seed{SEED}.csv", motion=MOTIONS),
        prior=expand("results/prior_predictive/{motion}.zarr", motion=MOTIONS),
        validation=expand(f"results/validation/{{motion}}_seed{SEED}.zarr", motion=MOTIONS),
        operations=expand("results/endurance/{motion}.zarr", motion=MOTIONS),
        family=expand("results/endurance/{motion}_family.zarr", motion=MOTIONS),
        predictive=expand("results/endurance/{motion}_predictive.zarr", motion=MOTIONS),
        truth=TRUTH,
        life="results/life.zarr",
        limits="results/limits.csv",
        decisions="results/decisions.csv",
    output:
        "results/numbers.csv",
    log:
        "logs/numbers.log",
    conda:
        "../../envs/breaker.yaml"
    params:
        motions=MOTIONS,
        limits=config["limits"],
        speeds=SPEEDS,
        stated="docs/numbers.csv" if IS_DEFAULT and Path("docs/numbers.csv").exists() else None,
    script:
        "../scripts/collect_numbers.py"


TABLES = {
    **{name: f"results/{name}.csv" for name in ("decisions", "limits", "changes", "numbers")},
    "operations": expand("results/endurance/{motion}.csv", motion=MOTIONS),
    "quality": expand(f"results/quality/{{motion}}_seed{SEED}.csv", motion=MOTIONS),
    "exactness": expand(f"results/exactness/{{motion}}_seed{SEED}.csv", motion=MOTIONS),
}
TABLES_OF_FLEET = {"fleet": "results/fleet.csv", "types": "results/fleet/types.csv"}


rule data_package:
    """What each table of a run is, as a tabular data package of Frictionless Data."""
    input:
        **(TABLES_OF_FLEET if IS_FLEET else TABLES),
    output:
        "results/datapackage.json",
    log:
        "logs/data_package.log",
    conda:
        "../../envs/breaker.yaml"
    script:
        "../scripts/data_package.py"
