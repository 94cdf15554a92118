"""Several breakers side by side, by the networks that ship: `all`, where none of them is chosen.

A job answers some tens of breakers, in the order in which the table names them first. Appended
operations run their own chunk, and what sums all of them up: types, ranks and the page.
"""


rule fleet_chunk:
    """Answer some breakers: each as if it were alone."""
    input:
        code=code("fleet_chunk"),
    output:
        directory("results/fleet/chunk_{chunk}.zarr"),
    log:
        "logs/fleet/chunk_{chunk}.log",
    benchmark:
        "results/benchmarks/fleet_chunk_{chunk}.tsv"
    conda:
        "../../envs/breaker.yaml"
    params:
        **{name: config[name] for name in ON_FLEET},
        folder=OWN_CURVES,
        types=types_of_chunk,
        breakers=lambda wildcards: CHUNKS_OF_BREAKERS[wildcards.chunk],
        source=source_of_breakers,
        sensor=GRID,
        networks=shipped_networks,
    script:
        "../scripts/fleet_chunk.py"


rule fleet:
    """What breakers of a type have in common, which is odd, and all ranked by what is due."""
    input:
        chunks=expand("results/fleet/chunk_{chunk}.zarr", chunk=CHUNKS_OF_BREAKERS),
        code=code("fleet"),
    output:
        table=page("results/fleet.csv", "7 Fleet", "table of the fleet", "fleet_table"),
        types="results/fleet/types.csv",
        page="results/fleet.html",
        figure=page("figures/fleet.png", "7 Fleet", "fleet", "fleet"),
    log:
        "logs/fleet.log",
    benchmark:
        "results/benchmarks/fleet.tsv"
    conda:
        "../../envs/breaker.yaml"
    params:
        prior=config["prior"],
    script:
        "../scripts/fleet.py"
