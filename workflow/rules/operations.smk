"""How the operations of the endurance test are divided into jobs, and what each job takes.

A chunk holds the same numbers in every motion, so that appended operations run their own chunk and
no other. A life goes through all of them at once.
"""

from functools import cache

from breaker.common.text import bare
from breaker.configuration.definitions import entry_of_type, types_of
from breaker.records.folder import (
    fingerprint,
    known_of,
    list_breakers,
    list_fleet,
    list_operations,
)
from breaker.workflow.jobs import chunks_of

# Which of the operations in a table of one's own.
CHOSEN = {key: config["endurance"][key] for key in ("breaker", "phase") if OWN_CURVES}


@cache
def listed(motion):
    """The operations of a motion in a folder of one's own."""
    return list_operations(OWN_CURVES, motion, **CHOSEN, events=config["endurance"]["events"])


def numbers(motion):
    """The numbers of the operations of a motion."""
    if OWN_CURVES is None:
        return range(1, config["simulated_test"]["operations"] + 1)
    return [row.number for row in listed(motion)]


@cache
def chunks(motion=None):
    """The numbers of the operations of a motion, or of any motion, by chunk."""
    every_number = set().union(*map(numbers, [motion] if motion else MOTIONS))
    return chunks_of(every_number, config["endurance"]["operations_per_job"])


def operations(wildcards):
    """The numbers of the operations of a chunk of a motion."""
    return chunks(wildcards.motion)[wildcards.chunk]


@cache
def known():
    """Events and conditions of operations, by their number, where a table has them."""
    numbers = [number for chunk in chunks().values() for number in chunk]
    chosen = [CHOSEN["breaker"]] if BREAKERS and CHOSEN["breaker"] else None
    rows = list_fleet(OWN_CURVES, breakers=chosen, phase=CHOSEN["phase"]) if BREAKERS else {}
    return known_of((row for some in rows.values() for _, row in some), numbers)


def every_chunk(pattern):
    """A file of every chunk of the motion of the wildcards."""

    def files(wildcards):
        return [pattern.format(**wildcards, chunk=chunk) for chunk in chunks(wildcards.motion)]

    return files


def curves_of(motion):
    """The records of all operations of a motion."""

    def files(wildcards):
        return [f"results/endurance/{motion}/curves_{chunk}.zarr" for chunk in chunks(motion)]

    return files


def source(wildcards):
    """What the curves of a chunk come from: a simulation, or files of given names, sizes and times.

    A setting of the job, not its input: Snakemake would take signs in the names of files for
    patterns, and would leave standing what it finds if one of them is gone. Of the chunk's own
    files alone, so that appended operations run their own chunk and no other.
    """
    if OWN_CURVES is None:
        return "simulated"
    wanted = set(operations(wildcards))
    return fingerprint(row for row in listed(wildcards.motion) if row.number in wanted)


# ---- of a fleet ----------------------------------------------------------------------------------

BREAKERS = list_breakers(OWN_CURVES, config["endurance"]["events"]) if OWN_CURVES else []
IS_FLEET = len(BREAKERS) > 1 and config["endurance"]["breaker"] is None
TYPES = types_of(config)
FLEET = ["results/fleet.csv", "results/fleet.html"]
BREAKERS_PER_JOB = 30  # a job of minutes: appended breakers rerun at most this many
# What jobs of the fleet take from the configuration.
ON_FLEET = ("endurance", "limits", "motions", "planning", "seed", "speeds", "trend")


@cache
def rows_of_breakers():
    """Rows of the table, by breaker: listed once, for all chunks."""
    return list_fleet(OWN_CURVES, **{key: config["endurance"][key] for key in ("phase", "events")})


@cache
def types_of_breaker(breaker):
    """The types that the table states of a breaker; all known types where a row states none."""
    rows = rows_of_breakers()[breaker] if TYPES else []
    stated = {row.type for _, row in rows}
    return tuple(sorted(TYPES if "" in stated else {bare(name) for name in stated}))


def chunks_of_breakers():
    """Breakers of the same types by chunk, which is called by the place of its first breaker."""
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
    """The entries of the types in a chunk: an edit of another type does not rerun it."""
    names = {
        bare_name
        for name in CHUNKS_OF_BREAKERS[wildcards.chunk]
        for bare_name in types_of_breaker(name)
    }
    return {name: entry_of_type(TYPES, name) for name in sorted(names)}


def source_of_breakers(wildcards):
    """What the answers of a chunk come from: files of given names, sizes and times."""
    names = CHUNKS_OF_BREAKERS[wildcards.chunk]
    return fingerprint(row for name in names for _, row in rows_of_breakers()[name])
