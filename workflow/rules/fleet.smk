"""A fleet: several breakers, each examined by shipped networks, and one table of all.

A job examines some breakers of the same types. Appended operations and edited types rerun the jobs
of their breakers, and the table.
"""


rule fleet_chunk:
    """Examine some breakers, each without the others."""
    input:
        code=code("fleet_chunk"),
    output:
        "results/fleet/chunk_{chunk}.json",
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
    """Write the table of all drives with their types, the most urgent first."""
    input:
        chunks=expand("results/fleet/chunk_{chunk}.json", chunk=CHUNKS_OF_BREAKERS),
        code=code("fleet"),
    output:
        table=page("results/fleet.csv", "7 Fleet", "table of the fleet", "fleet_table"),
        page="results/fleet.html",
    log:
        "logs/fleet.log",
    benchmark:
        "results/benchmarks/fleet.tsv"
    conda:
        "../../envs/breaker.yaml"
    script:
        "../scripts/fleet.py"
