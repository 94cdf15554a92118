"""How the operations of the endurance test are divided into jobs, and what each job takes.

A chunk holds the same numbers in every motion, so that appended operations run their own chunk and
no other. A life goes through all of them at once.
"""

from functools import cache

from breaker.reading.files.folder_listing import (
    fingerprint,
    list_breakers,
    list_fleet,
    list_known,
    list_once,
)
from breaker.drive.fleet.breaker_chunks import breaker_chunks
from breaker.workflow.chunks import chunks_of, recorded_source

STAND_IN = "stand-in"
# Which of the operations in a table of one's own.
CHOSEN = {key: config["endurance"][key] for key in ("breaker", "phase") if OWN_CURVES}


def listed(motion):
    """The operations of a motion in a folder of one's own, as the check listed them."""
    events = sorted(config["endurance"]["events"])
    return list_once(OWN_CURVES, motion, CHOSEN["breaker"], CHOSEN["phase"], *events)


def numbers(motion):
    """The numbers of the operations of a motion."""
    if OWN_CURVES is None:
        return range(1, config["rig"]["operations"] + 1)
    return [each.number for each in listed(motion)]


@cache
def chunks(motion=None):
    """The numbers of the operations of a motion, or of any motion, by chunk."""
    found = set().union(*map(numbers, [motion] if motion else MOTIONS))
    return chunks_of(found, config["endurance"]["operations_per_job"])


def operations(wildcards):
    """The numbers of the operations of a chunk: in the motion of the wildcards, or in any."""
    return chunks(wildcards.get("motion"))[wildcards.chunk]


@cache
def known():
    """Events and conditions of operations, by their number, where a table has them."""
    numbers = [number for chunk in chunks().values() for number in chunk]
    return list_known(OWN_CURVES, numbers, **CHOSEN) if OWN_CURVES else ({}, {})


def every_chunk(pattern):
    """A file of every chunk of the motion of the wildcards, or of any."""

    def files(wildcards):
        return [pattern.format(**wildcards, chunk=c) for c in chunks(wildcards.get("motion"))]

    return files


@cache
def source_of(motion, chunk):
    """What the curves of a chunk come from: the stand-in, or files of given names, sizes and times.

    Of the chunk's own files alone, so that appended operations run their own chunk and no other.
    """
    if OWN_CURVES is None:
        return STAND_IN
    wanted = set(chunks(motion)[chunk])
    return fingerprint(each for each in listed(motion) if each.number in wanted)


def source(wildcards):
    return source_of(wildcards.motion, wildcards.chunk)


def curve_files(wildcards):
    """The folder of the stand-in's curves, which the workflow makes.

    Files of one's own are no inputs: Snakemake would take signs in their names for patterns, and
    would leave standing what it finds if one of them is gone. Curves of another source are read
    again, even where Snakemake's own notes on the last run are lost.
    """
    store = f"results/endurance/{wildcards.motion}/curves_{wildcards.chunk}.zarr"
    again_where_changed(store, source(wildcards))
    return [] if OWN_CURVES else f"results/rig/curves/{wildcards.motion}"


def again_where_changed(store, source):
    """Make a store again that comes from another source."""
    first, store = snakemake_internals.is_first_process(workflow), placed(store)
    if first and recorded_source(store) != source:
        snakemake_internals.make_again(workflow, store)


def curves_of(motion):
    """The records of all operations of a motion."""

    def files(wildcards):
        return [f"results/endurance/{motion}/curves_{chunk}.zarr" for chunk in chunks(motion)]

    return files


# ---- of a fleet ----------------------------------------------------------------------------------

BREAKERS = list_breakers(OWN_CURVES) if OWN_CURVES else []
IS_FLEET = len(BREAKERS) > 1 and config["endurance"]["breaker"] is None
CHUNKS_OF_BREAKERS = breaker_chunks(BREAKERS, config["fleet"]["breakers_per_job"])
FLEET = ["results/fleet.csv", "results/fleet.html", "figures/fleet.png"]
# What jobs of the fleet take from the configuration.
ON_FLEET = ("endurance", "fleet", "limits", "limits_by_type", "motions")
ON_FLEET += ("planning", "seed", "speeds", "wear_model")


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
