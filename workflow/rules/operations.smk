"""Division of the operations of the endurance test into jobs, and inputs of the jobs.

A chunk contains the same numbers in every motion, and appended operations only rerun their own
chunk. A life processes all operations in one job.
"""

from functools import cache

from breaker.common.clean_text import bare
from breaker.configuration.data_files import entry_of_type, types_of
from breaker.records.folder import fingerprint, known_of, list_fleet, list_operations, table_rows
from breaker.workflow.jobs import chunks_of

# Choice among the operations of the user's table.
CHOSEN = {key: config["endurance"][key] for key in ("breaker", "phase") if OWN_CURVES}


@cache
def listed(motion):
    """Return the operations of a motion in the user's folder."""
    return list_operations(OWN_CURVES, motion, **CHOSEN)


def numbers(motion):
    """Return the numbers of the operations of a motion."""
    if OWN_CURVES is None:
        return range(1, config["simulated_test"]["operations"] + 1)
    return [row.number for row in listed(motion)]


@cache
def chunks(motion=None):
    """Return the numbers of the operations of a motion, or of any motion, by chunk."""
    every_number = set().union(*map(numbers, [motion] if motion else MOTIONS))
    return chunks_of(every_number, config["endurance"]["operations_per_job"])


def operations(wildcards):
    """Return the numbers of the operations of a chunk of a motion."""
    return chunks(wildcards.motion)[wildcards.chunk]


@cache
def known():
    """Return events and conditions of operations by number, from the table if it has them."""
    numbers = [number for chunk in chunks().values() for number in chunk]
    chosen = [CHOSEN["breaker"]] if BREAKERS and CHOSEN["breaker"] else None
    rows = list_fleet(OWN_CURVES, breakers=chosen, phase=CHOSEN["phase"]) if BREAKERS else {}
    return known_of((row for listed_rows in rows.values() for _, row in listed_rows), numbers)


def every_chunk(pattern):
    """Return a function for the files of all chunks of the motion of the wildcards."""

    def files(wildcards):
        return [pattern.format(**wildcards, chunk=chunk) for chunk in chunks(wildcards.motion)]

    return files


def curves_of(motion):
    """Return a function for the records of all operations of a motion."""

    def files(wildcards):
        return [f"results/endurance/{motion}/curves_{chunk}.zarr" for chunk in chunks(motion)]

    return files


def source(wildcards):
    """Return the source of the curves of a chunk: a simulation, or names, sizes and times of files.

    This is a setting of the job instead of an input, because Snakemake interprets characters in
    file names as patterns, and keeps results if a file disappears. It covers only files of the
    chunk, so that appended operations only rerun their own chunk.
    """
    if OWN_CURVES is None:
        return "simulated"
    wanted = set(operations(wildcards))
    return fingerprint(row for row in listed(wildcards.motion) if row.number in wanted)


# ---- fleet ---------------------------------------------------------------------------------------

BREAKERS = [*dict.fromkeys(row.breaker for _, row in table_rows(OWN_CURVES))] if OWN_CURVES else []
IS_FLEET = len(BREAKERS) > 1 and config["endurance"]["breaker"] is None
TYPES = types_of(config)
FLEET = ["results/fleet.csv", "results/fleet.html"]
BREAKERS_PER_JOB = 30  # sets the time of a job to minutes; a new breaker reruns at most 30
# Sections of the configuration for jobs of the fleet.
ON_FLEET = ("endurance", "limits", "motions", "planning", "seed", "speeds", "trend")


@cache
def rows_of_breakers():
    """Return the rows of the table by breaker, listed once for all chunks."""
    return list_fleet(OWN_CURVES, phase=CHOSEN["phase"])


@cache
def types_of_breaker(breaker):
    """Return the types of a breaker in the table, or all known types if a row states none."""
    rows = rows_of_breakers()[breaker] if TYPES else []
    stated = {row.type for _, row in rows}
    return tuple(sorted(TYPES if "" in stated else {bare(name) for name in stated}))


def chunks_of_breakers():
    """Return breakers of the same types by chunk, named by the index of its first breaker."""
    groups, by_chunk = {}, {}
    for place, breaker in enumerate(BREAKERS):
        groups.setdefault(types_of_breaker(breaker), []).append((place, breaker))
    for group in groups.values():
        for k in range(0, len(group), BREAKERS_PER_JOB):
            chunk = group[k : k + BREAKERS_PER_JOB]
            by_chunk[f"{chunk[0][0]:03d}"] = [breaker for _, breaker in chunk]
    return by_chunk


CHUNKS_OF_BREAKERS = chunks_of_breakers() if IS_FLEET else {}


def types_of_chunk(wildcards):
    """Return the entries of the types in a chunk, so that edits of other types do not rerun it."""
    names = {
        bare_name
        for name in CHUNKS_OF_BREAKERS[wildcards.chunk]
        for bare_name in types_of_breaker(name)
    }
    return {name: entry_of_type(TYPES, name) for name in sorted(names)}


def source_of_breakers(wildcards):
    """Return the source of the results of a chunk: names, sizes and times of files."""
    names = CHUNKS_OF_BREAKERS[wildcards.chunk]
    return fingerprint(row for name in names for _, row in rows_of_breakers()[name])
