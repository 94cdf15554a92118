"""Several breakers side by side, by the networks that ship: `all`, where none of them is chosen.

A job answers some tens of breakers, in the order in which the table names them first. Appended
operations run their own chunk, and what sums all of them up: types, ranks and the page.
"""

from breaker.files import list_breakers, list_fleet
from breaker.fleet import breaker_chunks

BREAKERS = list_breakers(OWN_CURVES) if OWN_CURVES else []
IS_FLEET = len(BREAKERS) > 1 and config["endurance"]["breaker"] is None
CHUNKS_OF_BREAKERS = breaker_chunks(BREAKERS, config["fleet"]["breakers_per_job"])
FLEET = ["results/fleet.csv", "results/fleet.html", "figures/fleet.png"]
# What jobs of the fleet take from the configuration.
ON_FLEET = ("endurance", "fleet", "limits", "motions", "planning", "seed", "speeds", "wear_model")


@cache
def rows_of(breakers):
    """Rows of the table, by breaker."""
    chosen = {key: config["endurance"][key] for key in ("phase", "events")}
    return list_fleet(OWN_CURVES, breakers=breakers, **chosen)


@cache
def source_of_breakers(chunk):
    """What the answers of a chunk come from: files of given names, sizes and times.

    The plan lists all files at once, a job those of its own breakers.
    """
    names = CHUNKS_OF_BREAKERS[chunk]
    rows = rows_of(None if snakemake_internals.is_first_process(workflow) else tuple(names))
    return fingerprint(each for name in names for _, each in rows[name])


def breaker_files(wildcards):
    """Nothing: see ``curve_files``."""
    store = f"results/fleet/chunk_{wildcards.chunk}.zarr"
    again_where_changed(store, source_of_breakers(wildcards.chunk))
    return []


rule fleet_chunk:
    """Answer some breakers: each as if it were alone."""
    input:
        breaker_files,
    output:
        directory("results/fleet/chunk_{chunk}.zarr"),
    log:
        "logs/fleet/chunk_{chunk}.log",
    params:
        **{name: config[name] for name in ON_FLEET},
        folder=OWN_CURVES,
        breakers=lambda wildcards: CHUNKS_OF_BREAKERS[wildcards.chunk],
        source=lambda wildcards: source_of_breakers(wildcards.chunk),
        sensor=GRID,
    script:
        "../scripts/fleet_chunk.py"


rule fleet:
    """What breakers of a type have in common, which is odd, and all ranked by what is due."""
    input:
        chunks=expand("results/fleet/chunk_{chunk}.zarr", chunk=CHUNKS_OF_BREAKERS),
    output:
        table=report(
            "results/fleet.csv",
            caption="../report/fleet_table.rst",
            category="8 Fleet",
            labels={"figure": "table of the fleet", "motion": "together"},
        ),
        types="results/fleet/types.csv",
        page="results/fleet.html",
        figure=page("figures/fleet.png", "8 Fleet", "fleet", "fleet"),
    log:
        "logs/fleet.log",
    params:
        prior=config["prior"],
        evidence=config["fleet"]["evidence"],
    script:
        "../scripts/fleet.py"
